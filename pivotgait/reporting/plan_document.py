"""The report of a plan as a PDF: the page's headlines, tables and figures, to print or send."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.document import (
    Block,
    Heading,
    Paragraph,
    PictureBlock,
    TableBlock,
    document_pdf,
)
from pivotgait.plotting.save import PRINT_DPI
from pivotgait.reporting.comparison import EngineComparison
from pivotgait.reporting.numbers import number, quantity
from pivotgait.reporting.page import Picture
from pivotgait.reporting.robot_rows import clearance, robot_headline, robot_rows
from pivotgait.reporting.rows import check_rows, phase_rows, violation_rows
from pivotgait.reporting.run_rows import run_rows
from pivotgait.reporting.summary import Trials
from pivotgait.reporting.verdict import run_sentence, verdict
from pivotgait.validation.record_reading import RecordedRun

Pictures = Mapping[str, Picture]


def plan_pdf(
    plan: GaitPlan,
    certificate: Mapping[str, Any] | None,
    pictures: Pictures,
    figures: Path,
    *,
    plan_times: Mapping[str, float] = MappingProxyType({}),
    notes: Mapping[str, str] = MappingProxyType({}),
    run: RecordedRun | None = None,
    validations: Sequence[Trials] = (),
    engines: EngineComparison | None = None,
) -> bytes:
    """The bytes of a PDF file without time stamp.

    Args:
        plan: the gait.
        certificate: see :func:`pivotgait.reporting.write_report`, as the further arguments.
        pictures: by name.
        figures: folder with the PNG of each picture, in print quality.

    Raises:
        OSError: a figure cannot be read.
    """
    opening = verdict(certificate, run)
    title = f"{plan.tool.name}: {opening.headline}"
    found = certificate or {}
    drawn = _Drawn(pictures, figures)
    blocks: list[Block] = [
        Heading(title, 1),
        Paragraph(f"Finger gait of the {plan.tool.name}, seed {plan.seed}. {opening.sentence}"),
        *drawn.blocks(name for name in pictures if name == "hero"),
        *_closed_loop(run, validations, engines, drawn),
        *_phases(plan, plan_times),
        *_violations(found),
        *_hand(plan, found),
        *_details(plan, drawn, notes),
        *_certificate(found),
        *_data(plan),
    ]
    return document_pdf(blocks, title=title)


class _Drawn:
    """Pictures by name, each with its PNG in one folder."""

    def __init__(self, pictures: Pictures, folder: Path) -> None:
        self.pictures, self._folder = pictures, folder

    def blocks(self, names: Iterable[str]) -> Iterator[PictureBlock]:
        for name in names:
            png = (self._folder / f"{name}.png").read_bytes()
            yield PictureBlock(png, self.pictures[name].caption, dpi=PRINT_DPI)


def _closed_loop(
    run: RecordedRun | None,
    validations: Sequence[Trials],
    engines: EngineComparison | None,
    drawn: _Drawn,
) -> Iterator[Block]:
    if run or validations or engines:
        yield Heading("Closed loop")
    if run:
        yield Paragraph(run_sentence(run))
        rows = tuple((row.meaning, row.value, row.aim, row.limit) for row in run_rows(run))
        if rows:
            yield TableBlock(("Figure of the run", "Measured", "Aim", "Limit"), rows)
            yield Paragraph(
                "The aim is how closely a nominal run is meant to follow; beyond the limit a run "
                "has failed."
            )
        yield from drawn.blocks(name for name, each in drawn.pictures.items() if each.run)
    if engines:
        yield from _engines(engines)
        yield from drawn.blocks(name for name, each in drawn.pictures.items() if each.engines)
    for trials in validations:
        yield from _trials(trials)


def _engines(found: EngineComparison) -> Iterator[Block]:
    yield Heading(" and ".join(found.engines))
    yield Paragraph(found.sentence)
    heads = tuple(f"{meaning}, ≤ {tolerance}" for meaning, tolerance in found.heads)
    # a quantity in each line: six of them side by side are too wide for paper
    rows = tuple(
        (head, row.name, cell.text)
        for row in found.rows
        for head, cell in zip(heads, row.cells, strict=True)
    )
    yield TableBlock(("Largest difference", "Phase", "Value"), rows)
    if found.cause:
        yield Paragraph(found.cause)
        head = ("Both engines again with", "Difference over tolerance", "Within all")
        yield TableBlock(head, tuple(found.attempts))
    if found.trials:
        yield Paragraph(found.trials)
        crossed = tuple((one, other, str(count)) for one, other, count in found.crossed)
        yield TableBlock((*found.engines, "Seeds"), crossed)


def _trials(trials: Trials) -> Iterator[Block]:
    how = "" if trials.pivoting else " without pivoting"
    passed = f"{trials.passed} of {trials.trials} passed"
    yield Heading(f"Trials in {trials.simulator}, {trials.controller} control{how}: {passed}")
    if trials.wilson_95:
        low, high = map(number, trials.wilson_95)
        rate = number(trials.rate)
        yield Paragraph(f"Rate {rate}, 95 % interval {low} to {high} (Wilson).")
    rows = tuple((each.name, str(each.reached), str(each.passed)) for each in trials.stages)
    yield TableBlock(("Stage", "Reached", "Passed"), rows)
    if trials.failures:
        counted = ", ".join(f"{name} {count}" for name, count in trials.failures.items())
        yield Paragraph(f"Failures: {counted}.")


def _phases(plan: GaitPlan, plan_times: Mapping[str, float]) -> Iterator[Block]:
    yield Heading("Phases")
    head = ("Phase", "Finger", "Duration", "Planned in", "Friction margin", "Turned")
    rows = tuple(
        (row.name, row.finger, row.duration, row.plan_time, row.margin, row.reorientation)
        for row in phase_rows(plan, plan_times)
    )
    yield TableBlock(head, rows)
    yield Paragraph(
        "The friction margin is 1 − |f_t| / (μ f_n), the smallest of the phase: 1 along the "
        "normal, limit 0, where the contact slips."
    )


def _violations(certificate: Mapping[str, Any]) -> Iterator[Block]:
    found = violation_rows(certificate)
    if found:
        yield Heading(f"Violations ({len(found)})")
        rows = tuple((row.meaning, row.value, row.limit, row.where) for row in found)
        yield TableBlock(("Check", "Value", "Limit", "Where"), rows)


def _hand(plan: GaitPlan, certificate: Mapping[str, Any]) -> Iterator[Block]:
    found = robot_rows(plan)
    if not found:
        return
    yield Heading(f"Arm and hand: {robot_headline(plan, certificate)}")
    head = ("Phase", "Largest torque", "Largest speed", "Nearest to an end", "Path of the finger")
    rows = tuple(
        (
            row.name,
            f"{row.torque} {row.torque_joint}",
            f"{row.speed} {row.speed_joint}",
            f"{row.range} {row.range_joint}",
            row.path,
        )
        for row in found
    )
    yield TableBlock(head, rows)
    least = clearance(certificate)
    more = f" ({least.limit})" if least.limit else ""
    yield Paragraph(
        f"Smallest clearance {least.value}{more}. Torque and speed in percent of the joint's "
        "limit; of its range, 0 % is the middle and 100 % an end."
    )


def _details(plan: GaitPlan, drawn: _Drawn, notes: Mapping[str, str]) -> Iterator[Block]:
    """Figures of the gait, of the arm and hand, and of each phase."""
    pictures = drawn.pictures
    gait = [
        name
        for name, each in pictures.items()
        if not (each.phase or each.robot or each.run or each.engines or name == "hero")
    ]
    groups = {
        "Forces, margins and motion over time": gait,
        "Joints over time, and the whole arm": [n for n, each in pictures.items() if each.robot],
    }
    for title, names in groups.items():
        if names:
            yield Heading(title)
            yield from drawn.blocks(names)
    for phase in plan.phases:
        names = [name for name, each in pictures.items() if each.phase == phase.name]
        if names:
            yield Heading(f"{phase.name}, {phase.finger}" if phase.finger else phase.name)
            if phase.name in notes:
                yield Paragraph(notes[phase.name])
            yield from drawn.blocks(names)


def _certificate(certificate: Mapping[str, Any]) -> Iterator[Block]:
    found = check_rows(certificate)
    if found:
        yield Heading(f"Certificate: {len(found)} checks, each beside its limit")
        rows = tuple(
            (row.meaning, row.value, row.limit, row.where, "yes" if row.holds else "no")
            for row in found
        )
        yield TableBlock(("Check", "Worst value", "Limit", "Where", "Holds"), rows)


def _data(plan: GaitPlan) -> Iterator[Block]:
    tool = plan.tool
    inertia = [quantity(float(each), "kg m²") for each in tool.inertia.diagonal()]
    pivot = ", ".join(number(1e3 * each) for each in tool.pivot_in_tool.tolist())
    gravity = ", ".join(number(each) for each in plan.gravity.tolist())
    yield Heading("Tool and table")
    rows = [("Mass", quantity(tool.mass, "kg"))]
    rows += [
        (f"Inertia about {axis} at the mass centre", each)
        for axis, each in zip("xyz", inertia, strict=True)
    ]
    rows += [
        ("Pivot in the tool frame", f"({pivot}) mm"),
        ("Height of the table", quantity(1e3 * plan.table_height, "mm")),
        ("Gravity", f"({gravity}) m/s²"),
    ]
    yield TableBlock((tool.name, ""), tuple(rows))
    versions = ", ".join(f"{name} {each}" for name, each in sorted(plan.versions.items()))
    yield Heading("Versions")
    yield Paragraph(f"{versions}; seed {plan.seed}")
    yield Heading("Scene")
    yield Paragraph(plan.scene, fixed=True)
