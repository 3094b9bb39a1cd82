"""Levenberg-Marquardt within joint limits for the residuals of a chain of postures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import Robot
from pivotgait.planning.posture_residuals import NormalEquations, PostureResiduals

_LARGEST_STEP = 0.5  # [rad] or [m]: linearised tips are wrong beyond
_LEAST_STEPS = 6  # a small gain counts as the end only after these


@dataclass(frozen=True, eq=False)
class PostureFit(FrozenArrays):
    """The end of a descent.

    Attributes:
        postures: (K, nv).
        cost: sum of squared residuals.
        iterations: accepted steps.
    """

    postures: Array
    cost: float
    iterations: int


def fit_postures(
    residuals: PostureResiduals, start: Array, *, iterations: int = 40, tolerance: float = 1e-3
) -> PostureFit:
    """Descend from ``start`` (K, nv) until a step gains less than ``tolerance`` of the cost.

    Steps solve (J^T J + damping diag(J^T J)) dx = -J^T r over the joints that are free to move:
    one that lies on a limit and would only be pushed against it stands still (projected
    Levenberg-Marquardt: Kanzow, Yamashita, Fukushima, J. Comput. Appl. Math. 172, 2004). What a
    step would take beyond a limit is cut, as the start is.
    """
    robot = residuals.robot
    postures, damping = np.clip(start, robot.lower, robot.upper), 1e-2
    model, accepted, gain = residuals.normal_equations(postures), 0, np.inf
    while accepted < iterations and (gain >= tolerance or accepted < _LEAST_STEPS):
        held = _held(robot, postures, model.gradient)
        for _ in range(12):
            step = _damped_step(model, damping, robot.nv, held).reshape(postures.shape)
            step *= min(1.0, _LARGEST_STEP / max(float(np.abs(step).max()), 1e-12))
            trial = np.clip(postures + step, robot.lower, robot.upper)
            there = residuals.normal_equations(trial)
            if there.cost < model.cost:
                break
            damping *= 4.0
        else:
            break
        damping = max(0.3 * damping, 1e-7)
        gain = (model.cost - there.cost) / model.cost
        postures, model, accepted = trial, there, accepted + 1
    return PostureFit(postures, model.cost, accepted)


def _held(robot: Robot, postures: Array, gradient: Array) -> NDArray[np.bool_]:
    """Which joints (K nv,) lie on a limit that the descent would push them beyond."""
    slope = gradient.reshape(postures.shape)
    low, high = postures <= robot.lower, postures >= robot.upper
    held: NDArray[np.bool_] = (low & (slope > 0.0)) | (high & (slope < 0.0))
    return held.ravel()


def _damped_step(model: NormalEquations, damping: float, nv: int, held: NDArray[np.bool_]) -> Array:
    """Solve (J^T J + damping diag(J^T J)) dx = -J^T r, a band of two blocks; 0 where held."""
    size, free = len(model.gradient), ~held
    band = min(2 * nv, size) - 1
    lower = np.zeros((band + 1, size))
    for offset in range(band + 1):
        both = free[offset:] & free[: size - offset]
        lower[offset, : size - offset] = np.diagonal(model.normal, -offset) * both
    lower[0] += damping * (lower[0] + 1e-6) + held
    _, step, info = lapack.dpbsv(
        lower, np.where(held, 0.0, -model.gradient), lower=1, overwrite_ab=1
    )
    # Not positive definite to rounding: no step, so that the caller damps more.
    return step if info == 0 else np.zeros(size)
