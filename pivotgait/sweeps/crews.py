"""Who computes a sweep's parts: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pivotgait.exceptions import InputError

_ANSWER_S = 10.0
"""A scheduler that does not answer within this, and one without workers, is of no use."""


@contextmanager
def crew(workers: int | None = None, scheduler: str | None = None) -> Iterator[int]:
    """Within it ``joblib.Parallel`` hands work to the crew; gives the number of workers.

    Args:
        workers: processes here; as many as the machine lends us by default.
        scheduler: address of a Dask scheduler instead, such as ``tcp://host:8786``.

    Raises:
        InputError: both are given, Dask is not installed, or no scheduler answers.
    """
    from joblib import parallel_config

    if scheduler is None:
        count = workers or len(os.sched_getaffinity(0))
        # Threads: each only waits for the guarded process that computes for it.
        with parallel_config("threading", n_jobs=count):
            yield count
        return
    if workers is not None:
        mend = "leave out one of --workers and --scheduler"
        raise InputError("a cluster has workers of its own", where="sweep", mend=mend)
    client = _client(scheduler)
    try:
        count = sum(client.nthreads().values())
        with parallel_config("dask", client=client, n_jobs=count):
            yield count
    finally:
        client.close()


def _client(scheduler: str) -> Any:
    try:
        from distributed import Client
    except ImportError as error:
        mend = "pip install 'pivotgait[cluster]'"
        raise InputError("Dask is not installed", where="--scheduler", mend=mend) from error
    try:
        client = Client(scheduler, timeout=_ANSWER_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # a time limit is an OSError
        mend = "start one with `dask scheduler` and give its address, like tcp://host:8786"
        what = f"no scheduler answers at {scheduler}"
        raise InputError(what, where="--scheduler", mend=mend) from error
    try:
        client.wait_for_workers(1, timeout=_ANSWER_S)
    except TimeoutError as error:
        client.close()
        mend = f"start some with `dask worker {scheduler}`"
        raise InputError("the scheduler has no workers", where="--scheduler", mend=mend) from error
    return client
