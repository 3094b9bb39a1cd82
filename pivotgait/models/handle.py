"""Places on a tool's handle, given by a distance along it and an angle around it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pivotgait.exceptions import SceneError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.coal_shapes import ball_distance
from pivotgait.models.raycast import inside_span, outward_normal
from pivotgait.models.shape import Shape

_JOINED = 1e-9  # [m] shapes closer than this along a ray count as one body
_PROBE = 1e-3  # [m] radius of the probe ball and its gap to the surface
_PLACE_TOLERANCE, _DIRECTION_TOLERANCE = 1e-6, 1e-3


@dataclass(frozen=True, eq=False)
class SurfacePoint(FrozenArrays):
    """A point of the tool's surface, both arrays in the tool frame.

    Attributes:
        point: (3,) [m].
        normal: (3,) unit, inward.
    """

    point: Array
    normal: Array


@dataclass(frozen=True, eq=False)
class Handle(FrozenArrays):
    """A handle: some of the tool's shapes and the axis through them, in the tool frame.

    Attributes:
        shapes: primitives that form the handle.
        origin: (3,) where ``along`` is 0 [m].
        axis: (3,) unit direction of growing ``along``.
        zero: (3,) unit direction, normal to ``axis``, where ``around`` is 0; the angle grows
            right-handed about ``axis``.
    """

    shapes: tuple[Shape, ...]
    origin: Array
    axis: Array
    zero: Array

    @property
    def extent(self) -> tuple[float, float]:
        """Least and largest ``along`` [m] at which the axis is inside some shape."""
        spans = [inside_span(shape, self.origin, self.axis) for shape in self.shapes]
        return min(low for low, _ in spans), max(high for _, high in spans)

    def place(self, along: float, around: float, *, where: str = "handle") -> SurfacePoint:
        """The point where a ray from the axis leaves the union of the handle's shapes.

        Args:
            along: along the axis [m].
            around: about the axis [rad].
            where: name of the place in messages.

        Raises:
            SceneError: for numbers that are not finite, off the handle's ends, or on an edge,
                where the normal is not unique.
        """
        if not np.isfinite([along, around]).all():
            what = f"the place {along:g} m along, {around:g} rad around is not finite"
            raise SceneError(what, where=where, mend="give finite numbers")
        start = self.origin + along * self.axis
        out = np.cos(around) * self.zero + np.sin(around) * np.cross(self.axis, self.zero)
        reach = self._reach(start, out)
        if reach is None:
            raise self._off(along, where)
        point = start + reach * out
        touched = [
            outward_normal(shape, point)
            for shape in self.shapes
            if abs(inside_span(shape, start, out)[1] - reach) < _JOINED
        ]
        normal = touched[0]
        if normal is None or any(n is None or n @ normal < 1.0 - 1e-6 for n in touched):
            raise SceneError(
                f"the place {along:g} m along, {np.degrees(around):g} deg around is on an edge",
                where=where,
                mend="move it by a millimetre or a degree onto a face",
            )
        return SurfacePoint(point, -normal)

    def _reach(self, start: Array, out: Array) -> float | None:
        """How far the ray stays inside the union [m]; None if it does not start inside."""
        spans = [inside_span(shape, start, out) for shape in self.shapes]
        reach, grown = 0.0, any(low <= 0.0 <= high for low, high in spans)
        if not grown:
            return None
        while grown:
            farther = [high for low, high in spans if low <= reach + _JOINED and high > reach]
            grown, reach = bool(farther), max(farther, default=reach)
        return reach

    def _off(self, along: float, where: str) -> SceneError:
        low, high = self.extent
        if low > high:
            mend = "move origin_m or axis so that the axis runs through the shapes"
            return SceneError("the handle's axis misses its shapes", where=where, mend=mend)
        what = f"along_m {along:g} is off the handle"
        return SceneError(what, where=where, mend=f"choose it within {low:.4f} to {high:.4f}")


def verify_place(place: SurfacePoint, shapes: tuple[Shape, ...], *, where: str) -> None:
    """Check a place with Coal: a probe ball outside it must see this point and this normal.

    The probe hovers over the point along the outward normal. Its distance to the nearest of
    ``shapes`` must equal the gap, and the nearest points must lie along the normal; otherwise
    the place is buried in another shape or the normal is wrong.

    Raises:
        SceneError: if Coal sees another surface there.
    """
    centre = place.point - 2.0 * _PROBE * place.normal
    seen = [(*ball_distance(shape, centre, _PROBE), shape.name) for shape in shapes]
    distance, on_shape, on_ball, name = min(seen, key=lambda entry: entry[0])
    inward = (on_shape - on_ball) / max(abs(distance), 1e-12)
    agrees = (
        abs(distance - _PROBE) < _PLACE_TOLERANCE
        and float(np.linalg.norm(inward - place.normal)) < _DIRECTION_TOLERANCE
    )
    if not agrees:
        raise SceneError(
            f"the place is hidden by shape {name!r} of the tool",
            where=where,
            mend="move the contact away from that shape",
        )
