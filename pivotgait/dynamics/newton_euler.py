"""Newton-Euler equations of the tool (Xue et al., eq. 3, with the pivot's force in it)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.contacts.grasp_map import skew
from pivotgait.dynamics.pivot import PivotingTool
from pivotgait.plans import ToolMotion

Array = NDArray[np.float64]


def world_inertia(inertia: Array, rotation: Rotation) -> Array:
    """I_W = R I R^T: (N, 3, 3) inertia at the centre of mass, world axes [kg m^2]."""
    turn = rotation.as_matrix()
    return np.asarray(turn @ inertia @ np.swapaxes(turn, -1, -2))


def required_wrench(tool: PivotingTool, motion: ToolMotion) -> Array:
    """Wrench that the contacts must apply about the centre of mass (eq. 3).

    f = m v' - m g and moment = I_W omega' + omega x I_W omega.

    Args:
        tool: the body.
        motion: N samples of its motion.

    Returns:
        (N, 6) rows [force; moment about o] in world axes [N, N m].
    """
    inertia = world_inertia(tool.inertia, motion.rotation)
    omega, sigma = motion.angular_velocity, motion.angular_acceleration
    force = tool.mass * (motion.linear_acceleration - tool.gravity)
    spin = np.einsum("nij,nj->ni", inertia, omega)
    moment = np.einsum("nij,nj->ni", inertia, sigma) + np.cross(omega, spin)
    return np.concatenate((force, moment), axis=-1)


def pivot_dynamics(
    tool: PivotingTool, rotation: Rotation, angular_velocity: Array
) -> tuple[Array, Array]:
    """M_o and C_o of eq. (3), M_o omega' + C_o = G f, for a tool turning about its pivot.

    Substituting eq. (2), v' = [r]x omega' - [omega]x [omega]x r with r = R_o b_c0.

    Args:
        tool: the body and its pivot.
        rotation: N orientations, world <- tool.
        angular_velocity: (N, 3) world [rad/s].

    Returns:
        M_o (N, 6, 3) and C_o (N, 6), rows [force; moment about o] in world axes.
    """
    omega = np.asarray(angular_velocity, dtype=float)
    arm = rotation.as_matrix() @ tool.pivot_in_tool
    inertia = world_inertia(tool.inertia, rotation)
    mass_matrix = np.concatenate((tool.mass * skew(arm), inertia), axis=-2)
    centripetal = -np.cross(omega, np.cross(omega, arm))
    spin = np.einsum("nij,nj->ni", inertia, omega)
    bias = np.concatenate(
        (tool.mass * (centripetal - tool.gravity), np.cross(omega, spin)), axis=-1
    )
    return mass_matrix, bias
