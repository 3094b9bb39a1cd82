"""An infeasible sample is explained, and the mends it names are the smallest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.exceptions import InfeasibleError
from pivotgait.forces import AllocationProblem, LinearRows, allocate, diagnose


def pinch(friction: float = 0.8, normal_max: float = 4.0, normal_min: float = 0.3):
    """Two fingers on either side of a weight of 2 N."""
    return AllocationProblem(
        names=("thumb", "index"),
        lever=np.array([[[0.0, 0.01, 0.0], [0.0, -0.01, 0.0]]]),
        normals=np.array([[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]]),
        friction=np.full(2, friction),
        normal_min=np.full((1, 2), normal_min),
        normal_max=np.full((1, 2), normal_max),
        wrench=np.array([[0.0, 0.0, 2.0, 0.0, 0.0, 0.0]]),
        objective="tangential",
    )


def test_the_pinch_of_known_answers():
    # Each finger carries half the weight, so mu f_n >= 1 N.
    found = diagnose(pinch(friction=0.2), 0)
    assert found.kind in ("friction", "normal_max")
    wanted = {("friction_scale", "fingers"): 1.25, ("normal_max_scale", "fingers"): 1.25}
    named = {(m.change, m.contact): m.to for m in found.mends}
    assert named == pytest.approx(wanted, rel=1e-3)
    assert not diagnose(pinch(), 0).mends
    assert diagnose(pinch(), 0).kind == "none"


def test_a_pinch_too_hard_for_a_weak_finger():
    problem = pinch()
    high = np.array([[0.5, 4.0]])
    low = np.array([[0.3, 2.0]])
    found = diagnose(replace(problem, normal_max=high, normal_min=low), 0)
    assert found.kind in ("normal_max", "normal_min", "friction")
    assert [m.change for m in found.mends][:1] == ["normal_max"]
    assert found.mends[0].contact == "thumb"
    assert found.mends[0].to == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize("contacts", [3, 4])
def test_mends_suffice_and_less_does_not(contacts):
    rng = np.random.default_rng(10 + contacts)
    problem = random_problem(rng, 80, contacts, "tangential", spread=3.0)
    infeasible = np.nonzero(~allocate(problem, "interior_point").feasible)[0][:6]
    seen = set()
    for k in infeasible:
        sample = problem.sample(int(k))
        for mend in diagnose(problem, int(k)).mends:
            seen.add(mend.change)
            assert allocate(mend.applied_to(sample), "clarabel").feasible.all(), mend
            if mend.to == 0.0:
                continue
            less = replace(mend, to=mend.from_ + 0.99 * (mend.to - mend.from_))
            assert not allocate(less.applied_to(sample), "clarabel").feasible.any(), mend
    assert "friction" in seen


def test_rows_that_bind_are_named_by_their_number():
    problem = pinch()
    rows = np.zeros((1, 2, 6))
    rows[0, 0, 0], rows[0, 1, 1] = 1.0, -1.0
    limit = LinearRows(rows, np.full((1, 2), -np.inf), np.array([[9.0, 0.5]]))
    found = diagnose(replace(problem, rows=limit), 0)
    assert found.kind in ("rows", "friction")
    assert found.kind != "rows" or found.contact == "1"


def test_a_wrench_out_of_reach_says_so():
    wrench = np.array([[0.0, 0.0, 2.0, 0.0, 0.3, 0.0]])
    found = diagnose(replace(pinch(), wrench=wrench), 0)
    assert found.kind == "wrench"
    assert found.violation > 0.0


def test_require_tells_what_binds_and_how_to_mend_it():
    with pytest.raises(InfeasibleError, match=r"sample 0.*binds.*from 1 to 1\.25"):
        allocate(pinch(friction=0.2)).require()
    assert allocate(pinch()).require().feasible.all()


def test_ends_too_far_apart_for_the_force_rate_name_the_time_they_need():
    still = pinch()
    many = {
        name: np.repeat(getattr(still, name), 6, axis=0)
        for name in ("lever", "normals", "normal_min", "normal_max", "normal_fixed", "wrench")
    }
    weak = replace(still, normal_max=np.full((1, 2), 1.5))
    # 2.5 N more of squeezing at 10 N/s: the five steps of 0.04 s are 0.05 s short.
    start, end = (allocate(replace(p, objective="alignment")).force[0] for p in (weak, still))
    change = np.linalg.norm(end - start, axis=1).max()
    needed = change / 10.0
    assert needed == pytest.approx(0.25, rel=1e-3)
    slow = replace(still, **many, start=start, end=end, force_rate_max=10.0, step_s=0.04)
    found = diagnose(slow, 2)
    assert found.kind == "coupling"
    assert found.duration == pytest.approx(needed)
    with pytest.raises(InfeasibleError, match=rf"needs at least {needed:.4g} s"):
        allocate(slow).require()
    allocate(replace(slow, step_s=1.001 * needed / 5)).require()
