"""The report as one page that needs nothing else: no network, no script, no second file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pivotgait.atomic import write_atomically
from pivotgait.exceptions import InputError
from pivotgait.plans.plan import GaitPlan
from pivotgait.reporting.comparison import EngineComparison
from pivotgait.reporting.rendering import render
from pivotgait.reporting.report_files import PAGE
from pivotgait.reporting.robot_rows import clearance, robot_headline, robot_rows
from pivotgait.reporting.rows import check_rows, phase_rows, violation_rows
from pivotgait.reporting.run_rows import run_rows
from pivotgait.reporting.summary import Trials
from pivotgait.reporting.verdict import run_sentence, verdict
from pivotgait.validation.record_reading import RecordedRun


@dataclass(frozen=True)
class Picture:
    """A picture of the page.

    Attributes:
        image: bytes of an SVG, a PNG or a WebP.
        alt: what it shows, for those who cannot see it.
        caption: what to see in it.
        phase: name of the phase it belongs to, empty for the whole gait.
        narrow: the same for a phone, if ``image`` would be too small to read there.
        robot: whether it shows the arm-hand over the whole gait.
        run: whether it shows a closed-loop run.
        engines: whether it shows two engines.
    """

    image: bytes
    alt: str
    caption: str
    phase: str = ""
    narrow: bytes = b""
    robot: bool = False
    run: bool = False
    engines: bool = False


def write_report(
    folder: Path,
    plan: GaitPlan,
    certificate: Mapping[str, Any] | None,
    figures: Mapping[str, Picture],
    *,
    plan_times: Mapping[str, float] = MappingProxyType({}),
    notes: Mapping[str, str] = MappingProxyType({}),
    run: RecordedRun | None = None,
    validations: Sequence[Trials] = (),
    engines: EngineComparison | None = None,
    view: str = "",
    run_view: str = "",
) -> Path:
    """Write ``report.html`` into ``folder``, whole or not at all.

    Args:
        folder: made if missing.
        plan: the gait.
        certificate: as ``pivotgait certify --json`` gives it, None if the plan has none.
        figures: by name; ``hero`` opens the page, those of a phase stand with it.
        plan_times: phase's name -> time to plan it [s].
        notes: phase's name -> a sentence about its making.
        run: the plan's nominal closed-loop run, None if there is none.
        validations: closed-loop trials, one entry for each simulator and controller.
        engines: the plan in two engines, None if they were not compared.
        view: name of the animated scene's file in ``folder``, empty if there is none.
        run_view: the same of the run's animation.

    Returns:
        Path of the page.

    Raises:
        InputError: if the folder cannot be written.
    """
    text = render_report(
        plan,
        certificate,
        figures,
        plan_times=plan_times,
        notes=notes,
        run=run,
        validations=validations,
        engines=engines,
        view=view,
        run_view=run_view,
    )
    path = folder / PAGE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(text.encode(), path)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror}", where=str(path), mend="check the folder"
        ) from error
    return path


def render_report(
    plan: GaitPlan,
    certificate: Mapping[str, Any] | None,
    figures: Mapping[str, Picture],
    *,
    plan_times: Mapping[str, float] = MappingProxyType({}),
    notes: Mapping[str, str] = MappingProxyType({}),
    run: RecordedRun | None = None,
    validations: Sequence[Trials] = (),
    engines: EngineComparison | None = None,
    view: str = "",
    run_view: str = "",
) -> str:
    """The page's HTML; arguments as :func:`write_report`."""
    found = certificate or {}
    return render(
        "report.html.j2",
        plan=plan,
        verdict=verdict(certificate, run),
        phases=phase_rows(plan, plan_times),
        checks=check_rows(found),
        violations=violation_rows(found),
        notes=notes,
        run=run,
        validations=validations,
        engines=engines,
        view=view,
        run_view=run_view,
        run_sentence=run_sentence(run) if run else "",
        run_rows=run_rows(run),
        run_figures=[f for f in figures.values() if f.run],
        engine_figures=[f for f in figures.values() if f.engines],
        robot=robot_rows(plan),
        robot_headline=robot_headline(plan, found),
        clearance=clearance(found),
        hero=figures.get("hero"),
        robot_figures=[f for f in figures.values() if f.robot],
        gait_figures=[
            f
            for name, f in figures.items()
            if not (f.phase or f.robot or f.run or f.engines or name == "hero")
        ],
        phase_figures=[
            (phase, pictures)
            for phase in plan.phases
            if (pictures := [f for f in figures.values() if f.phase == phase.name])
        ],
    )
