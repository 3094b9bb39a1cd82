"""A computing process for which cells 3, 5, 7 and 9 are trouble."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Sequence

from pivotgait.sweeps.child import main
from pivotgait.sweeps.evaluator import Evaluator
from pivotgait.sweeps.outcome import Outcome


class Troubled(Evaluator):
    """Dies, hangs, is killed, and prints where it should not."""

    def outcomes(self, numbers: Sequence[int]) -> list[Outcome]:
        if 3 in numbers:
            os._exit(7)
        if 5 in numbers:
            time.sleep(3600)
        if 7 in numbers:
            os.kill(os.getpid(), signal.SIGSEGV)
        if 9 in numbers:
            os.write(1, b"no JSON\n")
            os._exit(0)
        os.write(1, b"printed by a native library\n")
        return super().outcomes(numbers)


if __name__ == "__main__":
    main(Troubled)
