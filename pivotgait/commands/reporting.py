"""``run`` and ``report``: from a scene to a certified plan, its closed-loop run and its page."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich.markup import escape

from pivotgait.commands.output import Output
from pivotgait.commands.planning import Planned, make_plan, show_phases, write_json
from pivotgait.commands.validation import show_trials
from pivotgait.exceptions import InputError
from pivotgait.models import scene_folder
from pivotgait.plans import GaitPlan
from pivotgait.sweeps.folder import MANIFEST
from pivotgait.validation import TrialOptions, TrialResult, TrialSet, run_trials, write_record

if TYPE_CHECKING:
    from pivotgait.reporting import Report

_FILES = (
    "report.html",
    "report.pdf",
    "summary.json",
    "view.html",
    "run_view.html",
    "record.h5",
    "trials.h5",
    "comparison.json",
    "comparison_pybullet.h5",
    "comparison_mujoco.h5",
)
"""What a run and a comparison leave beside ``plan.h5``, the page first."""


@dataclass(frozen=True)
class ClosedLoop:
    """What ``run`` does with a plan in the simulator.

    Attributes:
        validate: whether the plan is carried out; None for yes if it has a robot.
        trials: number of perturbed trials after the nominal run.
    """

    validate: bool | None = None
    trials: int = 0


def run_all(
    scene: str,
    folder: Path,
    seed: int,
    gait: str | None,
    out: Output,
    *,
    hand: bool = True,
    view: bool = True,
    closed_loop: ClosedLoop | None = None,
) -> int:
    """Plan, certify, carry out, record the views (if told) and report into a folder.

    Returns:
        The exit code: 0 for a valid plan whose nominal run, if there is one, passed. Perturbed
        trials are counted, not judged.
    """
    from pivotgait.reporting import report_from_folder

    wanted = closed_loop or ClosedLoop()
    _check(wanted, hand)
    made = _make_folder(folder)
    try:
        planned = make_plan(scene, folder / "plan.h5", seed, gait, out, hand=hand)
    except BaseException:
        for each in made:  # only folders of our own, and only empty ones
            with suppress(OSError):
                each.rmdir()
        raise
    _remove_old(folder)
    show_phases(planned, out)
    found = _carry_out(planned, scene, folder, seed, wanted, out)
    summary = planned.summary | {name: trials.as_json() for name, trials in found.items()}
    write_json(folder / "summary.json", summary)
    if view:
        _write_views(planned.plan, folder, out)
    with out.progress("drawing the report", 1) as bar:
        report = report_from_folder(folder)
        bar.advance(bar.task_ids[0])
    _show(report, out)
    out.emit({**summary, **_paths(report)})
    nominal = found.get("validation")
    failed = nominal is not None and nominal.passed < len(nominal.results)
    return 0 if planned.certificate.valid and not failed else 1


def _check(wanted: ClosedLoop, hand: bool) -> None:
    """Refuse what contradicts itself before work is spent on it.

    Raises:
        InputError: a closed loop without the arm-hand, or trials without validation.
    """
    if not hand and (wanted.validate or wanted.trials):
        mend = "leave out --no-hand, or --validate and --trials"
        raise InputError("nothing can be carried out without the arm-hand", where="run", mend=mend)
    if wanted.trials and wanted.validate is False:
        mend = "leave out one of --trials and --no-validate"
        raise InputError("trials are wanted and not wanted", where="run", mend=mend)


def run_report(folder: Path, out: Output) -> int:
    """Write the report of a folder that holds a plan or a sweep."""
    from pivotgait.reporting import report_from_folder, report_from_sweep

    try:
        there = folder.is_dir()
    except OSError:  # a name too long for the file system
        there = False
    if not there:
        raise InputError("is not a folder", where=str(folder)[:80], mend="give the --out of a run")
    write = report_from_sweep if (folder / MANIFEST).exists() else report_from_folder
    with out.progress("drawing the report", 1) as bar:
        report = write(folder)
        bar.advance(bar.task_ids[0])
    _show(report, out)
    out.emit(_paths(report))
    return 0


def _show(report: Report, out: Output) -> None:
    out.say(f"report: {escape(str(report.page))}")
    out.say(f"as PDF: {escape(str(report.pdf))}")


def _paths(report: Report) -> dict[str, str]:
    return {"report": str(report.page), "pdf": str(report.pdf)}


def _carry_out(
    planned: Planned, scene: str, folder: Path, seed: int, wanted: ClosedLoop, out: Output
) -> dict[str, TrialSet]:
    """The nominal run and the perturbed trials that are wanted, recorded and shown.

    Returns:
        Sets by their name in ``summary.json``.
    """
    plan = planned.plan
    by_default = plan.robot is not None or wanted.trials > 0
    if not (by_default if wanted.validate is None else wanted.validate):
        return {}
    # where the scene's own paths start, not the folder of the plan
    home = scene_folder(scene)
    found = {"validation": _try(plan, range(seed, seed + 1), False, home, out)}
    write_record(found["validation"], plan, folder / "record.h5")
    if wanted.trials:
        seeds = range(seed, seed + wanted.trials)
        found["trials"] = _try(plan, seeds, True, home, out)
        write_record(found["trials"], plan, folder / "trials.h5")
    for trials in found.values():
        show_trials(trials, out)
    return found


def _try(
    plan: GaitPlan, seeds: range, perturbed: bool, folder: Path | None, out: Output
) -> TrialSet:
    options = TrialOptions(perturbed=perturbed, record_every=20 if perturbed else 5)
    said = "perturbed trials" if perturbed else "nominal run"
    with out.progress(f"{said} in {options.run.simulator}", len(seeds)) as bar:

        def tell(_: TrialResult) -> None:
            bar.advance(bar.task_ids[0])

        return run_trials(plan, seeds, options, folder=folder, progress=tell)


def _write_views(plan: GaitPlan, folder: Path, out: Output) -> None:
    """Animate the plan and, if there is a record of one, its run."""
    from pivotgait.plotting import replay
    from pivotgait.validation.record_reading import read_run
    from pivotgait.viewing import write_view

    scenes = {"view.html": plan}
    record = folder / "record.h5"
    motion = read_run(record, plan).motion if record.is_file() else None
    if motion is not None:
        scenes["run_view.html"] = replay(plan, motion)
    with out.progress("recording the scene", len(scenes)) as bar:
        for name, shown in scenes.items():
            write_view(shown, folder / name)
            bar.advance(bar.task_ids[0])


def _remove_old(folder: Path) -> None:
    """Remove what an earlier run left: it would show another plan.

    Raises:
        InputError: something cannot be removed.
    """
    try:
        for name in _FILES:
            (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot be removed: {error.strerror}", where=name, mend="remove it"
        ) from error


def _make_folder(folder: Path) -> list[Path]:
    """Make a folder with those above it; returns the new ones, the deepest first.

    Raises:
        InputError: it cannot be made.
    """
    try:
        missing = [each for each in (folder, *folder.parents) if not each.exists()]
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(
            f"cannot be made: {error}", where=str(folder), mend="give another --out"
        ) from error
    return missing
