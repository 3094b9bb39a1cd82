"""Joint motion of the arm-hand along a phase whose contacts stay (Xue et al., eqs 9, 17)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.interpolate import make_interp_spline

from pivotgait.exceptions import InfeasibleError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.kinematics import ClosedChain, Hold, project, resolve
from pivotgait.models import Robot
from pivotgait.phases.timing import quintic
from pivotgait.plans import ContactTrack, RobotMotion, ToolMotion

_TIGHT_M = 1e-11
"""Of the projection: a millionth of the tolerance of contacts (1e-5 m)."""
_ORDERS_AT_REST = (1, 2)


@dataclass(frozen=True, eq=False)
class JointMotion(FrozenArrays):
    """Positions, velocities and accelerations (N, nv) [rad, s] or [m, s]."""

    q: Array
    v: Array
    a: Array


def track(
    robot: Robot, holds: Sequence[Hold], time: Array, tool: ToolMotion, through: Array
) -> JointMotion:
    """Follow the tool with the holding fingertips, by way of given postures.

    The redundancy is led by the polynomial in the path fraction (quintic in time) through the
    given postures, which start, halve and end the phase; each sample is the nearest
    configuration on eq. (9) that Newton's method finds from there. Velocities and accelerations
    are those of the quintic spline through the samples, corrected by least norm so that
    A v = b and A a = db/dt - dA/dt v hold at each sample.

    Args:
        robot: the arm-hand.
        holds: of every finger that touches the tool.
        time: (N,) from the phase's start [s].
        tool: N samples, at rest at both ends.
        through: (1 + M, nv) postures at equal fractions of the way, on eq. (9); one for a phase
            in which nothing moves.

    Raises:
        InfeasibleError: the chain cannot be closed at some sample.
    """
    count = len(time)
    if len(through) == 1:
        still = np.zeros((count, robot.nv))
        return JointMotion(np.repeat(through, count, axis=0), still, still)
    fraction, _, _ = quintic(time - time[0], float(time[-1] - time[0]))
    led = _polynomial(through, fraction)
    chain, turn = ClosedChain(robot, holds), tool.rotation.as_matrix()
    q = np.empty((count, robot.nv))
    for k in range(count):
        end = project(chain, led[k], turn[k], tool.position[k], tolerance=_TIGHT_M)
        if not end.converged:
            raise InfeasibleError(
                f"the fingertips cannot follow the tool at {time[k]:.2f} s",
                mend="move the contacts or slow the phase",
            )
        q[k] = end.q
    return _on_the_chain(chain, time, tool, q)


def _polynomial(through: Array, fraction: Array) -> Array:
    """(N, nv) values of the polynomial through postures at equal parts of [0, 1]."""
    nodes = np.linspace(0.0, 1.0, len(through))
    weights = np.ones((len(fraction), len(nodes)))
    for i, node in enumerate(nodes):
        for other in np.delete(nodes, i):
            weights[:, i] *= (fraction - other) / (node - other)
    return np.asarray(weights @ through)


def _on_the_chain(chain: ClosedChain, time: Array, tool: ToolMotion, q: Array) -> JointMotion:
    at_rest = [(order, np.zeros(q.shape[1])) for order in _ORDERS_AT_REST]
    spline = make_interp_spline(time, q, k=5, bc_type=(at_rest, at_rest))
    smooth_v, smooth_a = spline.derivative(1)(time), spline.derivative(2)(time)
    turn, v, a = tool.rotation.as_matrix(), np.empty_like(q), np.empty_like(q)
    for k in range(len(time)):
        chain.update(q[k], turn[k], tool.position[k])
        linear, angular = tool.linear_velocity[k], tool.angular_velocity[k]
        v[k] = resolve(chain, chain.target_rate(linear, angular), smooth_v[k])
        bias = chain.bias(
            v[k], linear, angular, tool.linear_acceleration[k], tool.angular_acceleration[k]
        )
        a[k] = resolve(chain, bias, smooth_a[k])
    return JointMotion(q, v, a)


def with_torques(
    robot: Robot, motion: JointMotion, contacts: Mapping[str, ContactTrack], tool: ToolMotion
) -> RobotMotion:
    """Torques that move the arm-hand and press on the tool: tau = M a + N + J^T f (eq. 17).

    Args:
        robot: the arm-hand.
        motion: N samples.
        contacts: by finger, with the force on the tool, world [N]; the pivot has no part.
        tool: N samples.
    """
    model, data = robot.model, robot.model.createData()
    tau = np.array(
        [pin.rnea(model, data, *state) for state in zip(motion.q, motion.v, motion.a, strict=True)]
    )
    for k in range(len(tau)):
        pin.computeJointJacobians(model, data, motion.q[k])
        for name, track in contacts.items():
            if name in robot.fingers and np.any(track.force[k]):
                jacobian = contact_jacobian(robot, data, name, track.world_normal(tool)[k])
                tau[k] += jacobian.T @ track.force[k]
    return RobotMotion(q=motion.q, v=motion.v, a=motion.a, tau=tau)


def contact_jacobian(robot: Robot, data: pin.Data, finger: str, inward: Array) -> Array:
    """(3, nv) velocity of the tip's surface at its contact, world axes.

    Args:
        robot: the arm-hand.
        data: with joint Jacobians computed at q.
        finger: name.
        inward: (3,) the tool's inward normal, world; the contact lies there from the tip's centre.
    """
    tip = robot.fingers[finger]
    pin.updateFramePlacement(robot.model, data, tip.tip_frame_id)
    full = pin.getFrameJacobian(robot.model, data, tip.tip_frame_id, pin.LOCAL_WORLD_ALIGNED)
    return np.asarray(full[:3] + np.cross(full[3:].T, tip.tip_radius * inward).T)
