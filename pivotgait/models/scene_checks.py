"""Checks of a scene that no single field can fail."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pivotgait.exceptions import SceneError, UnknownNameError
from pivotgait.models.scene import Scene
from pivotgait.models.scene_config import (
    AdditionPhase,
    ForceBounds,
    HandleConfig,
    LiftPhase,
    PhaseConfig,
    RelocationPhase,
    SceneConfig,
    TransferPhase,
)

MIN_FINGERS = 2
"""Pivot and one finger cannot resist a moment about the line through them."""


def check_config(config: SceneConfig, where: str) -> None:
    """Check the fields against one another; needs no tool.

    Raises:
        SceneError: naming the field.
    """
    _check_bounds(config.table.normal_force_N, f"{where}: table.normal_force_N")
    for name, contact in config.contacts.items():
        _check_bounds(contact.normal_force_N, f"{where}: contacts.{name}.normal_force_N")
        if contact.finger == "pivot":
            at = f"{where}: contacts.{name}.finger"
            raise SceneError("'pivot' names the table contact", where=at, mend="rename the finger")
        if config.robot is not None and contact.finger not in config.robot.fingers:
            at = f"{where}: contacts.{name}.finger"
            raise UnknownNameError("finger", contact.finger, config.robot.fingers, where=at)
    _check_axes(config.tool.handle, f"{where}: tool.handle")
    if not config.gravity_m_s2[2] < 0.0:
        at = f"{where}: gravity_m_s2"
        what = f"must point down, got z = {config.gravity_m_s2[2]:g}"
        raise SceneError(what, where=at, mend="use [0, 0, -9.81]")
    half_size, centre = list(config.table.half_size_m), list(config.table.centre_m)
    if np.any(np.abs(np.subtract(config.rest.pivot_m, centre)) > half_size):
        raise SceneError(
            f"the pivot {list(config.rest.pivot_m)} is off the table",
            where=f"{where}: rest.pivot_m",
            mend=f"keep it within {half_size} of the table's centre {centre}",
        )
    if "default" not in config.gaits:
        mend = "name one of the gaits 'default'"
        raise SceneError("has no gait 'default'", where=f"{where}: gaits", mend=mend)
    for name, phases in config.gaits.items():
        _check_gait(config, phases, f"{where}: gaits.{name}")


def check_lifts(scene: Scene, where: str) -> None:
    """Check that every lift ends clear of the table.

    Raises:
        SceneError: naming the phase and the height that is missing.
    """
    for name, phases in scene.gaits.items():
        for place, phase in enumerate(phases):
            if not isinstance(phase, LiftPhase):
                continue
            height = float(scene.height(scene.lift_rotation(phase.to)))
            if height < scene.clearance:
                raise SceneError(
                    f"leaves the tool {1e3 * height:.2f} mm over the table, "
                    f"clearance_m asks for {1e3 * scene.clearance:g} mm",
                    where=f"{where}: gaits.{name}[{place}].to",
                    mend="raise pitch_deg",
                )


def check_postures(scene: Scene, where: str) -> None:
    """Check that postures which phases suggest are the robot's and within its joint limits.

    Raises:
        UnknownNameError: for a joint that the robot does not have.
        SceneError: naming the joint and its limits.
    """
    if (robot := scene.robot) is None:
        return
    limits = dict(zip(robot.joint_names, zip(robot.lower, robot.upper, strict=True), strict=True))
    for at, joint, value in _suggested(scene, where):
        if joint not in limits:
            raise UnknownNameError("moving joint", joint, limits, where=at)
        lower, upper = limits[joint]
        if not lower <= value <= upper:
            what = f"{value:g} is outside the limits [{lower:g}, {upper:g}]"
            raise SceneError(what, where=f"{at}.{joint}", mend="give a value within them")


def _suggested(scene: Scene, where: str) -> Iterator[tuple[str, str, float]]:
    """Where in the file each joint's position of a phase's postures stands, its name and value."""
    for name, phases in scene.gaits.items():
        for place, phase in enumerate(phases):
            for field in ("posture", "posture_before"):
                at = f"{where}: gaits.{name}[{place}].{field}"
                yield from ((at, *each) for each in getattr(phase, field, {}).items())


def _check_bounds(bounds: ForceBounds, at: str) -> None:
    if bounds.min > bounds.max:
        what = f"min {bounds.min:g} N is greater than max {bounds.max:g} N"
        raise SceneError(what, where=at, mend="swap or widen them")


def _check_axes(handle: HandleConfig, at: str) -> None:
    axis, zero = np.array(handle.axis), np.array(handle.zero)
    for name, vector in (("axis", axis), ("zero", zero)):
        if np.linalg.norm(vector) < 1e-6:
            raise SceneError(
                "has no direction", where=f"{at}.{name}", mend="give a vector like [1, 0, 0]"
            )
    cosine = float(axis @ zero / (np.linalg.norm(axis) * np.linalg.norm(zero)))
    if abs(cosine) > 1e-6:
        angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        what = f"must be normal to axis, the angle is {angle:.3f} deg"
        raise SceneError(what, where=f"{at}.zero", mend="make it 90 deg")


def _check_gait(config: SceneConfig, phases: Sequence[PhaseConfig], where: str) -> None:
    """Play the gait's contacts through: who touches or waits where after each phase."""
    touching: dict[str, str] = {}  # finger -> contact
    waiting: dict[str, str] = {}  # finger -> contact before which it was moved
    for place, phase in enumerate(phases):
        at = f"{where}[{place}]"
        if isinstance(phase, LiftPhase):
            if place > 0:
                mend = "a lift starts from rest, so it comes first"
                raise SceneError("a lift after another phase", where=at, mend=mend)
            for contact in phase.contacts:
                _add(config, touching, contact, f"{at}.contacts")
        elif place == 0:
            mend = "put a lift first; it says which contacts hold the tool"
            raise SceneError(f"starts with kind {phase.kind}", where=at, mend=mend)
        elif isinstance(phase, TransferPhase):
            if place < len(phases) - 1:
                mend = "the tool is off the table then, so it comes last"
                raise SceneError("a transfer before another phase", where=at, mend=mend)
        elif isinstance(phase, RelocationPhase):
            _move(config, touching, waiting, phase, f"{at}.contact")
        elif isinstance(phase, AdditionPhase):
            _arrive(config, waiting, phase.contact, f"{at}.contact")
            _add(config, touching, phase.contact, f"{at}.contact")
        else:
            _remove(config, touching, phase.contact, f"{at}.contact")


def _finger(config: SceneConfig, contact: str, at: str) -> str:
    if contact not in config.contacts:
        raise UnknownNameError("contact", contact, config.contacts, where=at)
    return config.contacts[contact].finger


def _add(config: SceneConfig, touching: dict[str, str], contact: str, at: str) -> None:
    finger = _finger(config, contact, at)
    if finger in touching:
        raise SceneError(
            f"finger {finger!r} is in contact already, at {touching[finger]!r}",
            where=at,
            mend="remove it before adding it elsewhere",
        )
    touching[finger] = contact


def _move(
    config: SceneConfig,
    touching: dict[str, str],
    waiting: dict[str, str],
    phase: RelocationPhase,
    at: str,
) -> None:
    """Only a finger that does not hold the tool can go elsewhere."""
    finger = _finger(config, phase.contact, at)
    if finger in touching:
        raise SceneError(
            f"finger {finger!r} holds the tool at {touching[finger]!r}",
            where=at,
            mend="remove it before moving it elsewhere",
        )
    away = f"a place before {phase.contact}"
    waiting[finger] = away if phase.standoff_m > 0.0 else phase.contact


def _arrive(config: SceneConfig, waiting: dict[str, str], contact: str, at: str) -> None:
    """A finger that was moved to a contact must be added there."""
    finger = _finger(config, contact, at)
    moved = waiting.pop(finger, contact)
    if moved != contact:
        raise SceneError(
            f"finger {finger!r} was moved to {moved!r}, not to {contact!r}",
            where=at,
            mend=f"move the finger to {contact!r}, touching it, before this addition",
        )


def _remove(config: SceneConfig, touching: dict[str, str], contact: str, at: str) -> None:
    finger = _finger(config, contact, at)
    if touching.get(finger) != contact:
        listed = ", ".join(touching.values()) or "none"
        raise SceneError(
            f"{contact!r} is not in contact", where=at, mend=f"contacts then: {listed}"
        )
    del touching[finger]
    if len(touching) < MIN_FINGERS:
        raise SceneError(
            f"leaves {len(touching)} finger on the tool, needs {MIN_FINGERS}",
            where=at,
            mend="add another finger first",
        )
