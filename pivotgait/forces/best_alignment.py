"""The objective ``alignment`` (Xue et al., eq. 4): the best of several local minima.

Local minima differ in which contact they give up: its force leans, lightly pressed, so that the
others may align. There is a start that leaves out each contact, and one from the middle of the
feasible set. About one random grasp in a thousand still has a better minimum than they find;
ten random starts of IPOPT miss more.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.goal import Goal
from pivotgait.forces.primal_dual import minimise, require_optimal

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
LEFT_OUT = 0.03
"""Weight of the contact a start leaves out; not 0, which would leave its force undecided."""
LEAVING_STEPS = 4
"""Newton steps with that weight: enough to cross into the basin, as the whole path is short."""
AWAY = 0.9
"""How far from the middle towards the end of those steps the start lies."""
ROUGH_GAP, ROUGH_RESIDUAL = 1e-2, 1e-3
"""Starts are first followed this far: enough to tell their minima apart."""
CLOSE = 5e-2
"""Those within this share of the best value are finished."""
ROOM = 1e-3
"""Problems whose middle is this deep inside are followed roughly in single precision."""
ACCEPTED = 1e-4
"""Where a contact's force may vanish or squeezing has no end, the least sum of sin^2 is not
attained but neared ever more slowly: the steps may run out this far above it."""
APART = 1e-2
"""Ends of one problem nearer than this, in units of its force scale, are the same minimum."""


def best_alignment(cones: ConeBatch, z: Array) -> tuple[Array, int]:
    """Best points (d, B) and the Newton steps of the slowest problem.

    Args:
        cones: the constraints.
        z: (d, B) strictly feasible points.
    """
    if cones.cones < 3 or z.shape[0] < 2:
        end = minimise(cones, Goal(smooth="alignment"), z)
        require_optimal(end, ACCEPTED)
        return end.z, int(end.iterations.max())
    roomy = cones.interior(cones.slack(z)) > ROOM
    out, steps = np.array(z), 0
    for mask, precision in ((roomy, np.float32), (~roomy, np.float64)):
        part = np.nonzero(mask)[0]
        if part.size:
            out[:, part], used = _best_of_starts(cones.take(part), z[:, part], precision)
            steps = max(steps, used)
    return out, steps


def _best_of_starts(cones: ConeBatch, z: Array, precision: type[Any]) -> tuple[Array, int]:
    count, batch = cones.head.shape
    goal = Goal(smooth="alignment")

    # Start j < count leaves contact j out, start j = count is the middle.
    copies = np.tile(np.arange(batch), count + 1)
    many = cones.astype(precision).take(copies)
    middle = cast(Array, z.astype(precision))[:, copies]
    weight = np.ones((count, count + 1, batch), dtype=precision)
    weight[np.arange(count), np.arange(count)] = LEFT_OUT
    leaving = Goal(smooth="alignment", weight=weight.reshape(count, -1))
    away = minimise(many, leaving, middle, limit=LEAVING_STEPS)

    def rough(value: Array, gap: Array, residual: Array) -> Mask:
        return np.asarray((gap <= ROUGH_GAP * value) & (residual <= ROUGH_RESIDUAL))

    # Fresh duals and some of the middle again, or a start stays in the corner it grew into.
    back = middle + AWAY * (away.z - middle)
    end = minimise(many, goal, back, stop=rough)
    value = end.value.reshape(count + 1, batch)
    best = value.min(axis=0)
    hopeful = np.nonzero((value <= best * (1.0 + CLOSE)).reshape(-1))[0]
    hopeful = _distinct(hopeful, end.z, batch)

    which = hopeful % batch
    finalists, near = cones.take(which), end.z[:, hopeful].astype(float)
    near = np.where(finalists.inside(finalists.slack(near)), near, z[:, which])
    last = minimise(finalists, goal, near, dual=end.dual[:, hopeful])
    require_optimal(last, ACCEPTED)
    order = np.argsort(-last.value, kind="stable")
    out = np.array(z)
    out[:, which[order]] = last.z[:, order]
    steps = away.iterations.max() + end.iterations.max() + last.iterations.max()
    return out, int(steps)


def _distinct(index: NDArray[np.intp], z: Array, batch: int) -> NDArray[np.intp]:
    """Leave out ends that lie close to an earlier one of the same problem."""
    keep: list[NDArray[np.intp]] = []
    seen = np.full((len(z), batch), np.inf)
    for k in range(int(index.max()) // batch + 1):
        mine = index[index // batch == k]
        problem = mine % batch
        far = ~(np.abs(z[:, mine] - seen[:, problem]).max(axis=0) <= APART)
        seen[:, problem[far]] = z[:, mine[far]]
        keep.append(mine[far])
    return np.concatenate(keep)
