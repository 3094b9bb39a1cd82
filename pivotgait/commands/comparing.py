"""``compare``: one plan in two simulators, and how far they agree."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rich.markup import escape

from pivotgait.commands.output import Output, verdict
from pivotgait.exceptions import InputError
from pivotgait.plans import GaitPlan, read_plan
from pivotgait.validation import (
    Agreement,
    CompareOptions,
    Comparison,
    compare_engines,
    wilson_interval,
)
from pivotgait.validation.agreement import Gap, PhaseAgreement
from pivotgait.validation.agreement_causes import Causes
from pivotgait.validation.agreement_trials import TrialAgreement
from pivotgait.validation.comparison_files import read_comparison, write_comparison
from pivotgait.validation.controllers import check_controller
from pivotgait.validation.simulator import check_simulator

_UNITS = {
    "normal_force_N": ("normal force, RMS", "N"),
    "position_mm": ("position", "mm"),
    "orientation_deg": ("orientation", "deg"),
    "tip_slip_mm": ("slip of the tip", "mm"),
    "fingertip_slip_mm": ("slip of a fingertip", "mm"),
    "timing_ms": ("time of contact", "ms"),
}
_COLUMNS = [
    ("phase", "left"),
    ("verdicts", "left"),
    ("force N", "right"),
    ("mm", "right"),
    ("deg", "right"),
    ("tip mm", "right"),
    ("finger mm", "right"),
    ("contact ms", "right"),
    ("within", "right"),
]


def run_compare(path: Path, options: CompareOptions, folder: Path | None, out: Output) -> int:
    """Compare two engines on a plan; returns the exit code: 0 where the verdicts agree."""
    plan = read_plan(path)
    one, two = options.simulators
    for name in options.simulators:
        check_simulator(name)
    check_controller(options.run.controller)
    if folder is not None:
        _make(folder)
    with out.progress(f"{one} and {two}", options.most_runs) as bar:

        def tell() -> None:
            bar.advance(bar.task_ids[0])

        found = compare_engines(plan, options, folder=path.parent, progress=tell)
    if folder is not None:
        _write(found, plan, options, folder)
    _show(found, out)
    out.emit({**found.as_json(), "out": str(folder) if folder else None})
    return 0 if found.agreement.same_verdict else 1


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        mend = "give another --output"
        raise InputError(f"cannot be made: {error}", where=str(folder)[:80], mend=mend) from error


def _write(found: Comparison, plan: GaitPlan, options: CompareOptions, folder: Path) -> None:
    from pivotgait.plotting import comparison, save_figure

    write_comparison(found, plan, options, folder)
    runs = read_comparison(folder, plan).runs
    motions = {run.simulator: run.motion for run in runs if run.motion is not None}
    if not motions:  # both ended at once
        return
    try:
        save_figure(comparison(plan, motions), folder / "figures", "comparison")
    except OSError as error:
        what = f"cannot be written: {error.strerror}"
        raise InputError(what, where=str(folder), mend="check the folder") from error


def _show(found: Comparison, out: Output) -> None:
    agreement = found.agreement
    _show_nominal(agreement, out)
    if found.causes is not None:
        _show_causes(found.causes, out)
    if found.trials is not None:
        _show_trials(found.trials, out)


def _show_nominal(found: Agreement, out: Output) -> None:
    one, two = found.simulators
    title = f"{one} against {two}, {found.controller} control, nominal: differences by phase"
    out.table(title, _COLUMNS, [_phase_row(phase, found) for phase in found.phases])
    words = [
        f"{name} {verdict(each.passed, 'passed', escape(f'{each.failure}, {each.stage}'))}"
        for name, each in zip(found.simulators, found.verdicts, strict=True)
    ]
    out.say(f"verdicts: {', '.join(words)}")
    out.say(f"within all tolerances at once: {100 * found.share_within:.2f} % of the time")
    word = verdict(found.agrees, "the engines agree", "the engines do not agree")
    out.say(f"largest difference: {_said(found.gap)}: {word}")
    if found.gap.quantity == "timing_ms":
        _explain_timing(found, out)


def _explain_timing(found: Agreement, out: Output) -> None:
    """What a difference in time is as one in force, since the force passes 0.1 N at a slope."""
    phase = next(each for each in found.phases if each.name == found.gap.phase)
    if phase.contact is not None and phase.timing_ms is not None:
        rate = phase.contact[0].planned_rate_N_s
        force = 1e-3 * phase.timing_ms * rate
        out.say(f"the planned force changes by {rate:.1f} N/s there: this is {force:.2f} N")


def _phase_row(phase: PhaseAgreement, found: Agreement) -> tuple[str, ...]:
    largest: dict[str, Gap] = {}
    for gap in phase.gaps(found.tolerances):
        known = largest.get(gap.quantity)
        if known is None or gap.ratio > known.ratio:
            largest[gap.quantity] = gap
    one, two = phase.verdicts
    same = verdict(one == two, escape(one), escape(f"{one} / {two}"))
    cells = [_cell(largest, name, digits) for name, digits in _DIGITS.items()]
    return (phase.name, same, *cells, f"{100 * phase.share_within:.1f} %")


_DIGITS = {
    "normal_force_N": 3,
    "position_mm": 2,
    "orientation_deg": 2,
    "tip_slip_mm": 2,
    "fingertip_slip_mm": 2,
    "timing_ms": 0,
}


def _cell(largest: Mapping[str, Gap], name: str, digits: int) -> str:
    gap = largest.get(name)
    if gap is None:
        return "-"
    text = f"{gap.value:.{digits}f}"
    return text if gap.ratio <= 1.0 else f"[bold red]{text}[/]"


def _said(gap: Gap) -> str:
    what, unit = _UNITS[gap.quantity]
    where = ", ".join(each for each in (gap.part, gap.phase) if each)
    return f"{what} ({escape(where)}) {gap.value:.3g} {unit}, {gap.ratio:.2f} of its tolerance"


def _show_causes(causes: Causes, out: Output) -> None:
    columns = [
        ("both engines again with", "left"),
        ("this gap", "right"),
        ("largest gap", "right"),
        ("within", "right"),
        ("same verdict", "left"),
    ]
    rows = [
        (
            each.change,
            f"{each.gap.ratio:.2f}" if each.gap else "-",
            f"{each.largest.ratio:.2f}",
            f"{100 * each.share_within:.1f} %",
            verdict(each.same_verdict, "yes", "no"),
        )
        for each in causes.attempts
    ]
    out.table(f"what closes the gap of {causes.gap.ratio:.2f} tolerances", columns, rows)
    likely = causes.likely
    out.say(
        f"likely cause: {likely.change} closes it to {likely.gap.ratio:.2f}"
        if likely and likely.gap
        else "likely cause: none of these halves the gap"
    )


def _show_trials(found: TrialAgreement, out: Output) -> None:
    rows = [
        (name, f"{trials.passed} of {found.trials}", _interval(trials.passed, found.trials))
        for name, trials in zip(found.simulators, found.sets, strict=True)
    ]
    rows.append(
        (
            "same verdict",
            f"{found.same_verdict} of {found.trials}",
            _interval(found.same_verdict, found.trials),
        )
    )
    columns = [("perturbed trials", "left"), ("passed", "right"), ("95 % confidence", "right")]
    out.table("the same seeds in both engines", columns, rows)
    kappa = "not defined, all alike" if found.kappa is None else f"{found.kappa:.2f}"
    out.say(f"Cohen's kappa: {kappa}")
    if found.unlike_plans:
        seeds = ", ".join(map(str, found.unlike_plans))
        out.say(f"[bold red]planned otherwise in the two engines: seeds {seeds}[/]")
    _show_crossed(found, out)


def _show_crossed(found: TrialAgreement, out: Output) -> None:
    crossed, (one, two) = found.crossed, found.simulators
    across = sorted({pair[1] for pair in crossed})
    columns = [(f"{one} / {two}", "left"), *((escape(each), "right") for each in across)]
    down = sorted({pair[0] for pair in crossed})
    rows = [(each, *(str(crossed.get((each, other), 0)) for other in across)) for each in down]
    out.table("outcomes crossed, number of seeds", columns, rows)


def _interval(passed: int, trials: int) -> str:
    low, high = wilson_interval(passed, trials)
    return f"{100 * low:.1f}-{100 * high:.1f} %"
