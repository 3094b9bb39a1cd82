"""Whether the joint torques are those that motion and contact forces ask for."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pivotgait.certification.certificate import Finding, largest_joint
from pivotgait.certification.rigid_robot import RigidRobot
from pivotgait.certification.tips import holding
from pivotgait.frozen import Array
from pivotgait.plans import GaitPlan, Phase, PlannedRobot, RobotMotion


def check_torques(
    plan: GaitPlan, planned: PlannedRobot, rigid: RigidRobot, phase: Phase, motion: RobotMotion
) -> Finding:
    """Residual of tau = M a + N(q, v) + J^T f (Xue et al., eq. 17), f acting on the tool.

    A moment about a contact's normal counts in f.

    J is taken at the point of the tip's surface that touches the tool. Forces of fingers that
    do not hold are none of the robot's; ``free_force_n`` judges them.
    """
    wanted = required_torques(plan, planned, rigid, phase, motion)
    error = np.abs(motion.tau - wanted)
    return largest_joint("torque_balance_nm", error, phase, rigid.joint_names)


def required_torques(
    plan: GaitPlan, planned: PlannedRobot, rigid: RigidRobot, phase: Phase, motion: RobotMotion
) -> Array:
    """(N, n) joint torques or forces [N m] or [N] by eq. (17)."""
    model = pin.Model(rigid.model)
    model.gravity.linear = np.array(plan.gravity)
    data = model.createData()
    tool = phase.tool.rotation.as_matrix()
    wrenches = [
        (
            rigid.tip_frames[name],
            planned.fingers[name].tip_radius * (tool @ phase.contacts[name].normal),
            phase.contacts[name],
        )
        for name in holding(phase)
    ]
    torques = np.empty_like(motion.q)
    for k, (q, v, a) in enumerate(zip(motion.q, motion.v, motion.a, strict=True)):
        torque = np.array(pin.rnea(model, data, q, v, a))
        pin.computeJointJacobians(model, data, q)
        for frame, lever, contact in wrenches:
            jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
            # Moved from the tip's centre to the contact: a force there and its moment.
            force = contact.force[k]
            moment = np.cross(lever[k], force)
            if contact.moment is not None:
                moment += contact.moment[k] * (tool[k] @ contact.normal)
            torque += jacobian.T @ np.concatenate((force, moment))
        torques[k] = torque
    return torques
