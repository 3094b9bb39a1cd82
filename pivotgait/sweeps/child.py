"""A process that computes cells as it is told: lines of JSON in, lines of JSON out.

The first line tells the study; each further one asks for cells. It ends when nobody asks any
more, and is ended by the system when a question takes longer than its limit.
"""

from __future__ import annotations

import json
import os
import select
import signal
from collections.abc import Callable
from time import perf_counter
from typing import Any, TextIO

from pivotgait.exceptions import PivotGaitError
from pivotgait.sweeps.company import live_with
from pivotgait.sweeps.evaluator import Evaluator
from pivotgait.sweeps.study import Study

IDLE_S = 60.0
"""After so long without a question the process ends; the next one gets a new process."""
GRACE_S = 5.0
"""The system ends a process this long after its limit, should nobody else be left to do it."""


def serve(
    requests: TextIO, answers: TextIO, evaluator: Callable[[Study], Evaluator] = Evaluator
) -> None:
    """Answer requests until they end.

    Args:
        requests: the study, then ``{"cells": [numbers], "limit_s": seconds}`` each in a line.
        answers: ``{"ready": true}`` or ``{"refusal": text, "exit_code": code}``, then
            ``{"outcomes": [[status, reason, results], ...], "seconds": time}``.
        evaluator: makes what computes the cells.
    """

    def tell(answer: dict[str, Any]) -> None:
        answers.write(json.dumps(answer) + "\n")
        answers.flush()

    try:
        study = Study.from_json(requests.readline())
        study.check_digest()
        work = evaluator(study)
    except PivotGaitError as error:
        tell({"refusal": str(error), "exit_code": error.exit_code})
        return
    tell({"ready": True})
    while select.select([requests], [], [], IDLE_S)[0]:
        line = requests.readline()
        if not line:
            return
        request = json.loads(line)
        # not caught by anyone: it works where native code never comes back, too
        signal.setitimer(signal.ITIMER_REAL, request["limit_s"] + GRACE_S)
        start = perf_counter()
        outcomes = work.outcomes(request["cells"])
        seconds = perf_counter() - start
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        rows = [(each.status, each.reason, dict(each.results)) for each in outcomes]
        tell({"outcomes": rows, "seconds": seconds})


def main(evaluator: Callable[[Study], Evaluator] = Evaluator) -> None:
    """Serve stdin; what native libraries print goes nowhere, but for what hinders the start."""
    live_with(os.getppid())
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)

    def quiet(study: Study) -> Evaluator:
        work = evaluator(study)
        os.dup2(nowhere, 2)
        return work

    serve(os.fdopen(0, encoding="utf-8"), answers, quiet)


if __name__ == "__main__":
    main()
