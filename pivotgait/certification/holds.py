"""Whether holding fingertips stay where they touch, without rolling or slipping (eq. 9)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from pivotgait.certification.certificate import Finding, largest
from pivotgait.certification.tips import TipMotion, held_point, holding
from pivotgait.frozen import Array
from pivotgait.plans import ContactTrack, Phase, PlannedFinger


class Holds:
    """The holds in force while a plan is walked through, phase by phase.

    A hold lasts over phases as long as the finger keeps a contact; rolling and slip are measured
    from its first sample.

    Args:
        fingers: of the planned robot, by name.
    """

    def __init__(self, fingers: Mapping[str, PlannedFinger]) -> None:
        self._fingers = fingers
        self._starts: dict[str, tuple[Array, Array]] = {}

    def check(self, phase: Phase, tips: Mapping[str, TipMotion]) -> Iterator[Finding]:
        """Findings of the next phase of the plan."""
        names = holding(phase)
        self._starts = {name: self._starts[name] for name in names if name in self._starts}
        for name in names:
            radius, tip = self._fingers[name].tip_radius, tips[name]
            contact = phase.contacts[name]
            yield _contact_error(contact, radius, phase, tip)
            yield from self._drift(contact, radius, phase, tip)
            yield from _motion_error(contact, radius, phase, tip)

    def _drift(
        self, contact: ContactTrack, radius: float, phase: Phase, tip: TipMotion
    ) -> Iterator[Finding]:
        tool = phase.tool.rotation.as_matrix()
        in_tip = np.einsum("nji,njk,k->ni", tip.rotation, tool, contact.normal)
        first = self._starts.get(contact.name, (in_tip[0], np.empty(0)))[0]
        turned = np.linalg.norm(np.cross(in_tip, first), axis=1)
        rolled = np.arctan2(turned, in_tip @ first)
        yield largest("tip_rolling_rad", rolled, phase, contact.name)
        # The point of the tip that touched the tool when the hold began, seen from the tool.
        from_tool = tip.position + radius * (tip.rotation @ first) - phase.tool.position
        on_tool = np.einsum("nji,nj->ni", tool, from_tool)
        start = self._starts.setdefault(contact.name, (first, on_tool[0]))[1]
        slipped = np.linalg.norm(on_tool - start, axis=1)
        yield largest("tip_slip_m", slipped, phase, contact.name)


def _contact_error(contact: ContactTrack, radius: float, phase: Phase, tip: TipMotion) -> Finding:
    tool = phase.tool
    wanted = tool.position + tool.rotation.as_matrix() @ held_point(contact, radius)
    away = np.linalg.norm(tip.position - wanted, axis=1)
    return largest("tip_contact_m", away, phase, contact.name)


def _motion_error(
    contact: ContactTrack, radius: float, phase: Phase, tip: TipMotion
) -> Iterator[Finding]:
    """Tip and tool move alike at the tip's centre and at the contact, whatever the spin.

    At the contact the terms of a spin about the normal cancel, in the acceleration too; rolling
    shows up there even where the centres agree.
    """
    inward = phase.tool.rotation.as_matrix() @ contact.normal
    velocity, acceleration = [], []
    for out in (0.0, radius):
        lever = phase.tool.rotation.as_matrix() @ held_point(contact, radius - out)
        offset = out * inward
        speed, surge = _point_of_tool(phase, lever)
        tip_speed = np.cross(tip.angular_velocity, offset)
        tip_surge = np.cross(tip.angular_acceleration, offset)
        tip_surge += np.cross(tip.angular_velocity, tip_speed)
        velocity.append(np.linalg.norm(tip.velocity + tip_speed - speed, axis=1))
        acceleration.append(np.linalg.norm(tip.acceleration + tip_surge - surge, axis=1))
    yield largest("tip_velocity_m_s", np.maximum(*velocity), phase, contact.name)
    yield largest("tip_acceleration_m_s2", np.maximum(*acceleration), phase, contact.name)


def _point_of_tool(phase: Phase, lever: Array) -> tuple[Array, Array]:
    """Velocity [m/s] and acceleration [m/s^2] of tool points ``lever`` (N, 3) from its centre."""
    tool, omega = phase.tool, phase.tool.angular_velocity
    turning = np.cross(omega, lever)
    surge = np.cross(tool.angular_acceleration, lever) + np.cross(omega, turning)
    return tool.linear_velocity + turning, tool.linear_acceleration + surge
