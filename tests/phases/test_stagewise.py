"""Derivatives assembled stage by stage against CasADi's own and against differences."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from pivotgait.benchmarks.removal import removal_instances
from pivotgait.phases.removal_model import RemovalProgram, removal_program
from pivotgait.phases.removal_nlp import RemovalNlp
from pivotgait.phases.removal_packing import pack

STEPS = 20  # more than one block of stages and a remainder
PROBLEM = next(iter(removal_instances(STEPS).values()))


@pytest.fixture(scope="module", params=[False, True], ids=["free", "rated"])
def program(request: pytest.FixtureRequest) -> RemovalProgram:
    points = len(PROBLEM.clear_rise)
    return removal_program(STEPS, PROBLEM.staying, points, rated=request.param, scale=3.0)


@pytest.fixture
def point(program: RemovalProgram) -> dict[str, Any]:
    rng = np.random.default_rng(1)
    nlp = RemovalNlp(STEPS, PROBLEM.staying, len(PROBLEM.clear_rise), "ipopt", False, False)
    x = nlp.guess(PROBLEM, None) + 0.1 * rng.normal(size=program.nlp.variables.shape[0])
    return {
        "x": x,
        "p": pack(PROBLEM),
        "lam_f": 0.7,
        "lam_g": rng.normal(size=program.nlp.constraints.shape[0]),
    }


def by_casadi(program: RemovalProgram) -> Any:
    nlp = program.nlp
    of_cost, of_rows = ca.MX.sym("f"), ca.MX.sym("g", nlp.constraints.shape[0])
    lagrangian = of_cost * nlp.objective + ca.dot(of_rows, nlp.constraints)
    hessian, gradient = ca.hessian(lagrangian, nlp.variables)
    jacobian = ca.jacobian(nlp.constraints, nlp.variables)
    ascent = ca.gradient(nlp.objective, nlp.variables)
    inputs = [nlp.variables, nlp.parameters, of_cost, of_rows]
    return ca.Function("own", inputs, [jacobian, gradient, hessian, ascent])


def test_derivatives_equal_those_of_automatic_differentiation(
    program: RemovalProgram, point: dict[str, Any]
) -> None:
    jacobian, gradient, hessian, ascent = by_casadi(program)(*point.values())
    x, p = point["x"], point["p"]
    _, ours = program.nlp.slopes(x, p)
    turned, curved = program.nlp.curvature(*point.values())
    # sums of a few hundred products of order 1e2 in double precision
    close = {"rtol": 1e-11, "atol": 1e-9}
    np.testing.assert_allclose(ours.full(), jacobian.full(), **close)
    np.testing.assert_allclose(turned.full(), gradient.full(), **close)
    np.testing.assert_allclose(curved.full(), hessian.full(), **close)
    np.testing.assert_allclose(program.nlp.ascent(x, p).full(), ascent.full(), **close)
    upper = program.nlp.upper_curvature(ca)(*point.values())
    np.testing.assert_allclose(upper.full(), np.triu(hessian.full()), **close)


def test_jacobian_matches_central_differences(
    program: RemovalProgram, point: dict[str, Any]
) -> None:
    x, p, step = point["x"], point["p"], 1e-6
    _, jacobian = program.nlp.slopes(x, p)
    exact = jacobian.full()
    rng = np.random.default_rng(2)
    for column in rng.choice(len(x), size=40, replace=False):
        change = np.zeros(len(x))
        change[column] = step
        up, down = program.nlp.slopes(x + change, p)[0], program.nlp.slopes(x - change, p)[0]
        difference = (up.full() - down.full()).ravel() / (2.0 * step)
        # rounding of rows of order 1e2 over the step, and third derivatives times its square
        np.testing.assert_allclose(exact[:, column], difference, atol=1e-6, rtol=1e-6)


def test_equations_come_with_zero_upper_bounds(program: RemovalProgram) -> None:
    upper = np.array(program.nlp.upper)
    assert np.all((upper == 0.0) == np.array(program.nlp.equality))
    assert np.all(np.isinf(upper[upper != 0.0]))
    # FATROP's sizes account for every variable and, without rates, every constraint
    variables = sum(program.states) + sum(program.controls)
    assert variables == program.nlp.variables.shape[0]
    rates = STEPS * (PROBLEM.staying + 1)
    rows = sum(program.path_rows) + 7 * (STEPS - 1)
    assert len(upper) - rows in (0, rates)
