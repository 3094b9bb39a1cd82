"""One moment of a gait as a picture: table, tool, fingertips, forces and cones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame
from pivotgait.margins.gait import LEAST_FORCE_N
from pivotgait.plans.plan import ContactTrack, GaitPlan, Phase
from pivotgait.plotting import mesh
from pivotgait.plotting.ground import draw_ground
from pivotgait.plotting.render import Camera, Surface, paint
from pivotgait.plotting.robot import RobotSurfaces, robot_surfaces
from pivotgait.plotting.shapes import tool_surfaces
from pivotgait.plotting.style import contact_colours, contact_names
from pivotgait.plotting.viewpoint import Sight, clearest_direction, usual_direction

Array = NDArray[np.float64]
TIP_RADIUS = 0.007
"""Radius of the fingertips as drawn [m] where a plan, having no robot, does not tell theirs."""
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
        tip_radius: by contact [m].
        hand: surfaces of the robot's hand, None where no robot is drawn.
    """

    camera: Camera
    tool: tuple[Surface, ...]
    colours: dict[str, str]
    metres_per_newton: float
    table_height: float
    tip_radius: Mapping[str, float]
    hand: RobotSurfaces | None = None

    def bodies(self, moment: Moment) -> list[Surface]:
        """The tool and, if it is drawn, the hand, in the world."""
        placed = [Surface(moment.place(s.faces), s.colour) for s in self.tool]
        if self.hand and moment.phase.robot:
            placed += self.hand.placed(moment.phase.robot.q[moment.sample])
        return placed


def tip_radii(plan: GaitPlan) -> dict[str, float]:
    """Radius of every finger's tip [m], by the name of its contacts."""
    radii = dict.fromkeys(contact_names(plan), TIP_RADIUS)
    fingers = plan.robot.fingers if plan.robot else {}
    return radii | {name: finger.tip_radius for name, finger in fingers.items()}


def look_at(plan: GaitPlan, moments: Sequence[Moment], *, hand: bool = False) -> Look:
    """How to draw moments of a plan, with the robot's hand if it has one and ``hand`` is told.

    The eye is before the tool's tip and above it; with a hand, where most fingertips are seen.
    """
    middle = moments[len(moments) // 2]
    direction = usual_direction(middle.place(plan.tool.pivot_in_tool) - middle.position)
    largest = max(
        float(np.linalg.norm(track.force, axis=1).max())
        for moment in moments
        for track in moment.phase.contacts.values()
    )
    look = Look(
        direction.camera,
        tool_surfaces(plan.tool),
        contact_colours(plan),
        LONGEST_ARROW / max(largest, LEAST_FORCE_N),
        plan.table_height,
        tip_radii(plan),
        robot_surfaces(plan, arm=False) if hand else None,
    )
    if look.hand is None:
        return look
    clearest = clearest_direction([_sight(look, moment) for moment in moments], direction)
    return replace(look, camera=clearest.camera)


def _sight(look: Look, moment: Moment) -> Sight:
    touching = [track for track in moment.phase.contacts.values() if not track.is_pivot]
    radii = np.array([look.tip_radius[track.name] for track in touching])
    centres = [
        point - radius * normal
        for radius, (point, normal, _) in zip(radii, map(moment.contact, touching), strict=True)
    ]
    faces = np.concatenate([surface.faces for surface in look.bodies(moment)])
    return Sight(faces, np.reshape(centres, (-1, 3)), radii)


def draw_moment(axes: Any, look: Look, moment: Moment) -> None:
    """Draw one moment on 2D ``axes``, whose limits are set and keep both axes' scale equal."""
    bodies = look.bodies(moment)
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
            points += [corner for s in look.bodies(moment) for corner in s.faces.reshape(-1, 3)]
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
    if not (track.is_pivot or look.hand):  # a robot's hand has its own tips
        radius = look.tip_radius[track.name]
        tip = mesh.sphere(radius) + point - radius * normal
        surfaces.append(Surface(tip, colour, alpha=1.0 if loaded else 0.3))
    if loaded:
        shaft = mesh.arrow(size * look.metres_per_newton, _SHAFT)
        surfaces.append(Surface(_aligned(shaft, force / size, tail), colour))
        cone = mesh.cone(_CONE_HEIGHT, track.friction)
        axis = normal if track.is_pivot else -normal
        surfaces.append(Surface(_aligned(cone, axis, point), colour, alpha=0.13))
    return surfaces
