"""Alignment (eq. 4) against CasADi and IPOPT, and feasibility against CVXPY: all independent."""

from __future__ import annotations

from dataclasses import replace

import cvxpy as cp
import numpy as np
import pytest

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.contacts import grasp_map
from pivotgait.forces import allocate
from tests.forces.ipopt_peer import IpoptAlignment

STARTS = 10


@pytest.mark.slow
@pytest.mark.parametrize(("contacts", "count"), [(2, 12), (3, 12), (4, 13), (5, 13)])
def test_alignment_is_the_best_minimum_ipopt_finds(contacts, count):
    rng = np.random.default_rng(50 + contacts)
    problem = random_problem(rng, 3 * count, contacts, "alignment")
    ours = allocate(problem, "interior_point")
    chosen = np.nonzero(ours.feasible)[0][:count]
    assert len(chosen) == count
    peer = IpoptAlignment(contacts)
    matched = 0
    for k in chosen:
        values = []
        for _ in range(STARTS):
            push = rng.uniform(0.3, 4.0, contacts)[:, None] * problem.normals[k]
            _, value, success = peer.solve(problem, int(k), push + rng.normal(0, 0.3, push.shape))
            values += [value] if success else []
        assert ours.objective[k] <= min(values) * (1 + 1e-6)
        matched += ours.objective[k] >= min(values) * (1 - 1e-6)
    # Where IPOPT finds no such minimum from any start, ours still holds by its own checks.
    assert matched >= 0.8 * count
    assert max(part[chosen].max() for part in ours.wrench_residual()) <= 1e-9
    assert ours.cone_margin()[chosen].min() >= -1e-9
    assert ours.bound_violation()[chosen].max() <= 1e-9


def needed_relaxation(problem, k: int) -> float:
    """The smallest common shift of all limits, by CVXPY on the world forces."""
    m = problem.contacts
    f, shift = cp.Variable((m, 3)), cp.Variable()
    rows = [grasp_map(problem.lever[k]) @ cp.vec(f, order="C") == problem.wrench[k], shift >= -1]
    for i in range(m):
        n = problem.normals[k, i]
        normal = n @ f[i]
        rows += [cp.norm(f[i] - normal * n) <= problem.friction[i] * normal + shift]
        rows += [normal + shift >= problem.normal_min[k, i]]
        rows += [normal - shift <= problem.normal_max[k, i]]
    program = cp.Problem(cp.Minimize(shift), rows)
    program.solve(solver=cp.CLARABEL, tol_feas=1e-9, tol_gap_abs=1e-9, tol_gap_rel=1e-9)
    return float(shift.value)


@pytest.mark.slow
def test_feasibility_agrees_with_cvxpy():
    verdicts = []
    for contacts in (3, 4, 5):
        rng = np.random.default_rng(70 + contacts)
        problem = random_problem(rng, 17, contacts, "tangential", spread=2.5)
        weak = replace(problem, friction=problem.friction * 0.7)
        feasible = allocate(weak, "interior_point").feasible
        relaxation = np.array([needed_relaxation(weak, k) for k in range(17)])
        clear = np.abs(relaxation) > 1e-7
        assert clear.sum() >= 16
        assert np.array_equal(feasible[clear], relaxation[clear] < 0.0)
        verdicts += list(feasible)
    assert len(verdicts) == 51
    assert 10 < sum(verdicts) < 41
