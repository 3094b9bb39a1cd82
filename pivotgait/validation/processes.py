"""Jobs in processes of their own, each with a time limit: a crash costs one job."""

from __future__ import annotations

import os
import time as clock
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from pivotgait.exceptions import InputError, PivotGaitError

_POLL_S = 0.2
CHILD_ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "PYTHONHASHSEED": "0",
}
"""One thread each, since there is a process on every core and threads add up in any order."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """How a job ended.

    Attributes:
        place: of its arguments in the sequence.
        value: what it returned, None if it did not.
        failure: ``timeout``, ``crash`` or empty.
        detail: of the failure.
    """

    place: int
    value: Any = None
    failure: str = ""
    detail: str = ""


@dataclass(eq=False)
class _Running:
    place: int
    process: SpawnProcess
    pipe: Connection
    deadline: float


def run_jobs(
    work: Callable[..., Any],
    arguments: Sequence[tuple[Any, ...]],
    *,
    workers: int | None = None,
    time_limit_s: float,
) -> Iterator[Outcome]:
    """Call ``work`` with each arguments in a fresh process; outcomes come as they end.

    Fresh processes inherit nothing, so that a job's result does not depend on those before it.
    What they print, native libraries included, is dropped.

    Args:
        work: a function of a module, importable by its name.
        arguments: of each call; they and the results must be picklable.
        workers: processes at a time; as many as the machine lends us by default.
        time_limit_s: of each job [s].

    Raises:
        PivotGaitError: the first that a job raises; the others are ended.
    """
    count = workers or len(os.sched_getaffinity(0))
    queue = deque(enumerate(arguments))
    running: list[_Running] = []
    try:
        while queue or running:
            while queue and len(running) < count:
                running.append(_start(work, *queue.popleft(), time_limit_s))
            wait([each.pipe for each in running], timeout=_POLL_S)
            for each in list(running):
                outcome = _poll(each)
                if outcome is not None:
                    running.remove(each)
                    yield outcome
    finally:
        for each in running:
            each.process.kill()
            _end(each)


def _start(
    work: Callable[..., Any], place: int, arguments: tuple[Any, ...], time_limit_s: float
) -> _Running:
    context = get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_job, args=(theirs, work, arguments), daemon=True)
    with _inherited(CHILD_ENVIRONMENT):
        process.start()
    theirs.close()  # so that reading ends where the process does
    return _Running(place, process, ours, clock.monotonic() + time_limit_s)


@contextmanager
def _inherited(values: Mapping[str, str]) -> Iterator[None]:
    """Environment variables for the processes started meanwhile."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _job(pipe: Connection, work: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    answer: tuple[str, Any]
    try:
        answer = ("value", work(*arguments))
    except PivotGaitError as error:
        answer = ("refusal", (str(error), error.exit_code))
    except Exception as error:  # a defect in one trial is told, not hidden
        answer = ("crash", f"{type(error).__name__}: {error}")
    pipe.send(answer)
    pipe.close()


def _poll(running: _Running) -> Outcome | None:
    """The outcome of a job that has ended or must end, else None."""
    place = running.place
    if running.pipe.poll():
        try:
            kind, value = running.pipe.recv()
        except EOFError:
            _end(running)
            code = running.process.exitcode
            return Outcome(place, failure="crash", detail=f"the process ended with code {code}")
        _end(running)
        if kind == "refusal":
            text, code = value
            raise InputError(text) if code == InputError.exit_code else PivotGaitError(text)
        if kind == "crash":
            return Outcome(place, failure="crash", detail=value)
        return Outcome(place, value)
    if clock.monotonic() > running.deadline:
        running.process.kill()
        _end(running)
        return Outcome(place, failure="timeout", detail="the time limit was reached")
    return None


def _end(running: _Running) -> None:
    running.process.join(timeout=1.0)
    if running.process.is_alive():
        running.process.kill()
        running.process.join()
    running.pipe.close()
