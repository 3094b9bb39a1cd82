"""One uncoupled sample as a conic program whose sparsity is worked out once per pattern."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces.local_form import LocalForm
from pivotgait.forces.problem import AllocationProblem

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Flags = tuple[bool, ...]
ONE, MINUS_ONE, MINUS_TWO = 1, 2, 3
"""Places of the constants in the table of a program's entries; place 0 stands for no entry."""
CONSTANTS = (0.0, 1.0, -1.0, -2.0)


@dataclass(frozen=True, eq=False)
class Pattern:
    """Sparsity of minimise 1/2 v' P v + q' v, b - A v in cones, with v = (x, auxiliary u).

    Attributes:
        quadratic: P.
        linear: q.
        indices: row of each entry of A, column by column.
        indptr: where each column begins.
        table: place of each entry in the table of values.
        shape: of A.
        rest: (rows,) zeros below the sides that are not 0.
        cones: Clarabel's cones.
    """

    quadratic: Any
    linear: Array
    indices: NDArray[np.int32]
    indptr: NDArray[np.int32]
    table: Index
    shape: tuple[int, int]
    rest: Array
    cones: list[Any]


def serves(problem: AllocationProblem) -> bool:
    """Whether :func:`assemble` can pose the problem."""
    alone = problem.samples == 1 and not problem.coupled and problem.rows is None
    return alone and problem.objective in ("tangential", "effort") and bool(problem.loaded.any())


def assemble(problem: AllocationProblem, form: LocalForm) -> tuple[Any, Array, Any, Array, Any]:
    """P, q, A, b and the cones; v begins with the coordinates of the loaded contacts.

    Args:
        problem: one that :func:`serves`.
        form: its contact coordinates.
    """
    from scipy.sparse import csc_matrix

    known, loaded = form.known[0], ~form.known[0].all(axis=-1)
    fixed, low, high = known[loaded, 2], form.low[0, loaded], form.high[0, loaded]
    bounded, capped = ~np.isnan(low), ~np.isnan(high)
    flags = (tuple(part.tolist()) for part in (fixed, bounded, capped))
    pattern = _pattern(*flags, problem.objective == "tangential")
    grasp = form.grasp.reshape(6, -1, 3)[:, loaded]
    values = np.concatenate((CONSTANTS, grasp.reshape(-1), -problem.friction[loaded]))
    given = form.value[0, loaded, 2][fixed]
    sides = (problem.wrench[0], given, -low[bounded], high[capped], pattern.rest)
    matrix = csc_matrix(
        (values[pattern.table], pattern.indices, pattern.indptr), shape=pattern.shape, copy=False
    )
    return pattern.quadratic, pattern.linear, matrix, np.concatenate(sides), pattern.cones


@lru_cache(maxsize=256)
def _pattern(fixed: Flags, bounded: Flags, capped: Flags, tangential: bool) -> Pattern:
    """The pattern of contacts with these ramps, lower bounds and upper bounds."""
    import clarabel
    from scipy.sparse import csc_matrix

    count = len(fixed)
    size = 3 * count
    width = size + count * tangential
    normal = 2 + 3 * np.arange(count)
    grasp = len(CONSTANTS) + np.arange(6 * size).reshape(6, size)
    friction = len(CONSTANTS) + 6 * size + np.arange(count)

    def rows(height: int, *entries: tuple[Any, Any, Any]) -> Index:
        out = np.zeros((height, width), dtype=np.intp)
        for row, column, place in entries:
            out[row, column] = place
        return out

    equal, low, high = (np.nonzero(np.array(flags))[0] for flags in (fixed, bounded, capped))
    blocks = [rows(6, (slice(None), slice(size), grasp))]
    for who, sign in ((equal, ONE), (low, MINUS_ONE), (high, ONE)):
        blocks.append(rows(len(who), (np.arange(len(who)), normal[who], sign)))
    cone = 3 * np.arange(count)
    blocks.append(
        rows(
            size,
            (cone, normal, friction),
            (cone + 1, normal - 2, MINUS_ONE),
            (cone + 2, normal - 1, MINUS_ONE),
        )
    )
    if tangential:
        # Auxiliary u >= |f_t|^2 / f_n, as |(n - u, 2 f_t)| <= n + u.
        u, cone = size + np.arange(count), 4 * np.arange(count)
        blocks.append(
            rows(
                4 * count,
                (cone, normal, MINUS_ONE),
                (cone, u, MINUS_ONE),
                (cone + 1, normal, MINUS_ONE),
                (cone + 1, u, ONE),
                (cone + 2, normal - 2, MINUS_TWO),
                (cone + 3, normal - 1, MINUS_TWO),
            )
        )
    places = np.concatenate(blocks).T
    column, row = np.nonzero(places)
    linear, curved = np.zeros(width), np.zeros(width)
    linear[size:] = 1.0
    curved[:size] = 0.0 if tangential else 2.0
    cones = [clarabel.ZeroConeT(6 + len(equal)), clarabel.NonnegativeConeT(len(low) + len(high))]
    cones += [clarabel.SecondOrderConeT(3)] * count
    cones += [clarabel.SecondOrderConeT(4)] * (count * tangential)
    return Pattern(
        quadratic=csc_matrix(np.diag(curved)),
        linear=linear,
        indices=row.astype(np.int32),
        indptr=np.searchsorted(column, np.arange(width + 1)).astype(np.int32),
        table=places[column, row],
        shape=(places.shape[1], width),
        rest=np.zeros(size + 4 * count * tangential),
        cones=cones,
    )
