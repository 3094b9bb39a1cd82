"""What a plan wants at any time: tool, contacts and their forces, joints."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pivotgait.control.curves import Curves, polygon, quintic_spline
from pivotgait.control.pace import Pace
from pivotgait.control.planned_holds import planned_holds
from pivotgait.control.tool_state import ToolState
from pivotgait.control.turning import quaternion_curve, turning
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.kinematics import Hold
from pivotgait.models import Robot, parse_scene
from pivotgait.plans import GaitPlan, Phase, RobotMotion

_TOOL = 7
"""Channels of the tool: position and quaternion."""


class Instant(NamedTuple):
    """The plan at one time.

    Attributes:
        phase: index of the phase.
        time_in_phase: since its start [s].
        tool: planned.
        q: (n,) planned joint positions [rad] or [m].
        v: (n,) [rad/s] or [m/s].
        a: (n,) [rad/s^2] or [m/s^2].
        force_in_tool: (m, 3) planned force on the tool [N], **tool axes**, of each holding finger
            in the order of the phase's holds.
        moment: (m,) planned moment on the tool about the inward normal of each of them [N m];
            None in a phase without any.
        pace: at which the plan's time passes, of which the rates above already are; None: as
            planned.
    """

    phase: int
    time_in_phase: float
    tool: ToolState
    q: Array
    v: Array
    a: Array
    force_in_tool: Array
    moment: Array | None = None
    pace: Pace | None = None


class PhaseReference:
    """One phase of a plan as curves in time.

    The tool's orientation is a spline of its quaternions, so that velocity and acceleration are
    its exact derivatives, whatever rule made the samples. Forces are straight between samples,
    which keeps them in their cones.

    Attributes:
        index: place in the plan.
        name: of the phase.
        start: time from the plan's start [s].
        duration: [s].
        samples: the planned phase.
        holds: the fingers that hold from the first sample to the last.
        motion: of the arm-hand at the samples.
    """

    def __init__(
        self, index: int, start: float, samples: Phase, motion: RobotMotion, holds: Sequence[Hold]
    ) -> None:
        """The curves of a phase that starts at ``start`` [s] of the plan."""
        self.index, self.name, self.start = index, samples.name, start
        self.samples, self.motion, self.holds = samples, motion, tuple(holds)
        self.duration = samples.duration_s
        tool = samples.tool
        self._joints = slice(_TOOL, _TOOL + motion.q.shape[1])
        self._forces = slice(self._joints.stop, self._joints.stop + 3 * len(self.holds))
        moments = self._moments()
        self._twists = bool(np.any(moments))
        self._curves = Curves(
            samples.time,
            quintic_spline(
                samples.time, tool.position, tool.linear_velocity, tool.linear_acceleration
            ),
            quaternion_curve(samples.time, tool),
            quintic_spline(samples.time, motion.q, motion.v, motion.a),
            polygon(samples.time, self._forces_in_tool()),
            *([polygon(samples.time, moments)] if self._twists else []),
        )

    def _forces_in_tool(self) -> Array:
        turn = self.samples.tool.rotation.as_matrix()
        forces = [
            np.einsum("nji,nj->ni", turn, self.samples.contacts[hold.finger.name].force)
            for hold in self.holds
        ]
        return np.concatenate([np.zeros((len(turn), 0)), *forces], axis=1)

    def _moments(self) -> Array:
        """(N, m) about the inward normals of the holds [N m]."""
        samples = self.samples
        found = np.zeros((len(samples.time), len(self.holds)))
        for place, hold in enumerate(self.holds):
            moment = samples.contacts[hold.finger.name].moment
            if moment is not None:
                found[:, place] = moment
        return found

    def at(self, time: float) -> Instant:
        """The plan ``time`` [s] after the phase's start."""
        values = self._curves(time)
        joints = values[:, self._joints]
        return Instant(
            phase=self.index,
            time_in_phase=time,
            tool=_tool_state(values),
            q=joints[0],
            v=joints[1],
            a=joints[2],
            force_in_tool=values[0, self._forces].reshape(-1, 3),
            moment=values[0, self._forces.stop :] if self._twists else None,
        )


class Reference:
    """A whole plan, phases joined; after its end it stays at its last instant, at rest.

    Attributes:
        robot: that the plan is for, with the plan's gravity.
        plan: it follows.
        phases: in order.
        duration: of the plan [s].
    """

    def __init__(self, plan: GaitPlan, robot: Robot) -> None:
        """See :meth:`of`."""
        motions = _motions(plan, robot)
        self.plan, self.robot = plan, robot
        holds = planned_holds(plan, robot)
        phases, start = [], 0.0
        for k, (phase, motion) in enumerate(zip(plan.phases, motions, strict=True)):
            phases.append(PhaseReference(k, start, phase, motion, holds[k]))
            start += phase.duration_s
        self.phases: tuple[PhaseReference, ...] = tuple(phases)
        self.duration = start
        self._starts = [phase.start for phase in phases]

    @classmethod
    def of(cls, plan: GaitPlan, robot: Robot | None = None) -> Reference:
        """The reference of a plan.

        Args:
            plan: with a robot.
            robot: that shall carry it out; that of the plan's scene if not given.

        Raises:
            InputError: for a plan without a robot, or of another robot.
            SceneError: if the plan's scene cannot be read.
        """
        if plan.robot is None:
            raise InputError(
                "the plan has no arm-hand", where="plan", mend="plan a scene that has a robot"
            )
        found = robot if robot is not None else parse_scene(plan.scene, where="plan: scene").robot
        if found is None:
            raise InputError(
                "the plan has an arm-hand but its scene has none",
                where="plan: scene",
                mend="plan the scene again",
            )
        return cls(plan, found)

    def phase_at(self, time: float) -> PhaseReference:
        """The phase in force at ``time`` [s]; at a seam the later one."""
        return self.phases[max(bisect_right(self._starts, time) - 1, 0)]

    def at(self, time: float) -> Instant:
        """The plan at ``time`` [s] from its start."""
        phase = self.phase_at(time)
        return phase.at(time - phase.start)


def _tool_state(curves: Array) -> ToolState:
    rotation, angular_velocity, angular_acceleration = turning(curves[:, 3:_TOOL])
    return ToolState(
        position=curves[0, :3],
        rotation=rotation,
        linear_velocity=curves[1, :3],
        angular_velocity=angular_velocity,
        linear_acceleration=curves[2, :3],
        angular_acceleration=angular_acceleration,
    )


def _motions(plan: GaitPlan, robot: Robot) -> list[RobotMotion]:
    """The joint motions of all phases, of this robot.

    Raises:
        InputError: where joints differ or a phase has no motion of the arm-hand.
    """
    if plan.robot is None or plan.robot.joint_names != robot.joint_names:
        raise InputError(
            "the plan's arm-hand is not the robot's: its joints differ",
            where="plan",
            mend="plan again with this robot",
        )
    motions = [phase.robot for phase in plan.phases if phase.robot is not None]
    if len(motions) < len(plan.phases):
        raise InputError(
            "a phase has no motion of the arm-hand",
            where="plan",
            mend="plan all phases with the robot",
        )
    return motions
