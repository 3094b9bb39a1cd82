"""``validate``: closed-loop trials of a plan in a simulator."""

from __future__ import annotations

from pathlib import Path

from rich.markup import escape

from pivotgait.commands.output import Output, verdict
from pivotgait.commands.planning import writable
from pivotgait.control import RecoveryOptions
from pivotgait.plans import read_plan
from pivotgait.validation import (
    ReplanOptions,
    RunOptions,
    TrialOptions,
    TrialResult,
    TrialSet,
    run_trials,
    write_record,
)

_FEW = 5
"""Up to so many trials each is shown and recorded in detail."""


def run_validate(
    path: Path,
    simulator: str,
    controller: str,
    trials: int,
    seed: int,
    record: Path | None,
    out: Output,
    *,
    perturbed: bool | None = None,
    workers: int | None = None,
    recover: bool = False,
    replan_hold_s: float | None = None,
) -> int:
    """Run the trials of a plan; returns the exit code: 0 where all passed."""
    if record is not None:
        writable(record)
    plan = read_plan(path)
    options = TrialOptions(
        run=RunOptions(
            simulator=simulator,
            controller=controller,
            recovery=RecoveryOptions() if recover else None,
        ),
        perturbed=trials > 1 if perturbed is None else perturbed,
        record_every=5 if trials <= _FEW else 20,
        replanning=None if replan_hold_s is None else ReplanOptions(replan_hold_s),
    )
    with out.progress(f"{controller} control in {simulator}", trials) as bar:

        def tell(_: TrialResult) -> None:
            bar.advance(bar.task_ids[0])

        found = run_trials(
            plan,
            range(seed, seed + trials),
            options,
            folder=path.parent,
            workers=workers,
            progress=tell,
        )
    if record is not None:
        write_record(found, plan, record)
    show_trials(found, out)
    summary = found.as_json()
    out.emit({**summary, "plan": str(path), "record": str(record) if record else None})
    return 0 if found.passed == trials else 1


def show_trials(found: TrialSet, out: Output) -> None:
    """Print the stages, the runs that failed (or all of a few), and the rate."""
    summary = found.as_json()
    kind = "perturbed" if found.options.perturbed else "nominal"
    title = f"{summary['controller']} control in {summary['simulator']}, {kind}"
    columns = [("stage", "left"), ("reached", "right"), ("passed", "right")]
    rows = [(stage.name, str(stage.reached), str(stage.passed)) for stage in found.stages]
    out.table(title, columns, rows)
    many = len(found.results) > _FEW
    shown = [each for each in found.results if not (many and each.verdict.passed)]
    out.table("failed runs" if many else "runs", _RUN_COLUMNS, map(_run_row, shown))
    if found.options.replanning is not None:
        out.say(_replanned(found))
    low, high = summary["wilson_95"]
    count = f"{found.passed} of {summary['trials']}"
    word = verdict(found.passed == summary["trials"], count, count)
    out.say(f"passed: {word} (95 % confidence {100 * low:.0f}-{100 * high:.0f} %)")


def _replanned(found: TrialSet) -> str:
    """How many seams were planned anew, and how long that took beside the hold."""
    seams = [seam for result in found.results for seam in result.seams]
    if not seams:
        return "planned anew: no run came to a seam"
    done = sum(seam.correction is not None for seam in seams)
    times = sorted(seam.plan_time_s for seam in seams)
    held = max(seam.hold_s for seam in seams)
    return (
        f"planned anew: {done} of {len(seams)} seams, median {times[len(times) // 2]:.1f} s, "
        f"at most {times[-1]:.1f} s of planning; the grasp is held for {held:g} s each"
    )


_RUN_COLUMNS = [
    ("seed", "right"),
    ("verdict", "left"),
    ("hold", "right"),
    ("load", "right"),
    ("turn", "right"),
    ("tip", "right"),
    ("finger", "right"),
]


def _run_row(result: TrialResult) -> tuple[str, ...]:
    found, metrics = result.verdict, result.metrics
    said = f"{found.failure}, {found.stage} {found.time_s:.2f} s: {found.detail}"
    word = verdict(found.passed, "passed", escape(said if found.stage else found.detail))
    if metrics is None:
        return (str(result.seed), word, *["-"] * 5)
    return (
        str(result.seed),
        word,
        f"{metrics.holding_force_rms_N:.3f} N",
        f"{metrics.loading_force_rms_N:.3f} N",
        f"{metrics.orientation_deg:.2f} deg",
        f"{metrics.tip_slip_mm:.2f} mm",
        f"{metrics.fingertip_slip_mm:.2f} mm",
    )
