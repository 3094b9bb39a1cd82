"""Speeds and accelerations of sampled configurations that keep fingertips on a moving tool."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from pivotgait.frozen import Array
from pivotgait.kinematics.closed_chain import ClosedChain
from pivotgait.kinematics.projection import resolve
from pivotgait.plans import ToolMotion


def differentiate(
    chain: ClosedChain, time: Array, tool: ToolMotion, q: Array, weights: Array | None = None
) -> tuple[Array, Array]:
    """Joint velocities and accelerations of samples from rest to rest.

    Velocities are those of the quintic spline through the samples, corrected by least norm so
    that A v = b (eq. 9); accelerations those of the cubic spline through these velocities,
    corrected so that A a = db/dt - dA/dt v. From the velocities, not from q again: the tool of a
    removal moves by Euler's rule, so that the corrections are not small.

    Args:
        chain: the holding fingers.
        time: (N,) [s].
        tool: N samples.
        q: (N, nv) on eq. (9) at each sample.
        weights: (nv,) metric of the corrections, ones if not given.

    Returns:
        v and a, (N, nv) each.
    """
    turn, v, a = tool.rotation.as_matrix(), np.empty_like(q), np.empty_like(q)
    wanted = _derivative(time, q, orders_at_rest=(1, 2))
    for k in range(len(time)):
        chain.update(q[k], turn[k], tool.position[k])
        rate = chain.target_rate(tool.linear_velocity[k], tool.angular_velocity[k])
        v[k] = resolve(chain, rate, wanted[k], weights=weights)
    wanted = _derivative(time, v, orders_at_rest=(1,))
    for k in range(len(time)):
        chain.update(q[k], turn[k], tool.position[k])
        bias = chain.bias(
            v[k],
            tool.linear_velocity[k],
            tool.angular_velocity[k],
            tool.linear_acceleration[k],
            tool.angular_acceleration[k],
        )
        a[k] = resolve(chain, bias, wanted[k], weights=weights)
    return v, a


def _derivative(time: Array, samples: Array, *, orders_at_rest: tuple[int, ...]) -> Array:
    """(N, nv) of the spline through samples; its derivatives of these orders vanish at its ends."""
    zero = np.zeros(samples.shape[1])
    ends: Any = [(order, zero) for order in orders_at_rest]
    degree = 2 * len(orders_at_rest) + 1
    spline = make_interp_spline(time, samples, k=degree, bc_type=(ends, ends))
    return np.asarray(spline.derivative()(time))
