"""``feasibility --map``: a map over two parameters, or slices of it over a third."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.markup import escape

from pivotgait.atomic import write_atomically
from pivotgait.commands.feasibility import read_changes
from pivotgait.commands.output import Output
from pivotgait.exceptions import InputError
from pivotgait.feasibility import (
    FeasibilityMap,
    MapAxis,
    Question,
    ShareMap,
    Variants,
    share_map,
    trace_map,
    trace_slices,
)
from pivotgait.models import load_scene, scene_folder
from pivotgait.models.parameters import Value

SLICES = 3
"""Values of a third parameter, its ends among them."""


@dataclass(frozen=True)
class MapRequest:
    """What the command line asks for.

    Attributes:
        maps: ``PATH=LO:HI`` texts; the third may be ``removed=FINGER,FINGER``.
        gait: of the scene; the first by default.
        phase: whose grasp, see :meth:`Question.about`.
        quantity: see :class:`Question`.
        turn_max_deg: largest turn that counts [deg]; None for the most there is.
        tolerance: of the border, share of either axis; None for 1/128, 1/16 for ``turn``.
        spread: ``PATH=SD`` texts, for a map of the share of draws that hold.
        draws: at each point of that map.
        seed: of the draws.
    """

    maps: tuple[str, ...]
    gait: str | None = None
    phase: str | None = None
    quantity: str = "depth"
    turn_max_deg: float | None = None
    tolerance: float | None = None
    spread: tuple[str, ...] = ()
    draws: int = 64
    seed: int = 0


def run_maps(
    scene: str, given: Sequence[str], request: MapRequest, folder: Path | None, out: Output
) -> int:
    """Trace the maps, print their summary, write them; returns the exit code 0."""
    changes = read_changes(given)
    if len(request.maps) < 2:
        mend = "give it twice, or a third time for slices"
        raise InputError("one parameter makes no map", where="--map", mend=mend)
    across, up = (read_axis(text) for text in request.maps[:2])
    slices = read_slices(request.maps[2:])
    loaded = load_scene(scene)
    variants = Variants(loaded, scene_folder(scene))
    turn = {} if request.turn_max_deg is None else {"turn_max_deg": request.turn_max_deg}
    question = Question.about(
        variants.scene_with(changes),
        gait=request.gait,
        phase=request.phase,
        quantity=request.quantity,
        **turn,  # type: ignore[arg-type]
    )
    coarse = 1.0 / 16.0 if request.quantity == "turn" else 1.0 / 128.0
    options: dict[str, Any] = {"fixed": changes, "tolerance": request.tolerance or coarse}
    with out.progress(f"mapping {loaded.name}", None) as bar:
        done = 0

        def tell(count: int) -> None:
            nonlocal done
            done += count
            words = f"mapping {loaded.name}: {done} points"
            bar.update(bar.task_ids[0], description=escape(words))

        if slices:
            maps = trace_slices(variants, question, across, up, slices, tell=tell, **options)
        else:
            maps = (trace_map(variants, question, across, up, tell=tell, **options),)
        share = _share(variants, question, (across, up), changes, request, tell)
    files = () if folder is None else _write(folder, maps, share)
    _show(loaded.name, maps, share, files, out)
    summary = {
        "scene": loaded.name,
        "set": changes,
        "maps": [each.as_json() for each in maps],
        "share": share.as_json() if share else None,
        "files": [str(each) for each in files],
    }
    out.emit(summary)
    return 0


def read_axis(text: str) -> MapAxis:
    """The axis of a ``PATH=LO:HI`` text.

    Raises:
        InputError: it cannot be read, or the range is empty.
    """
    path, _, span = text.partition("=")
    low, mark, high = span.partition(":")
    try:
        if not (path.strip() and mark):
            raise ValueError
        return MapAxis(path.strip(), float(low), float(high))
    except ValueError as error:
        mend = "write PATH=LO:HI, for example contacts.*.friction=0.2:1.2"
        raise InputError(f"cannot read {text!r}", where="--map", mend=mend) from error


def read_slices(texts: Sequence[str]) -> list[tuple[str, Value]]:
    """Slices over a third parameter: a range, or fingers that are removed.

    Raises:
        InputError: there are more than one, or it cannot be read.
    """
    if len(texts) > 1:
        mend = "give three at most; more parameters make a sweep"
        raise InputError(f"{2 + len(texts)} parameters", where="--map", mend=mend)
    if not texts:
        return []
    name, _, names = texts[0].partition("=")
    if name.strip() == "removed":
        return [("removed", each.strip()) for each in names.split(",")]
    axis = read_axis(texts[0])
    return [(axis.parameter, float(each)) for each in axis.at(np.linspace(0.0, 1.0, SLICES))]


def _share(
    variants: Variants,
    question: Question,
    axes: tuple[MapAxis, MapAxis],
    changes: Mapping[str, Value],
    request: MapRequest,
    tell: Any,
) -> ShareMap | None:
    if not request.spread:
        return None
    spread = read_changes(request.spread, where="--spread")
    numbers = {path: value for path, value in spread.items() if not isinstance(value, str)}
    if len(numbers) < len(spread):
        mend = "write PATH=SD, for example contacts.*.friction=0.1"
        raise InputError("a standard deviation is no number", where="--spread", mend=mend)
    rng = np.random.default_rng(request.seed)
    return share_map(
        variants,
        question,
        axes[0],
        axes[1],
        numbers,
        rng,
        fixed=changes,
        draws=request.draws,
        tell=tell,
    )


def _write(
    folder: Path, maps: Sequence[FeasibilityMap], share: ShareMap | None
) -> tuple[Path, ...]:
    """Write ``map.json`` and the figure.

    Raises:
        InputError: the folder cannot be written.
    """
    from pivotgait.plotting import feasibility_maps, save_figure

    data = {"maps": [each.as_json() for each in maps], "share": share.as_json() if share else None}
    try:
        saved = save_figure(feasibility_maps(maps, share=share), folder, "map")
        write_atomically((json.dumps(data) + "\n").encode(), folder / "map.json")
    except OSError as error:
        what, mend = f"cannot be written: {error.strerror}", "give another --out"
        raise InputError(what, where=str(folder), mend=mend) from error
    return saved.png, saved.pdf, folder / "map.json"


def _show(
    scene: str,
    maps: Sequence[FeasibilityMap],
    share: ShareMap | None,
    files: Sequence[Path],
    out: Output,
) -> None:
    columns = [("slice", "left"), ("feasible area", "right"), ("points", "right")]
    columns += [("points of a grid as fine", "right")]
    rows = [
        (
            escape(", ".join(f"{k} {v}" for k, v in each.fixed.items()) or "all as in the scene"),
            f"{100.0 * each.area:.1f} %",
            f"{each.evaluated}",
            f"{each.grid}",
        )
        for each in maps
    ]
    first = maps[0]
    title = f"{scene}: {first.across.parameter} x {first.up.parameter}"
    out.table(title, columns, rows)
    if share is not None:
        least, most = np.nanmin(share.share), np.nanmax(share.share)
        out.say(f"  share of draws that hold: {100 * least:.0f} to {100 * most:.0f} %")
    for each in files:
        out.say(f"  {escape(str(each))}")
