"""``plan`` and ``certify``: from a scene to a certified plan."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.markup import escape

from pivotgait.atomic import write_atomically
from pivotgait.certification import Certificate, certify
from pivotgait.commands.output import Output, verdict
from pivotgait.exceptions import InputError
from pivotgait.gaits import PhaseDone, PosturesFound, plan_gait
from pivotgait.margins import SHARE_KINDS, largest_share, phase_margins, smallest_of_phase
from pivotgait.models import load_scene
from pivotgait.plans import GaitPlan, read_plan, write_plan


@dataclass(frozen=True, eq=False)
class Planned:
    """A plan on disk, its certificate, and what ``plan --json`` prints of them."""

    plan: GaitPlan
    certificate: Certificate
    summary: dict[str, Any]


def run_plan(
    scene: str, path: Path, seed: int, gait: str | None, out: Output, *, hand: bool = True
) -> int:
    """Plan, certify and write; returns the exit code."""
    planned = make_plan(scene, path, seed, gait, out, hand=hand)
    show_phases(planned, out)
    out.emit(planned.summary)
    return 0 if planned.certificate.valid else 1


def make_plan(
    scene_name: str, path: Path, seed: int, gait: str | None, out: Output, *, hand: bool = True
) -> Planned:
    """Plan a scene's gait, certify it and write the plan file.

    A plan that misses a tolerance is written too, with a certificate that says so. With ``hand``
    the plan holds the motion of the scene's robot, if there is one, else the tool's alone.

    Raises:
        PivotGaitError: bad input, an infeasible phase, a failed solver.
    """
    writable(path)
    scene = load_scene(scene_name)
    phases: list[dict[str, Any]] = []
    found: list[PosturesFound] = []
    count = len(scene.gaits.get(gait, ()) if gait else next(iter(scene.gaits.values())))
    with out.progress(f"planning {scene.name}", count) as bar:

        def tell(news: PhaseDone | PosturesFound) -> None:
            if isinstance(news, PosturesFound):
                found.append(news)
                return
            phases.append(phase_summary(news))
            bar.update(bar.task_ids[0], completed=news.place + 1, total=news.count)

        plan = plan_gait(scene, gait=gait, seed=seed, hand=hand, progress=tell)
    certificate = certify(plan)
    plan = replace(plan, certificate=certificate.as_json())
    write_plan(plan, path)
    search_time = sum(each.search_time_s for each in found)
    summary = {
        "plan": str(path),
        "scene": scene.name,
        "seed": seed,
        "valid": certificate.valid,
        "plan_time_s": sum(phase["plan_time_s"] for phase in phases) + search_time,
        "motion_time_s": sum(phase["duration_s"] for phase in phases),
        "phases": phases,
        "certificate": certificate.as_json(),
    }
    for each in found:
        summary["postures"] = {"starts": each.starts, "search_time_s": each.search_time_s}
    if plan.robot:
        shares = (largest_share(plan, kind) for kind in SHARE_KINDS)
        summary["joints"] = {share.kind: share.as_json() for share in shares if share}
    return Planned(plan, certificate, summary)


def phase_summary(news: PhaseDone) -> dict[str, Any]:
    """One phase in the words of ``plan --json``."""
    phase = news.phase
    margin = smallest_of_phase(phase_margins(phase), ("friction",))
    return {
        "name": phase.name,
        "kind": phase.kind,
        "finger": phase.finger,
        "duration_s": phase.duration_s,
        "plan_time_s": news.plan_time_s,
        "min_friction_margin": None if margin is None else margin.value,
        "reorientation_deg": phase.reorientation_deg,
        **phase.record,
    }


def show_phases(planned: Planned, out: Output) -> None:
    """Print the table of phases, what planning took, and the verdict."""
    summary, rows = planned.summary, []
    for phase in summary["phases"]:
        margin = phase["min_friction_margin"]
        rows.append(
            (
                phase["name"],
                escape(phase["finger"]) or "-",
                f"{phase['duration_s']:.2f} s",
                f"{1e3 * phase['plan_time_s']:.0f} ms",
                "-" if margin is None else f"{margin:.3f}",
                f"{phase['reorientation_deg']:.1f} deg",
                phase["solver"],
            )
        )
    columns = [
        ("phase", "left"),
        ("finger", "left"),
        ("duration", "right"),
        ("planned", "right"),
        ("margin", "right"),
        ("turn", "right"),
        ("solver", "left"),
    ]
    out.table(f"{summary['scene']}: {summary['plan']}", columns, rows)
    if "postures" in summary:
        starts, spent = summary["postures"]["starts"], summary["postures"]["search_time_s"]
        plural = "" if starts == 1 else "s"
        out.say(f"postures: found after {starts} start{plural} in {spent:.1f} s")
    out.say(
        f"time: {summary['plan_time_s']:.1f} s planning, {summary['motion_time_s']:.1f} s motion"
    )
    show_certificate(planned.certificate, out)


def show_certificate(certificate: Certificate, out: Output) -> None:
    """Print the verdict, and the residuals that miss their limits or come first to mind."""
    valid = certificate.valid
    out.say(f"certificate: {verdict(valid, 'valid', 'NOT valid')}")
    if valid:
        residuals = certificate.residuals
        out.say(
            f"  force balance {residuals['force_balance_n']:.1e} N, "
            f"moment balance {residuals['moment_balance_nm']:.1e} N m, "
            f"cone margin {residuals['cone_margin_n']:.1e} N, "
            f"ramps {residuals.get('ramp_n', 0.0):.1e} N, "
            f"seams {residuals.get('seam_force_n', 0.0):.1e} N"
        )
    columns = [("phase", "left"), ("what", "left"), ("value", "right"), ("limit", "right")]
    rows = [
        (
            escape(each.phase),
            escape(f"{each.what} {each.contact or each.part}"),
            f"{each.value:.3e}",
            f"{each.limit:.1e}",
        )
        for each in certificate.violations
    ]
    if rows:
        out.table("violations", columns, rows)


def run_certify(path: Path, out: Output) -> int:
    """Recompute a plan's certificate from the file alone; returns the exit code."""
    certificate = certify(read_plan(path))
    show_certificate(certificate, out)
    if not out.json:
        columns = [("residual", "left"), ("value", "right"), ("limit", "right"), ("where", "left")]
        rows = []
        for what, found in certificate.findings.items():
            limit = certificate.limits[what].bound
            rows.append((what, f"{found.value:.3e}", f"{limit:.1e}", escape(found.phase)))
        out.table(path.name, columns, rows)
    out.emit(certificate.as_json())
    return 0 if certificate.valid else 1


def writable(path: Path) -> None:
    """Refuse a path that cannot become a file before work is spent on it.

    Raises:
        InputError: its folder is missing or not writable, or it is a folder.
    """
    try:
        if path.is_dir():
            raise InputError("is a folder", where=str(path), mend="give the path of a file")
        path.exists()  # a name too long for the file system raises here
        there = path.parent.is_dir()
    except (OSError, ValueError) as error:
        raise InputError(
            f"is not a path: {error}", where=str(path)[:80], mend="give another"
        ) from error
    if not there:
        raise InputError(f"folder {path.parent} does not exist", where=str(path), mend="make it")
    if not os.access(path.parent, os.W_OK):
        raise InputError(
            f"folder {path.parent} is not writable", where=str(path), mend="use another"
        )


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write JSON whole or not at all."""
    write_atomically((json.dumps(data, indent=2, allow_nan=False) + "\n").encode(), path)
