"""The report as one page that needs nothing else: no network, no script, no second file."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from pivotgait.atomic import write_atomically
from pivotgait.exceptions import InputError
from pivotgait.plans.plan import GaitPlan
from pivotgait.reporting.numbers import number, quantity
from pivotgait.reporting.robot_rows import clearance, robot_headline, robot_rows
from pivotgait.reporting.rows import check_rows, phase_rows, violation_rows
from pivotgait.reporting.run_rows import run_rows
from pivotgait.reporting.summary import Trials
from pivotgait.reporting.verdict import run_sentence, verdict
from pivotgait.validation.record_reading import RecordedRun

_MEDIA = MappingProxyType(
    {b"\x89PNG": "image/png", b"<?xml": "image/svg+xml", b"RIFF": "image/webp"}
)


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
    """

    image: bytes
    alt: str
    caption: str
    phase: str = ""
    narrow: bytes = b""
    robot: bool = False
    run: bool = False


def data_uri(image: bytes) -> str:
    """An SVG, PNG or WebP image as a data URI.

    Raises:
        ValueError: if it is none of them.
    """
    for start, media in _MEDIA.items():
        if image.startswith(start):
            return f"data:{media};base64,{base64.b64encode(image).decode()}"
    raise ValueError(f"an image is neither SVG, PNG nor WebP: it starts with {image[:8]!r}")


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
        view=view,
        run_view=run_view,
    )
    path = folder / "report.html"
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
    view: str = "",
    run_view: str = "",
) -> str:
    """The page's HTML; arguments as :func:`write_report`."""
    environment = Environment(
        loader=PackageLoader("pivotgait.reporting", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": number, "quantity": quantity, "data_uri": data_uri}
    assert environment.loader is not None
    # ours, not a user's: the only text of the page that is not escaped
    style = Markup(environment.loader.get_source(environment, "report.css")[0])
    found = certificate or {}
    return environment.get_template("report.html.j2").render(
        plan=plan,
        style=style,
        verdict=verdict(certificate, run),
        phases=phase_rows(plan, plan_times),
        checks=check_rows(found),
        violations=violation_rows(found),
        notes=notes,
        run=run,
        validations=validations,
        view=view,
        run_view=run_view,
        run_sentence=run_sentence(run) if run else "",
        run_rows=run_rows(run),
        run_figures=[f for f in figures.values() if f.run],
        robot=robot_rows(plan),
        robot_headline=robot_headline(plan, found),
        clearance=clearance(found),
        hero=figures.get("hero"),
        robot_figures=[f for f in figures.values() if f.robot],
        gait_figures=[
            f for name, f in figures.items() if not (f.phase or f.robot or f.run or name == "hero")
        ],
        phase_figures=[
            (phase, pictures)
            for phase in plan.phases
            if (pictures := [f for f in figures.values() if f.phase == phase.name])
        ],
    )
