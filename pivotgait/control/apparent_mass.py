"""How heavy a fingertip feels, from which the gains follow."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pivotgait.control.reference import Instant, Reference
from pivotgait.frozen import Array


def apparent_masses(reference: Reference, wanted: Instant) -> Array:
    """(m,) mass [kg] that each holding fingertip shows along its normal, all joints free.

    1 / (n^T J M^-1 J^T n), J of the tip's centre: the force along n over the acceleration it
    causes there.

    Args:
        reference: whose robot it is.
        wanted: the plan at the time asked for.
    """
    model, data = reference.robot.model, reference.robot.model.createData()
    pin.computeJointJacobians(model, data, wanted.q)
    inverse = np.triu(pin.computeMinverse(model, data, wanted.q))
    inverse += np.triu(inverse, 1).T
    masses = []
    for hold in reference.phases[wanted.phase].holds:
        frame = hold.finger.tip_frame_id
        pin.updateFramePlacement(model, data, frame)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobian = pin.getFrameJacobian(model, data, frame, axes)[:3]
        along = (wanted.tool.rotation @ hold.normal) @ jacobian
        masses.append(1.0 / float(along @ inverse @ along))
    return np.array(masses)
