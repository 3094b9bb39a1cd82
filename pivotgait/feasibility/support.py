"""The wrenches that contacts can apply, by their support function: closed form, no solver.

Contacts act independently, so that the set of wrenches is the Minkowski sum of one set for each
contact, and its support function the sum of theirs. For a unit of force along the direction p, a
contact with f_n in [lo, hi] and |f_t| <= mu f_n gives at most f_n (p_n + mu |p_t|).
"""

from __future__ import annotations

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.feasibility.grasps import Grasps
from pivotgait.frozen import Array


def support(grasps: Grasps, twist: Array) -> Array:
    """Largest twist . wrench that contact forces within cones and bounds apply.

    Read as power: ``twist`` is a velocity of the tool, and the forces' power is at most this.
    Where it is less than ``twist`` . load the grasp cannot hold: that proves infeasibility, see
    :func:`holding_power`.

    Args:
        grasps: B grasps without rows.
        twist: (B, ..., 6) [velocity of the centre of mass; angular velocity], any units.

    Returns:
        (B, ...), ``inf`` where a contact without an upper bound can push along.

    Raises:
        InputError: for grasps with rows (joint torque limits), which couple the contacts.
    """
    problem = grasps.problem
    if problem.rows is not None and problem.rows.count:
        raise InputError("rows couple the contacts", mend="use feasibility.rays for these grasps")
    middle = tuple(range(1, twist.ndim - 1))

    def spread(value: Array) -> Array:
        return np.expand_dims(value, middle)

    linear, angular = twist[..., None, :3], twist[..., None, 3:]
    normals = spread(problem.normals)
    velocity = linear + np.cross(angular, spread(problem.lever))  # (B, ..., m, 3)
    along = np.sum(velocity * normals, axis=-1)
    sideways = np.linalg.norm(velocity - along[..., None] * normals, axis=-1)
    gain = along + spread(grasps.friction) * sideways

    fixed = problem.fixed
    low = spread(np.where(np.isnan(fixed), problem.normal_min, fixed))
    high = spread(np.where(np.isnan(fixed), problem.normal_max, fixed))
    bounded = np.where(np.isfinite(high), high, 0.0) * gain
    most = np.where(np.isfinite(high), bounded, np.where(gain > 0.0, np.inf, 0.0))
    return np.asarray(np.where(gain > 0.0, most, low * gain).sum(axis=-1))


def holding_power(grasps: Grasps, twist: Array) -> Array:
    """(B, ...) how much more than the load the contacts can oppose along a twist.

    support(twist) - twist . w with the wrench w that the contacts have to apply. Negative at any
    twist: no forces hold the grasp. Not negative at all twists: some do.
    """
    middle = tuple(range(1, twist.ndim - 1))
    load = np.expand_dims(grasps.problem.wrench, middle)
    return np.asarray(support(grasps, twist) - np.sum(twist * load, axis=-1))
