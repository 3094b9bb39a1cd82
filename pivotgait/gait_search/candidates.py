"""Places on the handle where a finger may hold it, as contacts that a scene can name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pivotgait.exceptions import InputError, SceneError
from pivotgait.frozen import Array
from pivotgait.models import HandleContact, Scene, SurfacePoint

Place = tuple[float, float]
"""Along the handle's axis [m] and around it [deg], as in a scene's file."""


@dataclass(frozen=True)
class CandidateOptions:
    """How densely the handle is covered.

    Attributes:
        along_step_m: between places along the axis [m].
        around_step_deg: between places around it [deg].
        end_margin_m: of the axis at either end without places [m].
        face_m: within this distance of a place [m] ...
        bend_max_deg: ... the surface bends by no more than this angle [deg]: a fingertip that
            lands a little beside it still meets nearly the same normal.

    Raises:
        InputError: for a step or margin that is not positive and finite.
    """

    along_step_m: float = 0.012
    around_step_deg: float = 30.0
    end_margin_m: float = 0.008
    face_m: float = 0.0015
    bend_max_deg: float = 30.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"is {value}", where=name, mend="give a number above 0")


@dataclass(frozen=True, eq=False)
class Candidate:
    """A contact and where it is on the handle.

    Attributes:
        contact: with the limits that the scene gives its finger's contacts.
        along_m: along the handle's axis [m].
        around_deg: about the axis [deg].
    """

    contact: HandleContact
    along_m: float
    around_deg: float

    @property
    def name(self) -> str:
        """Of the contact."""
        return self.contact.name

    @property
    def finger(self) -> str:
        """That may touch here."""
        return self.contact.finger


Candidates = Mapping[str, Candidate]
"""By the contact's name."""


def handle_candidates(
    scene: Scene, options: CandidateOptions | None = None, lost: Counter[str] | None = None
) -> Candidates:
    """The scene's own contacts, then a grid over the handle for every finger.

    Points are where rays from the handle's axis leave the union of its shapes, normals those of
    the shape left there (closed forms for every primitive); Coal verifies both.

    Args:
        scene: tool, fingers, limits of contacts.
        options: of the grid.
        lost: counts places that are no candidates by their reason.
    """
    found = dict(own_candidates(scene))
    known = {(each.finger, each.along_m, each.around_deg % 360.0) for each in found.values()}
    counter: Counter[str] = Counter() if lost is None else lost
    for (along, around), surface in _grid(scene, options or CandidateOptions(), counter):
        for finger in fingers_of(scene):
            if (finger, along, around) not in known:
                each = _candidate(scene, finger, (along, around), surface)
                found[each.name] = each
    return MappingProxyType(found)


def own_candidates(scene: Scene) -> Iterator[tuple[str, Candidate]]:
    """The contacts that the scene's file names."""
    for name, contact in scene.contacts.items():
        given = scene.config.contacts[name]
        yield name, Candidate(contact, given.along_m, given.around_deg)


def candidate_at(scene: Scene, finger: str, place: Place, *, where: str) -> Candidate:
    """A candidate at a place that someone names.

    Args:
        scene: tool and limits of contacts.
        finger: of the scene.
        place: on the handle.
        where: name of the place in messages.

    Raises:
        SceneError: off the handle, on an edge, or hidden by another shape of the tool.
    """
    surface = scene.tool.place(place[0], np.radians(place[1]), where=where)
    return _candidate(scene, finger, place, surface)


def fingers_of(scene: Scene) -> tuple[str, ...]:
    """Names of the fingers that may touch: the robot's, or those of the contacts."""
    if scene.robot is not None:
        return tuple(scene.robot.fingers)
    return tuple(dict.fromkeys(contact.finger for contact in scene.contacts.values()))


def by_finger(fingers: Iterable[str], candidates: Candidates) -> dict[str, list[Candidate]]:
    """Candidates of each finger; none of one that has no place."""
    found: dict[str, list[Candidate]] = {name: [] for name in fingers}
    for each in candidates.values():
        found[each.finger].append(each)
    return found


def _candidate(scene: Scene, finger: str, place: Place, surface: SurfacePoint) -> Candidate:
    contacts = list(scene.contacts.values())
    like = next((each for each in contacts if each.finger == finger), contacts[0])
    along, around = place
    name = f"{finger}_{1e3 * along:g}mm_{around:g}deg".replace(".", "p").replace("-", "m")
    contact = HandleContact(
        name,
        finger,
        surface.point,
        surface.normal,
        like.friction,
        like.normal_min,
        like.normal_max,
        like.torsion,
    )
    return Candidate(contact, along, around)


def _grid(
    scene: Scene, options: CandidateOptions, lost: Counter[str]
) -> Iterator[tuple[Place, SurfacePoint]]:
    low, high = (1e3 * end for end in scene.tool.handle.extent)
    margin, step = 1e3 * options.end_margin_m, 1e3 * options.along_step_m
    # whole millimetres and degrees: what a scene's file says of them is exact
    rows = np.round(np.arange(low + margin, high - margin + 1e-9, step))
    turns = np.round(np.arange(0.0, 360.0 - 1e-9, options.around_step_deg), 3)
    for along in rows:
        for around in turns:
            place = float(along) / 1e3, float(around)
            try:
                surface = scene.tool.place(place[0], np.radians(place[1]))
            except SceneError:
                lost["edge of the handle or hidden"] += 1
                continue
            if _bends(scene, place, surface, options):
                lost["too near an edge of the handle"] += 1
                continue
            yield place, surface


def _bends(scene: Scene, place: Place, surface: SurfacePoint, options: CandidateOptions) -> bool:
    """Whether the normal changes much close by."""
    handle, least = scene.tool.handle, np.cos(np.radians(options.bend_max_deg))
    radius = _distance_to_axis(handle.origin, handle.axis, surface.point)
    turn = np.degrees(options.face_m / max(radius, options.face_m))
    for along, around in ((options.face_m, 0.0), (-options.face_m, 0.0), (0.0, turn), (0.0, -turn)):
        try:
            beside = handle.place(place[0] + along, np.radians(place[1] + around))
        except SceneError:
            return True
        if beside.normal @ surface.normal < least:
            return True
    return False


def _distance_to_axis(origin: Array, axis: Array, point: Array) -> float:
    lever = point - origin
    return float(np.linalg.norm(lever - (lever @ axis) * axis))


def tip_centres(candidates: Sequence[Candidate], radii: Mapping[str, float]) -> Array:
    """(N, 3) centres of fingertips at their contacts, tool frame [m].

    Args:
        candidates: N.
        radii: finger -> radius of its tip [m]; a finger that is not there has a point.
    """
    points = np.array([each.contact.point for each in candidates]).reshape(-1, 3)
    normals = np.array([each.contact.normal for each in candidates]).reshape(-1, 3)
    radius = np.array([radii.get(each.finger, 0.0) for each in candidates])
    return np.asarray(points - radius[:, None] * normals)
