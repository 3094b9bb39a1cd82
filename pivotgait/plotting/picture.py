"""One moment of a gait as a picture: table, tool, fingertips, forces and cones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame
from pivotgait.margins.gait import LEAST_FORCE_N
from pivotgait.plans.plan import ContactTrack, GaitPlan, Phase
from pivotgait.plotting import mesh
from pivotgait.plotting.ground import draw_ground
from pivotgait.plotting.render import Camera, Surface, paint
from pivotgait.plotting.shapes import tool_surfaces
from pivotgait.plotting.style import contact_colours

Array = NDArray[np.float64]
TIP_RADIUS = 0.007
"""Radius of the fingertips as drawn [m]; a plan does not tell theirs."""
LONGEST_ARROW = 0.060
"""Length of the largest force's arrow [m]."""
_CONE_HEIGHT = 0.030
_SHAFT = 0.0022
_LEAST_HEIGHT = 0.75
_ROOM = np.array([0.28, 0.08])


@dataclass(frozen=True, eq=False)
class Moment:
    """One sample of a phase."""

    phase: Phase
    sample: int

    @property
    def time(self) -> float:
        """Seconds from the start of the phase."""
        return float(self.phase.time[self.sample] - self.phase.time[0])

    @property
    def position(self) -> Array:
        """(3,) the tool's centre of mass in the world [m]."""
        return np.asarray(self.phase.tool.position[self.sample])

    def place(self, points: Array) -> Array:
        """World coordinates (..., 3) [m] of points of the tool frame."""
        turn = self.phase.tool.rotation[self.sample].as_matrix()
        return np.asarray(points @ turn.T + self.position)

    def contact(self, track: ContactTrack) -> tuple[Array, Array, Array]:
        """Point [m], inward normal and force [N] (3,) of a contact in the world."""
        motion = self.phase.tool
        return (
            track.world_point(motion)[self.sample],
            track.world_normal(motion)[self.sample],
            track.force[self.sample],
        )


@dataclass(frozen=True, eq=False)
class Look:
    """What the pictures of one figure share.

    Attributes:
        camera: the point of view.
        tool: surfaces of the tool in its own frame.
        colours: by contact.
        metres_per_newton: length of the arrows.
        table_height: world z of the table [m].
    """

    camera: Camera
    tool: tuple[Surface, ...]
    colours: dict[str, str]
    metres_per_newton: float
    table_height: float


def look_at(plan: GaitPlan, moments: Sequence[Moment]) -> Look:
    """A point of view before the tip and above it: a lifted tool shows both its sides there."""
    middle = moments[len(moments) // 2]
    towards_tip = middle.place(plan.tool.pivot_in_tool) - middle.position
    azimuth = np.arctan2(towards_tip[1], towards_tip[0])
    largest = max(
        float(np.linalg.norm(track.force, axis=1).max())
        for moment in moments
        for track in moment.phase.contacts.values()
    )
    return Look(
        Camera.looking_from(float(azimuth) + np.radians(48.0), np.radians(33.0)),
        tool_surfaces(plan.tool),
        contact_colours(plan),
        LONGEST_ARROW / max(largest, LEAST_FORCE_N),
        plan.table_height,
    )


def draw_moment(axes: Any, look: Look, moment: Moment) -> None:
    """Draw one moment on 2D ``axes``, whose limits are set and keep both axes' scale equal."""
    bodies = [Surface(moment.place(s.faces), s.colour) for s in look.tool]
    draw_ground(axes, look.camera, look.table_height, bodies)
    for track in moment.phase.contacts.values():
        bodies += _contact_surfaces(look, moment, track)
    paint(axes, look.camera, bodies)
    axes.set_aspect("equal")
    axes.set_axis_off()


def frame(look: Look, moments: Sequence[Moment], *, close: bool) -> Array:
    """Lower left and upper right corner (2, 2) [m] of pictures that hold all ``moments``.

    Around the fingers if ``close``, else around everything.
    """
    points: list[Array] = []
    for moment in moments:
        for track in moment.phase.contacts.values():
            if not (close and track.is_pivot):
                points += arrow_ends(look, moment, track)
        if not close:
            points += [corner for s in look.tool for corner in moment.place(s.faces).reshape(-1, 3)]
    flat = look.camera.project(np.array(points))[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    pad = _ROOM * (high - low) + 0.01  # for the names beside the arrows
    return _not_flatter(low - pad, high + pad)


def _not_flatter(low: Array, high: Array) -> Array:
    """Corners (2, 2) of a box, made higher if it is flatter than a picture should be."""
    least = _LEAST_HEIGHT * (high[0] - low[0])
    grow = np.array([0.0, max(0.0, least - (high[1] - low[1])) / 2])
    return np.stack((low - grow, high + grow))


def _aligned(faces: Array, direction: Array, origin: Array) -> Array:
    return np.asarray(faces @ contact_frame(direction).T + origin)


def arrow_ends(look: Look, moment: Moment, track: ContactTrack) -> tuple[Array, Array]:
    """Tail and head (3,) of a contact's arrow [m].

    Fingers push from outside, so their arrows end at the contact; the table's starts there,
    else it would be drawn under the table.
    """
    point, _, force = moment.contact(track)
    reach = force * look.metres_per_newton
    return (point, point + reach) if track.is_pivot else (point - reach, point)


def _contact_surfaces(look: Look, moment: Moment, track: ContactTrack) -> list[Surface]:
    point, normal, force = moment.contact(track)
    tail, _ = arrow_ends(look, moment, track)
    colour = look.colours[track.name]
    size = float(np.linalg.norm(force))
    loaded = size > LEAST_FORCE_N
    surfaces = []
    if not track.is_pivot:
        tip = mesh.sphere(TIP_RADIUS) + point - TIP_RADIUS * normal
        surfaces.append(Surface(tip, colour, alpha=1.0 if loaded else 0.3))
    if loaded:
        shaft = mesh.arrow(size * look.metres_per_newton, _SHAFT)
        surfaces.append(Surface(_aligned(shaft, force / size, tail), colour))
        cone = mesh.cone(_CONE_HEIGHT, track.friction)
        axis = normal if track.is_pivot else -normal
        surfaces.append(Surface(_aligned(cone, axis, point), colour, alpha=0.13))
    return surfaces
