"""Joint motion of the arm-hand along a phase whose contacts stay (Xue et al., eqs 9, 17)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.interpolate import CubicSpline

from pivotgait.exceptions import InfeasibleError, SingularCoordinatesError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.kinematics import ClosedChain, Hold, differentiate, project
from pivotgait.models import Robot
from pivotgait.phases.timing import quintic
from pivotgait.plans import ContactTrack, RobotMotion, ToolMotion

_TIGHT_M = 1e-11
"""Of the projection: a millionth of the tolerance of contacts (1e-5 m)."""


@dataclass(frozen=True, eq=False)
class JointMotion(FrozenArrays):
    """Positions, velocities and accelerations (N, nv) [rad, s] or [m, s]."""

    q: Array
    v: Array
    a: Array


class Untracked(InfeasibleError):
    """The chain cannot be closed at ``sample``; ``q`` is how far Newton's method came."""

    def __init__(self, sample: int, q: Array, time_s: float) -> None:
        self.sample, self.q = sample, q
        what = f"the fingertips cannot follow the tool at {time_s:.2f} s"
        super().__init__(what, mend="move the contacts or slow the phase")


@dataclass(frozen=True, eq=False)
class Waypoints(FrozenArrays):
    """Postures that a phase goes through.

    Attributes:
        samples: (M,) increasing places among the phase's samples, the first and the last among
            them; one alone for a phase in which nothing moves.
        q: (M, nv), on eq. (9) there.
    """

    samples: Array
    q: Array


def track(
    robot: Robot, holds: Sequence[Hold], time: Array, tool: ToolMotion, through: Waypoints
) -> JointMotion:
    """Follow the tool with the holding fingertips, by way of given postures.

    The redundancy is led by the cubic spline in the path fraction (quintic in time) through the
    waypoints; each sample is the configuration on eq. (9) that Newton's method with steps of
    least norm finds from there.

    Args:
        robot: the arm-hand.
        holds: of every finger that touches the tool.
        time: (N,) from the phase's start [s].
        tool: N samples, at rest at both ends.
        through: postures on the way.

    Raises:
        Untracked: the chain cannot be closed at some sample.
    """
    count = len(time)
    if len(through.q) == 1:
        still = np.zeros((count, robot.nv))
        return JointMotion(np.repeat(through.q, count, axis=0), still, still)
    fraction, _, _ = quintic(time - time[0], float(time[-1] - time[0]))
    led = _led(through, fraction)
    chain, turn = ClosedChain(robot, holds), tool.rotation.as_matrix()
    q = np.empty((count, robot.nv))
    for k in range(count):
        try:
            end = project(chain, led[k], turn[k], tool.position[k], tolerance=_TIGHT_M)
        except SingularCoordinatesError as error:
            raise Untracked(k, led[k], float(time[k])) from error
        if not end.converged:
            raise Untracked(k, end.q, float(time[k]))
        q[k] = end.q
    return JointMotion(q, *differentiate(chain, time, tool, q))


def _led(through: Waypoints, fraction: Array) -> Array:
    """(N, nv) spline through the waypoints."""
    spline = CubicSpline(fraction[through.samples.astype(int)], through.q)
    return np.asarray(spline(fraction))


def with_torques(
    robot: Robot, motion: JointMotion, contacts: Mapping[str, ContactTrack], tool: ToolMotion
) -> RobotMotion:
    """Torques that move the arm-hand and press on the tool: tau = M a + N + J^T f (eq. 17).

    Moments that soft fingertips bear about their normals count as well.

    Args:
        robot: the arm-hand.
        motion: N samples.
        contacts: by finger, with the force on the tool, world [N]; the pivot has no part.
        tool: N samples.
    """
    model, data = robot.model, robot.model.createData()
    tau = inverse_dynamics(robot, motion)
    normal = {name: each.world_normal(tool) for name, each in contacts.items() if not each.is_pivot}
    for k in range(len(tau)):
        pin.computeJointJacobians(model, data, motion.q[k])
        for name, inward in normal.items():
            jacobian = contact_jacobian(robot, data, name, inward[k])
            tau[k] += jacobian.T @ contacts[name].force[k]
            moment = contacts[name].moment
            if moment is not None:
                turning = tip_jacobian(robot, data, name)[3:]
                tau[k] += turning.T @ (moment[k] * inward[k])
    return RobotMotion(q=motion.q, v=motion.v, a=motion.a, tau=tau)


def inverse_dynamics(robot: Robot, motion: JointMotion | RobotMotion) -> Array:
    """(N, nv) torques M a + N that move the arm-hand when it touches nothing."""
    model, data = robot.model, robot.model.createData()
    states = zip(motion.q, motion.v, motion.a, strict=True)
    return np.array([pin.rnea(model, data, *state) for state in states])


def contact_jacobian(robot: Robot, data: pin.Data, finger: str, inward: Array) -> Array:
    """(3, nv) velocity of the tip's surface at its contact, world axes.

    Args:
        robot: the arm-hand.
        data: with joint Jacobians computed at q.
        finger: name.
        inward: (3,) the tool's inward normal, world; the contact lies there from the tip's centre.
    """
    full, radius = tip_jacobian(robot, data, finger), robot.fingers[finger].tip_radius
    return np.asarray(full[:3] + np.cross(full[3:].T, radius * inward).T)


def tip_jacobian(robot: Robot, data: pin.Data, finger: str) -> Array:
    """(6, nv) [linear; angular] velocity of a fingertip's centre, world axes."""
    frame = robot.fingers[finger].tip_frame_id
    pin.updateFramePlacement(robot.model, data, frame)
    return np.array(pin.getFrameJacobian(robot.model, data, frame, pin.LOCAL_WORLD_ALIGNED))
