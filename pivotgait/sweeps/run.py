"""Carry a sweep out: hand out the parts that are missing, keep each as it comes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from pivotgait.sweeps.crews import crew
from pivotgait.sweeps.errors import SweepError
from pivotgait.sweeps.folder import SweepFolder, open_folder
from pivotgait.sweeps.guard import CHILD
from pivotgait.sweeps.part_files import PartImage, PartSummary
from pivotgait.sweeps.parts import PartTask, compute_part
from pivotgait.sweeps.study import Study


@dataclass(frozen=True)
class SweepSummary:
    """What a sweep has done.

    Attributes:
        cells: of the sweep, all done now.
        computed: how many of them by this run.
        counts: number of cells by status (see :data:`pivotgait.sweeps.STATUSES`); ``feasible``
            counts those too.
        seconds: this run took [s].
        workers: parts at a time.
    """

    cells: int
    computed: int
    counts: dict[str, int]
    seconds: float
    workers: int


def run_sweep(
    study: Study,
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    begun: Callable[[SweepFolder], None] | None = None,
    progress: Callable[[PartSummary], None] | None = None,
    command: Sequence[str] = CHILD,
) -> SweepSummary:
    """Compute every cell of a study that the folder does not hold yet.

    It can be killed at any moment and begun again: what the folder then holds in the end is
    the same, byte for byte, as after an unbroken run, but for the timings.

    Args:
        study: what to compute.
        folder: for the results; new, empty, or of this study.
        workers: processes here; as many as the machine lends us by default.
        scheduler: address of a Dask scheduler, in place of processes here.
        begun: called once with the folder, before anything is computed.
        progress: called with each part as it is kept.
        command: of the process that computes cells.

    Raises:
        InputError: the folder is not this study's, the scheduler does not answer, or the
            workers cannot load the study.
        SweepError: workers died, or do not start; what was done is kept.
    """
    start = perf_counter()
    with crew(workers, scheduler) as count, open_folder(folder, study) as kept:
        if begun:
            begun(kept)
        counts, computed = Counter(kept.counts), 0
        for image in _images(study, kept, tuple(command)):
            kept.write(image)
            computed += image.summary.cells
            counts.update(image.summary.counts)
            if progress:
                progress(image.summary)
    seconds = perf_counter() - start
    return SweepSummary(study.cells.count, computed, dict(counts), seconds, count)


def _images(study: Study, kept: SweepFolder, command: tuple[str, ...]) -> Iterator[PartImage]:
    """Parts as they are computed, in any order; only a few are under way at any time."""
    from joblib import Parallel, delayed

    text = study.to_json()
    tasks = (
        delayed(compute_part)(PartTask(text, part, study.config.limit_s, command))
        for part in kept.missing()
    )
    parallel = Parallel(return_as="generator_unordered", pre_dispatch="2*n_jobs", batch_size=1)
    try:
        yield from parallel(tasks)
    except (BrokenExecutor, CancelledError, ConnectionError) as error:
        what = f"a worker died ({type(error).__name__})"
        mend = "give the same command again: it goes on from here"
        raise SweepError(what, where="sweep", mend=mend) from error
