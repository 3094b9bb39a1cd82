"""Processes that do not outlive the one they work for, however that one ends."""

from __future__ import annotations

import os
import threading
import time

_POLL_S = 0.5


def live_with(parent: int) -> None:
    """End this process soon after its parent has ended.

    Args:
        parent: number of the process that began this one.
    """
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_POLL_S)
    os._exit(1)  # nobody is left to tell anything to
