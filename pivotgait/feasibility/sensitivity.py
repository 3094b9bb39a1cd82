"""How the depth of a grasp answers to each of its data: exact, by the multipliers of one SOCP."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.limits import limit_push, separating_twist
from pivotgait.forces.local_form import local_form
from pivotgait.forces.null_space import Inconsistent, reduce
from pivotgait.forces.phase_one import phase_one
from pivotgait.frozen import Array, FrozenArrays


@dataclass(frozen=True, eq=False)
class Sensitivity(FrozenArrays):
    """Derivatives of the depth of B grasps [N per unit]; NaN where the wrench is out of reach.

    The depth is the largest tau for which every limit can be tightened by tau: |f_t| <= mu f_n -
    tau, f_n >= min + tau, f_n <= max - tau. With the optimum's forces f, cone multipliers
    (y_t, lambda), bound multipliers alpha (min), beta (max) and the equations' multiplier t, the
    envelope theorem gives the derivatives named below. A lower bound of 0 says the same as the
    cone and counts as absent.

    Attributes:
        depth: (B,) [N], negative where infeasible.
        friction: (B, m) lambda f_n [N].
        normal_max: (B, m) beta [-].
        normal_min: (B, m) -alpha [-].
        wrench: (B, 6) -t, by the wrench [-, 1/m].
        lever: (B, m, 3) f x t_angular, by the contact points [N/m].
        normals: (B, m, 3) p_n f_t - f_n p_t, by the unit normals (tangent to the sphere) [N],
            with the multipliers' push p at the contact.
    """

    depth: Array
    friction: Array
    normal_max: Array
    normal_min: Array
    wrench: Array
    lever: Array
    normals: Array


def sensitivity(grasps: Grasps) -> Sensitivity:
    """Depth of B grasps and its derivatives.

    Where the optimum's multipliers are not unique the depth has a kink, and these are one of its
    subgradients.

    Args:
        grasps: B grasps of one shape.
    """
    count, m = grasps.friction.shape
    depth = np.full(count, -np.inf)
    by_contact = {n: np.full((count, m), np.nan) for n in ("friction", "normal_max", "normal_min")}
    wrench = np.full((count, 6), np.nan)
    lever, normals = np.full((count, m, 3), np.nan), np.full((count, m, 3), np.nan)
    form = local_form(grasps.problem)
    for group in reduce(form, grasps.problem.wrench, grasps.friction):
        if isinstance(group, Inconsistent):
            continue
        at, end = group.index, phase_one(group.cones, exact=True)
        depth[at] = -end.shift * group.scale
        local, push = group.forces(end.z), limit_push(form, group, end.dual)
        cone, scalar = group.cones.split(end.dual)
        for part in by_contact.values():
            part[at] = 0.0
        for place, contact in enumerate(group.loaded):
            by_contact["friction"][at, contact] = cone[2, place] * local[:, contact, 2]
        for k, (kind, contact) in enumerate(group.labels[len(group.loaded) :]):
            if kind != "rows":
                sign = 1.0 if kind == "normal_max" else -1.0
                by_contact[kind][at, contact] = sign * scalar[k]
        twist = separating_twist(form, group, end.dual)
        frames = form.frames[at]
        force = (frames @ local[..., None])[..., 0]
        tilt = push[..., 2:] * local - local[..., 2:] * push
        tilt[..., 2] = 0.0
        wrench[at] = -twist
        lever[at] = np.cross(force, twist[:, None, 3:])
        normals[at] = (frames @ tilt[..., None])[..., 0]
    return Sensitivity(depth=depth, wrench=wrench, lever=lever, normals=normals, **by_contact)
