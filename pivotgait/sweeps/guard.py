"""A process under guard: the cells that kill it or never end are results like others."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time as clock
import weakref
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from pivotgait.exceptions import InputError
from pivotgait.sweeps.errors import SweepError
from pivotgait.sweeps.outcome import Outcome
from pivotgait.validation.processes import CHILD_ENVIRONMENT

CHILD = (sys.executable, "-m", "pivotgait.sweeps.child")
"""Command of the process that computes."""
START_LIMIT_S = 180.0
"""Importing everything takes long on a busy machine, but not forever."""
_POLL_S = 0.5


@dataclass(frozen=True)
class Timed:
    """An outcome and the time it took [s]."""

    outcome: Outcome
    seconds: float


class _Died(Exception):
    """The process ended, or had to be ended, while it was asked."""

    def __init__(self, outcome: Outcome) -> None:
        self.outcome = outcome


class Guard:
    """Computes cells in a process of its own, which is begun anew whenever it ends.

    Args:
        study: as :meth:`pivotgait.sweeps.study.Study.to_json` tells it.
        limit_s: time a question may take [s].
        command: of the process.
    """

    def __init__(self, study: str, limit_s: float, command: Sequence[str] = CHILD) -> None:
        self._study, self._limit_s, self._command = study, limit_s, tuple(command)
        self._process: subprocess.Popen[bytes] | None = None
        self._finish: Callable[[], object] = lambda: None
        self._buffer = b""

    def outcomes(self, numbers: Sequence[int], *, together: bool = False) -> list[Timed]:
        """Outcomes of cells, in their order.

        Args:
            numbers: of the cells.
            together: ask for all at once, in the time of a single one; where that fails, ask for
                halves, down to the one cell that is to blame.

        Raises:
            SweepError: the process does not even start.
            InputError: it refuses the study.
        """
        if not together:
            return [timed for number in numbers for timed in self._halved([number])]
        return self._halved(numbers)

    def close(self) -> None:
        """End the process."""
        self._finish()
        self._process, self._buffer = None, b""

    def _halved(self, numbers: Sequence[int]) -> list[Timed]:
        start = clock.monotonic()
        try:
            return self._asked(numbers)
        except _Died as death:
            if len(numbers) == 1:
                return [Timed(death.outcome, clock.monotonic() - start)]
        middle = len(numbers) // 2
        return self._halved(numbers[:middle]) + self._halved(numbers[middle:])

    def _asked(self, numbers: Sequence[int]) -> list[Timed]:
        request = json.dumps({"cells": list(numbers), "limit_s": self._limit_s})
        if self._process is not None and self._process.poll() == 0:
            self.close()  # nobody had asked for long
        answer = self._ask(self._process or self._start(), request, self._limit_s)
        share = answer["seconds"] / len(numbers)
        return [Timed(Outcome(*row), share) for row in answer["outcomes"]]

    def _start(self) -> subprocess.Popen[bytes]:
        with tempfile.TemporaryFile() as errors:
            process = subprocess.Popen(
                self._command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                env={**os.environ, **CHILD_ENVIRONMENT},
                start_new_session=True,  # so that Ctrl-C reaches the command, not each of these
            )
            self._process, self._buffer = process, b""
            self._finish = weakref.finalize(self, _end, process)
            try:
                answer = self._ask(process, self._study, START_LIMIT_S)
            except _Died as death:
                errors.seek(0)
                said = errors.read()[-300:].decode(errors="replace").strip()
                what = f"the computing process does not start: {death.outcome.reason} {said}"
                raise SweepError(what, mend="try `pivotgait doctor`") from death
        if "refusal" in answer:
            self.close()
            text, code = answer["refusal"], answer["exit_code"]
            raise InputError(text) if code == InputError.exit_code else SweepError(text)
        return process

    def _ask(self, process: subprocess.Popen[bytes], line: str, limit_s: float) -> dict[str, Any]:
        """Send a line and wait for the answer.

        Raises:
            _Died: with the outcome of the cell, if there was only one.
        """
        requests, answers = process.stdin, process.stdout
        assert requests is not None
        assert answers is not None
        deadline = clock.monotonic() + limit_s
        with suppress(BrokenPipeError):  # its answer, or the lack of one, tells more
            requests.write(line.encode() + b"\n")
            requests.flush()
        while b"\n" not in self._buffer:
            if clock.monotonic() > deadline:
                self.close()
                detail = f"not done after {limit_s:g} s"
                raise _Died(Outcome("timeout", detail))
            if not select.select([answers], [], [], _POLL_S)[0]:
                continue
            piece = os.read(answers.fileno(), 1 << 16)
            if not piece:
                raise self._ended(process)
            self._buffer += piece
        text, self._buffer = self._buffer.split(b"\n", 1)
        answer = json.loads(text)
        assert isinstance(answer, dict)
        return answer

    def _ended(self, process: subprocess.Popen[bytes]) -> _Died:
        process.wait()
        code = process.returncode
        self.close()
        if code == -signal.SIGALRM:
            return _Died(Outcome("timeout", f"not done after {self._limit_s:g} s"))
        if code < 0:
            return _Died(Outcome("crash", f"the process was ended by {signal.Signals(-code).name}"))
        return _Died(Outcome("crash", f"the process ended with code {code}"))


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(BrokenPipeError):
                pipe.close()
