"""A nonlinear program made of few compiled pieces, each repeated many times over stages.

CasADi's own sparse derivatives of a mapped function take twenty sweeps over all stages, and one
long expression per stage outgrows the processor's cache (its time per stage doubles from K = 64
to 256). Here each piece's derivatives are compiled once, evaluated by one mapped call, and
added in their places by constant sparse matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Index = NDArray[np.intp]
INF = float("inf")
BLOCK = 16
"""Repetitions unrolled into one compiled block: enough to share its loading of parameters, few
enough to stay in the processor's cache."""


class Piece:
    """Rows and a cost of some variables w, with first and second derivatives.

    Args:
        ca: the casadi module.
        inputs: symbols (w, share, parameters).
        rows: expression (r,).
        cost: scalar expression.
        columns: (m, n) variables that stand for w in each of the m repetitions.
        places: (m, r) constraints that the rows add to.
        shares: (m, s) values of ``share`` in each repetition.
    """

    def __init__(
        self,
        ca: Any,
        inputs: list[Any],
        rows: Any,
        cost: Any,
        *,
        columns: Index,
        places: Index,
        shares: NDArray[np.float64],
    ) -> None:
        self.columns, self.places, self.shares = columns, places, ca.DM(shares.T)
        of_cost, of_rows = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", rows.shape[0])
        jacobian = ca.jacobian(rows, inputs[0])
        lagrangian = of_cost * cost + ca.dot(of_rows, rows)
        hessian, gradient = ca.hessian(lagrangian, inputs[0])
        self.slopes_at = np.array(jacobian.sparsity().get_triplet(), dtype=int)
        self.curvature_at = np.array(hessian.sparsity().get_triplet(), dtype=int)
        self.rows = self._mapped(ca, "rows", inputs, [rows])
        self.cost = self._mapped(ca, "cost", inputs, [cost])
        self.cost_slopes = self._mapped(ca, "cost_slopes", inputs, [ca.gradient(cost, inputs[0])])
        self.slopes = self._mapped(ca, "slopes", inputs, [jacobian.nz[:]])
        outputs = [gradient, hessian.nz[:]]
        self.curvature = self._mapped(ca, "curvature", [*inputs, of_cost, of_rows], outputs)

    def _mapped(self, ca: Any, name: str, inputs: list[Any], outputs: list[Any]) -> Any:
        """One call for all repetitions; parameters and the cost's weight are the same in each."""
        function, shared = ca.Function(name, inputs, ca.cse(outputs)), [2, 3][: len(inputs) - 2]
        whole, left = divmod(len(self.columns), BLOCK)
        symbols = [
            ca.MX.sym(f"i{k}", symbol.shape[0], 1 if k in shared else len(self.columns))
            for k, symbol in enumerate(inputs)
        ]
        values: list[list[Any]] = []
        for count, times, first in ((BLOCK, whole, 0), (left, 1, whole * BLOCK)):
            if count and times:
                flat = function.map(name, "serial", count, shared, []).expand()
                last = first + count * times
                given = [
                    symbol if k in shared else symbol[:, first:last]
                    for k, symbol in enumerate(symbols)
                ]
                found = flat.map(name, "serial", times, shared, [])(*given)
                values.append(list(found) if isinstance(found, tuple) else [found])
        return ca.Function(
            name, symbols, [ca.horzcat(*parts) for parts in zip(*values, strict=True)]
        )

    def w(self, ca: Any, v: Any) -> Any:
        """(n, m) the variables of every repetition."""
        return ca.reshape(_take(ca, v, self.columns), *self.columns.shape[::-1])


@dataclass(frozen=True)
class Program:
    """The program as CasADi symbols and functions.

    Attributes:
        variables, parameters, objective, constraints: symbols.
        ascent: (x, p) -> gradient of the objective.
        slopes: (x, p) -> constraints, their Jacobian.
        curvature: (x, p, lam_f, lam_g) -> gradient and Hessian of the Lagrangian.
        equality: which constraints are equations to 0; the others are at least 0.
    """

    variables: Any
    parameters: Any
    objective: Any
    constraints: Any
    ascent: Any
    slopes: Any
    curvature: Any
    equality: list[bool]

    @property
    def symbols(self) -> dict[str, Any]:
        """The program as ``casadi.nlpsol`` takes it."""
        return {
            "x": self.variables,
            "f": self.objective,
            "g": self.constraints,
            "p": self.parameters,
        }

    @property
    def upper(self) -> list[float]:
        """Upper bounds of the constraints; the lower ones are 0."""
        return [0.0 if each else INF for each in self.equality]

    def upper_curvature(self, ca: Any) -> Any:
        """(x, p, lam_f, lam_g) -> upper triangle of the Hessian, as IPOPT's interface wants."""
        x, p, of_cost, of_rows = (self.curvature.mx_in(i) for i in range(4))
        hessian = self.curvature(x, p, of_cost, of_rows)[1]
        names = ["x", "p", "lam_f", "lam_g"]
        return ca.Function(
            "nlp_hess_l",
            [x, p, of_cost, of_rows],
            [ca.triu(hessian)],
            names,
            ["triu_hess_gamma_x_x"],
        )


def assemble(
    ca: Any,
    sizes: tuple[int, int, int],
    pieces: list[Piece],
    linear: tuple[Index, Index],
    offset: Any,
    *,
    scale: float,
    equality: list[bool],
) -> Program:
    """Add up pieces to a program.

    Args:
        ca: the casadi module.
        sizes: numbers of variables, constraints, parameters.
        pieces: their rows add to constraints, their costs to the objective.
        linear: (rows, columns) of ones: the linear part of the constraints.
        offset: function of the parameters, subtracted from the constraints.
        scale: factor of the cost.
        equality: which constraints are equations.
    """
    many, rows, count = sizes
    v, p = ca.MX.sym("v", many), ca.MX.sym("p", count)
    of_cost, of_rows = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", rows)
    ones = np.ones(len(linear[0]))
    constant = sparse.csc_matrix((ones, linear), shape=(rows, many))
    objective, ascent = 0.0, ca.MX.zeros(many)
    constraints = _constant(ca, constant) @ v - offset(p)
    gradient = _constant(ca, constant.T.tocsc()) @ of_rows
    slopes = [(linear[0], linear[1], ca.DM(ones))]
    curves: list[tuple[Index, Index, Any]] = []
    for piece in pieces:
        inputs = (piece.w(ca, v), piece.shares, p)
        objective += scale * ca.sum2(piece.cost(*inputs))
        into = _spread(ca, many, piece.columns)
        ascent += scale * (into @ ca.vec(piece.cost_slopes(*inputs)))
        constraints += _spread(ca, rows, piece.places) @ ca.vec(piece.rows(*inputs))
        lam = ca.reshape(_take(ca, of_rows, piece.places), *piece.places.shape[::-1])
        turned, curved = piece.curvature(*inputs, scale * of_cost, lam)
        gradient += into @ ca.vec(turned)
        i, j = piece.slopes_at
        slopes.append((piece.places[:, i], piece.columns[:, j], ca.vec(piece.slopes(*inputs))))
        i, j = piece.curvature_at
        curves.append((piece.columns[:, i], piece.columns[:, j], ca.vec(curved)))
    jacobian = _sparse(ca, (rows, many), slopes)
    hessian = _sparse(ca, (many, many), curves)
    names = ["x", "p", "lam_f", "lam_g"]
    outputs = ["grad_gamma_x", "hess_gamma_x_x"]
    return Program(
        variables=v,
        parameters=p,
        objective=objective,
        constraints=constraints,
        ascent=ca.Function("nlp_grad_f", [v, p], [ascent], names[:2], ["grad_f_x"]),
        slopes=ca.Function(
            "nlp_jac_g", [v, p], [constraints, jacobian], names[:2], ["g", "jac_g_x"]
        ),
        curvature=ca.Function(
            "nlp_hess_l", [v, p, of_cost, of_rows], [gradient, hessian], names, outputs
        ),
        equality=equality,
    )


def _constant(ca: Any, matrix: Any) -> Any:
    pattern = ca.Sparsity(*matrix.shape, matrix.indptr.tolist(), matrix.indices.tolist())
    return ca.DM(pattern, matrix.data)


def _take(ca: Any, vector: Any, index: Index) -> Any:
    """Entries of a vector in the order of ``index``; a few slices where that is possible."""
    flat = index.ravel()
    breaks = np.flatnonzero(np.diff(flat) != 1) + 1
    if len(breaks) > 8:
        return vector[flat.tolist()]
    runs = np.split(flat, breaks)
    return ca.vertcat(*[vector[int(run[0]) : int(run[-1]) + 1] for run in runs])


def _spread(ca: Any, size: int, places: Index) -> Any:
    """Matrix that adds entries to their places, in the order of ``places`` (m, r)."""
    flat = places.ravel()
    ones, entries = np.ones(len(flat)), np.arange(len(flat))
    return _constant(ca, sparse.csc_matrix((ones, (flat, entries)), shape=(size, len(flat))))


def _sparse(ca: Any, shape: tuple[int, int], parts: list[tuple[Index, Index, Any]]) -> Any:
    """Sparse matrix from (rows, columns, values); values at one place add up."""
    rows = np.concatenate([row.ravel() for row, _, _ in parts])
    columns = np.concatenate([column.ravel() for _, column, _ in parts])
    nonzeros = ca.vertcat(*[value for _, _, value in parts])
    # column by column, as CasADi stores matrices
    places, where = np.unique(columns * shape[0] + rows, return_inverse=True)
    at = (places % shape[0]).tolist(), (places // shape[0]).tolist()
    pattern = ca.Sparsity.triplet(*shape, *at)
    if len(places) == len(where):  # nothing to add up: only reorder
        return ca.MX(pattern, nonzeros[np.argsort(where).tolist()])
    ones, entries = np.ones(len(where)), np.arange(len(where))
    adding = sparse.csc_matrix((ones, (where, entries)), shape=(len(places), len(where)))
    return ca.MX(pattern, _constant(ca, adding) @ nonzeros)
