"""Cells that kill their process, never end, or print: each costs itself alone."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pivotgait.exceptions import InputError
from pivotgait.sweeps import Study, SweepError
from pivotgait.sweeps.evaluator import Evaluator
from pivotgait.sweeps.guard import Guard
from tests.sweeps.cases import TROUBLED


@pytest.fixture
def guard(grid: Study) -> Iterator[Guard]:
    """Over the process that fails on some cells."""
    found = Guard(grid.to_json(), 1.5, TROUBLED)
    yield found
    found.close()


def test_outcomes_come_through_a_process_unchanged(grid: Study, guard: Guard) -> None:
    found = guard.outcomes([10, 11, 12], together=True)
    assert [each.outcome for each in found] == Evaluator(grid).outcomes([10, 11, 12])
    assert all(each.seconds > 0.0 for each in found)


def test_the_cell_to_blame_is_found_in_a_batch(guard: Guard) -> None:
    found = [each.outcome for each in guard.outcomes([6, 7], together=True)]
    assert [each.status for each in found] == ["done", "crash"]
    assert found[1].reason == "the process was ended by SIGSEGV"


def test_cells_are_asked_for_one_by_one_unless_told(guard: Guard) -> None:
    found = [each.outcome.status for each in guard.outcomes([3, 6])]
    assert found == ["crash", "done"]


@pytest.mark.parametrize(("cell", "code"), [(3, 7), (9, 0)])
def test_an_exit_is_a_crash(guard: Guard, cell: int, code: int) -> None:
    (found,) = guard.outcomes([cell])
    assert found.outcome.status == "crash"
    assert found.outcome.reason == f"the process ended with code {code}"


def test_a_hanging_cell_is_given_up_in_time(guard: Guard) -> None:
    guard.outcomes([0])
    start = time.monotonic()
    (found,) = guard.outcomes([5])
    assert (found.outcome.status, found.outcome.reason) == ("timeout", "not done after 1.5 s")
    assert 1.5 <= found.seconds < time.monotonic() - start + 0.1 < 10.0


def test_a_process_that_does_not_start_is_told(grid: Study) -> None:
    broken = Guard(grid.to_json(), 1.0, [sys.executable, "-c", "raise SystemExit('no libfoo')"])
    with pytest.raises(SweepError, match=r"does not start.*code 1.*no libfoo.*pivotgait doctor"):
        broken.outcomes([0])


def test_a_study_that_cannot_be_loaded_is_refused(grid: Study) -> None:
    other = grid.to_json().replace("urdf: chef_knife", "urdf: butter_knife")
    with pytest.raises(InputError, match="butter_knife"):
        Guard(other, 1.0).outcomes([0])


WORKER = """\
import sys
from pivotgait.sweeps.guard import Guard
guard = Guard(sys.stdin.read(), 600.0, sys.argv[1:])
guard.outcomes([0])
print(guard._process.pid, flush=True)
guard.outcomes([5])
"""


def test_a_computing_process_does_not_outlive_its_worker(grid: Study) -> None:
    worker = subprocess.Popen(
        [sys.executable, "-c", WORKER, *TROUBLED],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert worker.stdin is not None
    assert worker.stdout is not None
    worker.stdin.write(grid.to_json().encode())
    worker.stdin.close()
    computing = int(worker.stdout.readline())
    time.sleep(0.5)  # it hangs now
    assert lives(computing)
    worker.kill()
    worker.wait()
    worker.stdout.close()
    deadline = time.monotonic() + 10.0
    while lives(computing) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not lives(computing)


def lives(process: int) -> bool:
    """Whether a process runs; one that has ended and waits to be buried does not."""
    try:
        return "State:\tZ" not in Path(f"/proc/{process}/status").read_text()
    except FileNotFoundError:
        return False
