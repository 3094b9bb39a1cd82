"""The parameters of a scene that may mend an obstacle, each with how far it is followed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.feasibility.rehearsal import Obstacle
from pivotgait.models import (
    LiftPhase,
    PhaseConfig,
    RelocationPhase,
    RemovalPhase,
    Scene,
    TransferPhase,
)
from pivotgait.models.parameters import MASS_SCALE, Value

FRICTION_MAX = 2.0
"""Largest friction a scene may name."""
FORCE_REACH = 30.0
"""Force bounds beyond this factor are not offered."""
MASS_LEAST = 0.03
"""Lightest tool tried, over the one now."""
SLOWER, DURATION_MAX_S = 20.0, 600.0
PITCH_MAX_DEG, ROLL_MAX_DEG, AROUND_MAX_DEG = 85.0, 90.0, 180.0
TURN_MAX = "turn_max_deg"
"""The change that is no field of the scene: how far a removal may turn the tool [deg]."""


@dataclass(frozen=True)
class SceneMend:
    """One change that makes the whole gait feasible, tried out.

    Attributes:
        change: the parameter, see :class:`Variants`; or ``turn_max_deg``.
        from_: its value now; for ``*`` the largest of them.
        to: the value that suffices, rounded to four digits, away from the one now.
        size: of the change over what is usual for its kind, by which mends are ordered: the value
            now for friction, forces, durations and mass, the handle's length, 90 degrees.
    """

    change: str
    from_: float
    to: float
    size: float

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line."""
        return {"change": self.change, "from": self.from_, "to": self.to, "size": self.size}


@dataclass(frozen=True)
class Line:
    """Values of one parameter, from the one now to the farthest worth trying.

    Attributes:
        path: of the parameter.
        now: its value.
        far: the last value.
        unit: what the size of a change is measured in.
        steady: whether what is feasible stays so farther along.
    """

    path: str
    now: float
    far: float
    unit: float
    steady: bool = True

    def mend(self, to: float) -> SceneMend:
        """The change to a value, rounded away from the one now."""
        shown = _rounded(to, up=self.far > self.now)
        return SceneMend(self.path, self.now, shown, abs(shown - self.now) / self.unit)


def mend_lines(
    scene: Scene,
    gait: str,
    obstacle: Obstacle,
    changes: Mapping[str, Value],
    turn_max_deg: float | None,
) -> Iterator[Line]:
    """The parameters that may mend an obstacle, and how far each is followed.

    Args:
        scene: as it is.
        gait: which of its gaits.
        obstacle: to be mended.
        changes: made to the scene already.
        turn_max_deg: see :func:`rehearse`.
    """
    config = obstacle.config
    if obstacle.kind == "turn":
        now = float(turn_max_deg or 0.0)
        yield Line(TURN_MAX, now, obstacle.needed, 90.0)
        return
    if obstacle.kind in ("force_rate", "motion"):
        if not isinstance(config, RelocationPhase):
            now = config.duration_s
            far = min(max(SLOWER * now, 2.0 * obstacle.needed), DURATION_MAX_S)
            yield Line(f"{config.kind}.duration_s", now, far, now)
        return
    names = touching(obstacle, scene.gaits[gait])
    yield from _limits(scene, names)
    mass = float(changes.get(MASS_SCALE, 1.0))
    yield Line(MASS_SCALE, mass, MASS_LEAST * mass, mass)
    low, high = scene.tool.handle.extent
    for name in names:
        place = scene.config.contacts[name]
        for far in (low, high):
            yield Line(f"contacts.{name}.along_m", place.along_m, far, high - low, False)
        for way in (-1.0, 1.0):
            far = place.around_deg + way * AROUND_MAX_DEG
            yield Line(f"contacts.{name}.around_deg", place.around_deg, far, 90.0, False)
    lift = scene.gaits[gait][0]
    if isinstance(config, LiftPhase):
        far = min(SLOWER * config.duration_s, DURATION_MAX_S)
        yield Line("lift.duration_s", config.duration_s, far, config.duration_s)
    if isinstance(lift, LiftPhase):
        for way in (-1.0, 1.0):
            yield Line("tool.pitch_deg", lift.to.pitch_deg, way * PITCH_MAX_DEG, 90.0, False)
            far = lift.to.roll_deg + way * ROLL_MAX_DEG
            yield Line("tool.roll_deg", lift.to.roll_deg, far, 90.0, False)


def _limits(scene: Scene, names: Sequence[str]) -> Iterator[Line]:
    """Friction and bounds of the table, of each contact, and of all contacts."""
    contacts = scene.config.contacts
    places: list[tuple[str, Any]] = [("table", scene.config.table)]
    places += [(f"contacts.{name}", contacts[name]) for name in names]
    for path, at in places:
        bounds = at.normal_force_N
        yield Line(f"{path}.friction", at.friction, FRICTION_MAX, at.friction)
        yield Line(f"{path}.normal_force_N.max", bounds.max, FORCE_REACH * bounds.max, bounds.max)
        if bounds.min > 0.0:
            yield Line(f"{path}.normal_force_N.min", bounds.min, 0.0, bounds.min)
    friction = max(each.friction for each in contacts.values())
    force = max(each.normal_force_N.max for each in contacts.values())
    yield Line("contacts.*.friction", friction, FRICTION_MAX, friction)
    yield Line("contacts.*.normal_force_N.max", force, FORCE_REACH * force, force)


def touching(obstacle: Obstacle, configs: Sequence[PhaseConfig]) -> list[str]:
    """Names of the contacts that the obstacle's phase loads to its end."""
    config = configs[obstacle.place]
    if isinstance(config, LiftPhase):
        return list(config.contacts)
    held = [each.name for each in obstacle.before.fingers.values()]
    if isinstance(config, RemovalPhase):
        return [name for name in held if name != config.contact]
    return held if isinstance(config, TransferPhase) else [*held, config.contact]


def _rounded(value: float, *, up: bool) -> float:
    """Four significant digits, but no finer than 1e-6, on the side that is asked for."""
    if value == 0.0:
        return 0.0
    unit = max(10.0 ** (np.floor(np.log10(abs(value))) - 3.0), 1e-6)
    steps = np.ceil(value / unit - 1e-9) if up else np.floor(value / unit + 1e-9)
    return float(f"{steps * unit:.10g}")
