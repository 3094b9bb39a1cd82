"""Removal against independent solvers of the same problem, on tools, fingers and frictions."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.benchmarks.removal import removal_instances
from pivotgait.phases.removal_nlp import solve_removal
from pivotgait.phases.removal_problem import RemovalProblem
from pivotgait.phases.removal_socp import solve_removal_by_socps

INSTANCES = removal_instances()
COST_AGREEMENT = 1e-3
"""Relative: the acceptance of the two solvers against the better of the two."""


def test_there_are_ten_instances_of_three_tools_and_three_fingers() -> None:
    assert len(INSTANCES) >= 10
    for word in ("knife", "screwdriver", "wrench", "index", "thumb", "middle", "x 0.85"):
        assert any(word in name for name in INSTANCES)


@pytest.mark.slow
@pytest.mark.parametrize("problem", INSTANCES.values(), ids=INSTANCES.keys())
def test_nonlinear_program_and_successive_cone_programs_agree(problem: RemovalProblem) -> None:
    nlp, socp = solve_removal(problem), solve_removal_by_socps(problem)
    better = min(nlp.cost, socp.cost)
    assert nlp.cost <= better * (1.0 + COST_AGREEMENT)
    assert socp.cost <= better * (1.0 + COST_AGREEMENT)
    # a residual of 1e-6 in the scaled conditions moves a cost of 1e-3 by less than 1e-3 of it
    assert nlp.kkt_residual <= 1e-6
    turned = np.abs(np.sum(nlp.orientation[-1] * socp.orientation[-1]))
    assert np.degrees(2.0 * np.arccos(min(turned, 1.0))) < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("problem", INSTANCES.values(), ids=INSTANCES.keys())
def test_fatrop_and_ipopt_reach_the_same_cost(problem: RemovalProblem) -> None:
    fatrop, ipopt = solve_removal(problem), solve_removal(problem, solver="ipopt")
    assert fatrop.cost == pytest.approx(ipopt.cost, rel=1e-5)
