"""A perturbed trial, planned again: the same seed gives the same record in every process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pivotgait.plans import GaitPlan, write_plan

SEED = 5
TRIAL = """
import sys
from pathlib import Path
from pivotgait.plans.hdf5_reader import plan_from_bytes
from pivotgait.validation import TrialOptions, TrialSet, run_trial, write_record
from pivotgait.validation.trials import stages_of

# Blocks of odd sizes move all later ones by multiples of 16 bytes.
held = [bytes(700 + 16 * (k * int(sys.argv[4]) % 97)) for k in range(5000)][::2]
image, options = Path(sys.argv[1]).read_bytes(), TrialOptions()
plan = plan_from_bytes(image, where="plan")
result = run_trial(image, None, int(sys.argv[3]), options)
assert result.series is not None, result.verdict
write_record(TrialSet(options, stages_of(plan, [result]), (result,)), plan, sys.argv[2])
"""


@pytest.mark.slow
def test_the_same_record_in_another_process(plan: GaitPlan, tmp_path: Path) -> None:
    """Other hashes of texts, hence other orders of sets, and another layout of memory."""
    path, records = tmp_path / "plan.h5", [tmp_path / "one.h5", tmp_path / "two.h5"]
    write_plan(plan, path)
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", TRIAL, path, record, str(SEED), str(k)],
            env={**os.environ, "PYTHONHASHSEED": str(100 + k), "OPENBLAS_NUM_THREADS": "1"},
            stdout=subprocess.DEVNULL,
        )
        for k, record in enumerate(records)
    ]
    assert [process.wait() for process in processes] == [0, 0]
    assert records[0].read_bytes() == records[1].read_bytes()
