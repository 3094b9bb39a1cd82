"""Joint torque limits as linear rows of the force allocation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from pivotgait.forces import LinearRows
from pivotgait.frozen import Array
from pivotgait.models import HandleContact, Robot
from pivotgait.phases.tracking import JointMotion, contact_jacobian, inverse_dynamics
from pivotgait.plans import RobotMotion, ToolMotion


def torque_rows(
    robot: Robot,
    motion: JointMotion | RobotMotion,
    tool: ToolMotion,
    fingers: Sequence[HandleContact],
    *,
    reserve: float = 0.0,
) -> LinearRows:
    """Rows -tau_max <= M a + N + sum J_i^T f_i <= tau_max on the stacked forces (eq. 17).

    Args:
        robot: the arm-hand.
        motion: N samples.
        tool: N samples.
        fingers: in the order of the forces, which begin with the pivot's.
        reserve: share of every limit that is left unused.

    Returns:
        Rows (N, r, 3 (1 + m)) in world axes: those of the joints whose limit some forces within
        the contacts' bounds (eqs 5, 6) could reach.
    """
    count, data = len(motion.q), robot.model.createData()
    matrix = np.zeros((count, robot.nv, 3 * (1 + len(fingers))))
    inward = tool.rotation.as_matrix() @ np.stack([finger.normal for finger in fingers]).T
    for k in range(count):
        pin.computeJointJacobians(robot.model, data, motion.q[k])
        for place, finger in enumerate(fingers):
            jacobian = contact_jacobian(robot, data, finger.finger, inward[k, :, place])
            matrix[k, :, 3 * (place + 1) : 3 * (place + 2)] = jacobian.T
    free = inverse_dynamics(robot, motion)
    limit = (1.0 - reserve) * robot.effort_max
    most = [np.hypot(1.0, finger.friction) * finger.normal_max for finger in fingers]
    pushes = np.linalg.norm(matrix.reshape(count, robot.nv, -1, 3)[:, :, 1:], axis=3) @ most
    reached = np.any(np.abs(free) + pushes > limit, axis=0)
    return LinearRows(matrix[:, reached], (-limit - free)[:, reached], (limit - free)[:, reached])


def torque_share(robot: Robot, tau: Array) -> tuple[float, str]:
    """Largest share of a torque limit in ``tau`` (N, nv), and the joint's name."""
    share = np.max(np.abs(tau) / robot.effort_max, axis=0)
    worst = int(np.argmax(share))
    return float(share[worst]), robot.joint_names[worst]
