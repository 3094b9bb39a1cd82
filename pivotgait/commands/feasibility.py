"""``feasibility``: the verdict on a scene's gait, what binds, what mends it, the margins."""

from __future__ import annotations

from collections.abc import Sequence

from rich.markup import escape

from pivotgait.commands.output import Output, verdict
from pivotgait.exceptions import InputError
from pivotgait.feasibility import Variants, Verdict, VerdictOptions, judge
from pivotgait.models import load_scene, scene_folder
from pivotgait.models.parameters import Value

_SHOWN = {
    "friction_drop": ("friction lower", "%"),
    "finger_friction_drop": ("  fingers' only", "%"),
    "table_friction_drop": ("  table's only", "%"),
    "torsion_drop": ("torsion lower", "%"),
    "mass_increase": ("mass higher", "%"),
    "mass_decrease": ("mass lower", "%"),
    "sensing_share": ("sensing error", ""),
    "torque_drop": ("torque lower", "%"),
    "lift_off_N": ("tip force", "N"),
    "wrench_ball_N": ("wrench, at end", "N"),
}
"""Margins in the order of the table: words and unit."""


def run_feasibility(scene: str, given: Sequence[str], options: VerdictOptions, out: Output) -> int:
    """Judge a scene's gait; returns the exit code: 1 where it is infeasible."""
    changes = read_changes(given)
    loaded = load_scene(scene)
    with out.progress(f"judging {loaded.name}", None) as bar:

        def tell(text: str) -> None:
            bar.update(bar.task_ids[0], description=escape(f"judging {loaded.name}: {text}"))

        found = judge(Variants(loaded, scene_folder(scene)), options, changes=changes, tell=tell)
    show_verdict(loaded.name, found, options, out)
    summary = {"scene": loaded.name, "set": changes, **found.as_json()}
    out.emit(summary)
    return 0 if found.feasible else 1


def read_changes(given: Sequence[str], *, where: str = "--set") -> dict[str, Value]:
    """Parameter -> value of ``PATH=VALUE`` texts, in their order.

    Raises:
        InputError: for a text without a path or a value.
    """
    changes: dict[str, Value] = {}
    for text in given:
        path, mark, value = (part.strip() for part in text.partition("="))
        if not (path and mark and value):
            mend = "write PATH=VALUE, for example contacts.*.friction=0.4"
            raise InputError(f"cannot read {text!r}", where=where, mend=mend)
        try:
            changes[path] = float(value)
        except ValueError:
            changes[path] = value
    return changes


def show_verdict(scene: str, found: Verdict, options: VerdictOptions, out: Output) -> None:
    """Print the verdict, what binds, the mends and the margins of each phase."""
    binding, margins = found.binding, found.margins
    word = verdict(found.feasible, "feasible", "NOT feasible")
    out.say(f"{escape(scene)}: {word}")
    label = "nearest limit" if found.feasible else "binds"
    where = f"{binding.phase} at {binding.time_s:.2f} s"
    out.say(f"  {label}: {escape(f'{binding.kind} {binding.contact}, {where}: {binding.text}')}")
    if found.mends:
        columns = [("change", "left"), ("from", "right"), ("to", "right")]
        mends = [(escape(m.change), f"{m.from_:.5g}", f"{m.to:.5g}") for m in found.mends]
        out.table("each of these makes it feasible", columns, mends)
        first = found.mends[0]
        if first.change != "turn_max_deg":
            out.say(f"  try it: --set '{escape(first.change)}={first.to:g}'")
        else:
            out.say(f"  try it: --turn-max {first.to:g}")
    elif not found.feasible and options.mends:
        out.say("  no single change within reach makes it feasible")
    # a relocation leaves the tool and its forces as they were
    shown = {name: each for name, each in margins.by_phase.items() if "relocation" not in name}
    columns = [("error", "left"), *((escape(phase), "right") for phase in shown)]
    rows = [
        (name, *(_number(values[key], unit) for values in shown.values()))
        for key, (name, unit) in _SHOWN.items()
        if any(values[key] is not None for values in shown.values())
    ]
    if shown:
        out.table("largest error that the rest absorbs, least of each phase", columns, rows)
        out.say("  sensing error: share of 25 % in size with 30 deg in direction")
    if margins.ball is not None and margins.ball[0].radius_N > 0.0:
        ball, at = margins.ball
        volume = margins.volume
        size = "" if volume is None else f"; volume of the wrenches {volume.volume_N6:.3g} N^6"
        out.say(
            f"  external wrench: weakest at the end of {escape(at.phase)}, "
            f"{ball.radius_N:.4g} N with moments over {ball.length_m:.3f} m{size}"
        )
    if margins.torque is not None:
        share = margins.torque
        out.say(f"  torque margin {1.0 - share.value:.3f}: {escape(share.joint)}")


def _number(value: float | None, unit: str) -> str:
    if value is None:
        return "-"
    return f"{100.0 * value:.0f} %" if unit == "%" else f"{value:.3f} {unit}".strip()
