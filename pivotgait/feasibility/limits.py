"""The limits of contacts as one matrix, and what their multipliers say about the tool."""

from __future__ import annotations

import numpy as np

from pivotgait.forces.local_form import LocalForm
from pivotgait.forces.null_space import Reduced
from pivotgait.frozen import Array


def limit_matrix(form: LocalForm, group: Reduced) -> Array:
    """(B, q, 3 m) K: the slacks of a reduced group are K x + k in contact coordinates x.

    Args:
        form: of the whole batch.
        group: of the samples in question.
    """
    count, m, cones = len(group.index), form.known.shape[1], len(group.loaded)
    out = np.zeros((count, 3 * cones + len(group.labels) - cones, 3 * m))
    for place, contact in enumerate(group.loaded):
        out[:, place, 3 * contact] = out[:, cones + place, 3 * contact + 1] = 1.0
        out[:, 2 * cones + place, 3 * contact + 2] = group.cones.head[place]
    lower = np.isfinite(form.lower[group.index[0]]).tolist() if form.rows.shape[1] else []
    for k, (kind, index) in enumerate(group.labels[cones:], start=3 * cones):
        if kind == "rows":
            # the rows with a lower limit come first, then those with an upper one
            sign, lower[index] = (1.0 if lower[index] else -1.0), False
            rows = form.rows[group.index][:, index]
            norm = np.linalg.norm(rows, axis=1, keepdims=True)
            out[:, k] = sign * rows / np.where(norm > 0.0, norm, 1.0)
        else:
            out[:, k, 3 * index + 2] = 1.0 if kind == "normal_min" else -1.0
    return out


def tightest_labels(group: Reduced, dual: Array) -> list[tuple[str, int]]:
    """Kind and contact (or row) of the limit with the largest multiplier, of each of B samples.

    Args:
        group: the samples.
        dual: (q, B) multipliers of their limits.
    """
    cone, scalar = group.cones.split(dual)
    weight = np.concatenate((cone[2], scalar))
    return [group.labels[k] for k in np.argmax(weight, axis=0).tolist()]


def limit_push(form: LocalForm, group: Reduced, dual: Array) -> Array:
    """(B, m, 3) K' y: multipliers (q, B) of the limits as pushes on the contact coordinates."""
    push = np.einsum("bqj,qb->bj", limit_matrix(form, group), dual)
    return np.asarray(push.reshape(dual.shape[1], -1, 3))


def separating_twist(form: LocalForm, group: Reduced, dual: Array) -> Array:
    """(B, 6) twists along which the limits stand against the load.

    With multipliers y of the limits K f + k in the cones, stationarity gives K' y = -G' t. For
    forces within the limits y . (K f + k) >= 0, hence t . G f <= y . k.

    Args:
        form: of the whole batch.
        group: of the samples in question.
        dual: (q, B) multipliers.
    """
    push = limit_push(form, group, dual).reshape(dual.shape[1], -1, 1)
    equations = equation_matrix(form, group)
    free = ~form.known[group.index[0]].reshape(-1)
    back = np.swapaxes(equations[:, :, free], 1, 2)
    return np.asarray(-(np.linalg.pinv(back, rcond=1e-10) @ push[:, free])[:, :6, 0])


def equation_matrix(form: LocalForm, group: Reduced) -> Array:
    """(B, 6 + e, 3 m) grasp map over the rows whose two limits are equal."""
    grasp = form.grasp[group.index]
    if not form.rows.shape[1]:
        return grasp
    equal = form.lower[group.index[0]] == form.upper[group.index[0]]
    return np.concatenate((grasp, form.rows[group.index][:, equal]), axis=1)
