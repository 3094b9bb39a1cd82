"""Jobs that return, refuse, crash and never end."""

from __future__ import annotations

import math
import os
import time

import pytest
from scipy.stats import binomtest

from pivotgait.exceptions import InputError
from pivotgait.models import export_scene
from pivotgait.validation.processes import run_jobs
from pivotgait.validation.wilson import wilson_interval


def test_values_come_back_with_their_places() -> None:
    jobs = [(k, 3) for k in range(2)]
    found = {each.place: each.value for each in run_jobs(divmod, jobs, time_limit_s=60)}
    assert found == {k: divmod(k, 3) for k in range(2)}


def test_a_dead_process_is_one_crash() -> None:
    (outcome,) = run_jobs(os._exit, [(3,)], time_limit_s=60)
    assert (outcome.failure, outcome.value) == ("crash", None)
    assert "code 3" in outcome.detail


def test_a_defect_is_a_crash_that_tells() -> None:
    (outcome,) = run_jobs(math.sqrt, [(-1.0,)], time_limit_s=60)
    assert outcome.failure == "crash"
    assert "math domain error" in outcome.detail


def test_a_job_that_never_ends_is_ended() -> None:
    start = time.monotonic()
    (outcome,) = run_jobs(time.sleep, [(60.0,)], time_limit_s=0.5)
    assert outcome.failure == "timeout"
    assert time.monotonic() - start < 20.0


def test_bad_input_is_no_crash() -> None:
    with pytest.raises(InputError, match="unknown scene 'no such'"):
        list(run_jobs(export_scene, [("no such",)], time_limit_s=60))


@pytest.mark.parametrize(("passed", "trials"), [(0, 5), (8, 10), (10, 10), (98, 100)])
def test_wilson_agrees_with_scipy(passed: int, trials: int) -> None:
    peer = binomtest(passed, trials).proportion_ci(0.95, method="wilson")
    assert wilson_interval(passed, trials) == pytest.approx((peer.low, peer.high), abs=1e-12)


def test_wilson_knows_nothing_without_trials() -> None:
    assert wilson_interval(0, 0) == (0.0, 1.0)
    with pytest.raises(ValueError, match="3 of 2"):
        wilson_interval(3, 2)
