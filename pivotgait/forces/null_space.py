"""Samples of equal pattern, reduced to the null space of their equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.local_form import LocalForm

Array = NDArray[np.float64]
Index = NDArray[np.intp]
RANK_TOLERANCE = 1e-8
"""Singular values below this share of the largest are zero: two point contacts leave the moment
about their line at rounding size."""
CONSISTENCY = 1e-8
"""A wrench further from the grasp's range than this share of its size cannot be applied."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """B samples of equal pattern: x = scale * (origin + basis @ z).

    Attributes:
        index: (B,) the samples.
        scale: (B,) [N] forces are solved in units of it.
        origin: (B, 3 m) a solution of the equations, scaled.
        basis: (B, 3 m, d) orthonormal null space.
        cones: the friction cones of loaded contacts, then the bounds and rows.
        labels: for each cone, then each scalar slack, (kind, index of contact or row).
        loaded: (c,) the contacts with a cone.
    """

    index: Index
    scale: Array
    origin: Array
    basis: Array
    cones: ConeBatch
    labels: tuple[tuple[str, int], ...]
    loaded: Index

    def forces(self, z: Array) -> Array:
        """(B, m, 3) contact coordinates [N] at z (d, B)."""
        x = self.origin + (self.basis @ z.T[..., None])[..., 0]
        return np.asarray(self.scale[:, None] * x).reshape(z.shape[1], -1, 3)


@dataclass(frozen=True, eq=False)
class Inconsistent:
    """Samples whose wrench no forces can apply.

    Attributes:
        index: (B,) the samples.
        residual: (B,) [N], moments over the size of the grasp.
    """

    index: Index
    residual: Array


def reduce(form: LocalForm, wrench: Array, friction: Array) -> Iterator[Reduced | Inconsistent]:
    """Split the samples by pattern and rank, and reduce each group.

    Args:
        form: the problem in contact coordinates.
        wrench: (T, 6).
        friction: (T, m).
    """
    equal = form.lower == form.upper
    pattern = np.concatenate(
        (
            form.known.reshape(len(wrench), -1),
            np.isnan(form.low),
            np.isnan(form.high),
            equal,
            np.isinf(form.lower) | equal,
            np.isinf(form.upper) | equal,
        ),
        axis=1,
    )
    for index in _groups(pattern):
        yield from _reduce_group(form, wrench, friction, index)


def _groups(pattern: NDArray[np.bool_]) -> list[Index]:
    if np.all(pattern == pattern[0]):
        return [np.arange(len(pattern))]
    _, which = np.unique(pattern, axis=0, return_inverse=True)
    which = which.reshape(-1)
    return [np.nonzero(which == k)[0] for k in range(which.max() + 1)]


def _reduce_group(
    form: LocalForm, wrench: Array, friction: Array, index: Index
) -> Iterator[Reduced | Inconsistent]:
    first = index[0]
    known = form.known[first].reshape(-1)
    free = np.nonzero(~known)[0]
    given = form.value[index].reshape(len(index), -1)
    equal = form.lower[first] == form.upper[first]

    # Moments over the grasp's size, rows over their norm: every equation in newtons.
    grasp = form.grasp[index]
    size = np.sqrt(np.mean(np.sum(grasp[:, 3:] ** 2, axis=1), axis=1))
    size = np.where(size > 0.0, size, 1.0)
    weight = np.concatenate((np.ones((len(index), 3)), np.repeat(1.0 / size[:, None], 3, 1)), 1)
    norm = _row_norm(form.rows[index][:, equal])
    matrix = np.concatenate(
        (grasp * weight[..., None], form.rows[index][:, equal] / norm[..., None]), axis=1
    )
    side = np.concatenate((wrench[index] * weight, form.lower[index][:, equal] / norm), axis=1)
    scale = np.maximum(np.abs(side).max(axis=1), np.nan_to_num(form.low[index]).max(axis=1))
    scale = np.maximum(scale, given.max(axis=1))
    high = np.nan_to_num(form.high[index]).max(axis=1)
    scale = np.where(scale > 1e-9 * high, scale, np.where(high > 0.0, high, 1.0))

    side = (side - (matrix @ given[..., None])[..., 0]) / scale[:, None]
    given = given / scale[:, None]
    for part, origin, basis in _null_spaces(matrix[:, :, free], side):
        miss = (matrix[part][:, :, free] @ origin[..., None])[..., 0] - side[part]
        miss_size = np.linalg.norm(miss, axis=1)
        bad = miss_size > CONSISTENCY
        if bad.any():
            yield Inconsistent(index[part[bad]], (miss_size * scale[part])[bad])
        keep = np.nonzero(~bad)[0]
        if keep.size == 0:
            continue
        part = part[keep]
        x = given[part]
        x[:, free] += origin[keep]
        null = np.zeros((len(part), known.size, basis.shape[2]))
        null[:, free] = basis[keep]
        yield _constrain(form, friction, index[part], scale[part], x, null)


def _null_spaces(matrix: Array, side: Array) -> Iterator[tuple[Index, Array, Array]]:
    """Least-norm solutions and orthonormal null spaces, by rank; QR where the rank is full."""
    batch, rows, columns = matrix.shape
    full = np.zeros(batch, dtype=bool)
    if columns >= rows:
        q, r = np.linalg.qr(np.swapaxes(matrix, 1, 2), mode="complete")
        corner = np.abs(np.diagonal(r, axis1=1, axis2=2))
        full = corner.min(axis=1) > 1e-6 * corner.max(axis=1)
        if full.any():
            part = np.nonzero(full)[0]
            triangle = np.swapaxes(r[part][:, :rows], 1, 2)
            y = np.linalg.solve(triangle, side[part][..., None])
            yield part, (q[part][:, :, :rows] @ y)[..., 0], q[part][:, :, rows:]
    rest = np.nonzero(~full)[0]
    if rest.size == 0:
        return
    u, sigma, vt = np.linalg.svd(matrix[rest], full_matrices=True)
    rank = np.sum(sigma > RANK_TOLERANCE * np.maximum(sigma[:, :1], 1e-300), axis=1)
    for r_ in np.unique(rank):
        k = np.nonzero(rank == r_)[0]
        y = np.swapaxes(u[k][:, :, :r_], 1, 2) @ side[rest[k]][..., None] / sigma[k][:, :r_, None]
        back = np.swapaxes(vt[k], 1, 2)
        yield rest[k], (back[:, :, :r_] @ y)[..., 0], back[:, :, r_:]


def _constrain(
    form: LocalForm, friction: Array, index: Index, scale: Array, origin: Array, basis: Array
) -> Reduced:
    first = index[0]
    batch, d = len(index), basis.shape[2]
    m = basis.shape[1] // 3
    by_contact = basis.reshape(batch, m, 3, d)
    start = origin.reshape(batch, m, 3)
    loaded = np.nonzero(~form.known[first].all(axis=1))[0]
    head = np.array(friction[index][:, loaded])

    cone, cone0 = np.array(by_contact[:, loaded]), np.array(start[:, loaded])
    cone[:, :, 2] *= head[..., None]
    cone0[:, :, 2] *= head
    blocks = [np.swapaxes(cone, 1, 2).reshape(batch, 3 * len(loaded), d)]
    offsets = [np.swapaxes(cone0, 1, 2).reshape(batch, 3 * len(loaded))]
    labels = [("friction", int(i)) for i in loaded]
    for kind, bound, sign in (("normal_min", form.low, 1.0), ("normal_max", form.high, -1.0)):
        who = np.nonzero(~np.isnan(bound[first]))[0]
        labels += [(kind, int(i)) for i in who]
        blocks.append(sign * by_contact[:, who, 2])
        offsets.append(sign * (start[:, who, 2] - bound[index][:, who] / scale[:, None]))
    equal = form.lower[first] == form.upper[first]
    for limit, sign in ((form.lower, 1.0), (form.upper, -1.0)):
        who = np.nonzero(np.isfinite(limit[first]) & ~equal)[0]
        labels += [("rows", int(i)) for i in who]
        rows = form.rows[index][:, who]
        norm = _row_norm(rows)
        rows = rows / norm[..., None]
        blocks.append(sign * (rows @ basis))
        offset = (rows @ origin[..., None])[..., 0] - limit[index][:, who] / (norm * scale[:, None])
        offsets.append(sign * offset)
    matrix = np.moveaxis(np.concatenate(blocks, axis=1), 0, -1)
    offset = np.concatenate(offsets, axis=1).T
    cones = ConeBatch(*(np.ascontiguousarray(part) for part in (matrix, offset, head.T)))
    return Reduced(index, scale, origin, basis, cones, tuple(labels), loaded)


def _row_norm(rows: Array) -> Array:
    norm = np.linalg.norm(rows, axis=-1)
    return np.where(norm > 0.0, norm, 1.0)
