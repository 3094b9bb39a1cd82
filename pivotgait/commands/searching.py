"""``search``: from a tool and a wanted grasp to contacts and an order of gaits."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.markup import escape

from pivotgait.atomic import write_atomically
from pivotgait.commands.output import Output, verdict
from pivotgait.commands.planning import writable
from pivotgait.exceptions import InputError
from pivotgait.gait_search import (
    Cost,
    CostWeights,
    FoundGait,
    News,
    SearchOptions,
    SearchResult,
    read_contacts,
    read_goal,
    search_gait,
)
from pivotgait.gait_search.states import Move
from pivotgait.models import Scene, builtin_scenes, load_scene

_ENDED = {
    "exhausted": "every branch died",
    "impossible": "forces forbid every order of fingers",
    "time": "the time is up",
    "plans": "no sequence tried could be planned",
}
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_-]")


@dataclass(frozen=True)
class SearchRequest:
    """What the command line asks for.

    Attributes:
        goal: words of the wanted grasp.
        first: contacts that lift the tool; None for any.
        seed: of postures and plans.
        out: scene file to write.
        sequences: certified ones to find before the cheapest is taken.
        time_limit_s: for all of it [s].
        hand: whether the robot is asked.
    """

    goal: str
    first: str | None = None
    seed: int = 0
    out: Path | None = None
    sequences: int = 1
    time_limit_s: float = 60.0
    hand: bool = True


def run_search(scene_name: str, request: SearchRequest, out: Output) -> int:
    """Search, write the scene, tell why branches died; returns the exit code: 1 if none found."""
    scene = load_scene(scene_name)
    folder = None if scene_name in builtin_scenes() else Path(scene_name).parent
    if request.out is not None:
        check_out(request.out, scene, folder)
    goal = read_goal(request.goal, scene)
    first = read_contacts(request.first, scene, where="--first") if request.first else ()
    options = SearchOptions(
        sequences=request.sequences, time_limit_s=request.time_limit_s, hand=request.hand
    )
    with out.progress(f"searching {scene.name}", None) as bar:

        def tell(news: News) -> None:
            words = (
                f"searching {scene.name}: {news.expanded} grasps left, {news.waiting} branches "
                f"wait, {news.postures} postures, {news.plans} plans"
            )
            bar.update(bar.task_ids[0], description=escape(words))

        result = search_gait(
            scene,
            goal,
            seed=request.seed,
            first=first,
            name=_scene_name(request.out, scene),
            options=options,
            folder=folder,
            tell=tell,
        )
    if result.found is not None and request.out is not None:
        write_atomically(result.found.found.text.encode(), request.out)
    show_search(scene.name, result, options.weights, request.out, out)
    out.emit(summary(scene.name, result, options.weights, request))
    return 0 if result.found else 1


def check_out(path: Path, scene: Scene, folder: Path | None) -> None:
    """Refuse a file that cannot be written, or from which the scene's URDFs are not found.

    Raises:
        InputError: for such a path.
    """
    writable(path)
    if path.suffix not in (".yaml", ".yml"):
        mend = "give a file ending in .yaml"
        raise InputError("is no scene's file name", where=str(path), mend=mend)
    robot = scene.config.robot
    mount = robot.mount if robot else None
    urdfs = [scene.config.tool.urdf, *([robot.urdf] if robot and robot.urdf else [])]
    urdfs += [mount.arm, mount.hand] if mount else []
    beside = [each for each in urdfs if folder is not None and (folder / each).is_file()]
    if beside and folder is not None and folder.resolve() != path.parent.resolve():
        mend = "write it into the folder of the scene searched"
        raise InputError(f"would not find {beside[0]}", where=str(path), mend=mend)


def summary(
    scene: str, result: SearchResult, weights: CostWeights, request: SearchRequest
) -> dict[str, Any]:
    """What ``search --json`` prints."""
    found, news = result.found, result.news
    written = request.out if found else None
    return {
        "scene": scene,
        "goal": result.goal,
        "seed": request.seed,
        "found": found is not None,
        "ended": result.ended,
        "elapsed_s": result.elapsed_s,
        "sequence": found_json(found, weights) if found else None,
        "others": [found_json(each, weights) for each in result.others],
        "file": str(written) if written else None,
        "yaml": found.found.text if found else None,
        "branches": {
            "expanded": news.expanded,
            "waiting": news.waiting,
            "postures": news.postures,
            "plans": news.plans,
        },
        "deaths": result.deaths.as_json(),
    }


def found_json(gait: FoundGait, weights: CostWeights) -> dict[str, Any]:
    """A certified sequence in the words of ``search --json``."""
    return {
        "moves": [
            {"kind": move.kind, "contacts": [each.name for each in move.contacts]}
            for move in gait.moves
        ],
        "contacts": {
            each.name: {
                "finger": each.finger,
                "along_m": each.along_m,
                "around_deg": each.around_deg,
            }
            for move in gait.moves
            for each in move.contacts
        },
        "cost": gait.cost.as_json(weights),
        "estimate": gait.estimate.as_json(weights),
        "palm_m": gait.palm_m if gait.palm_m == gait.palm_m else None,
        "certificate_valid": gait.certificate.valid,
    }


def show_search(
    scene: str, result: SearchResult, weights: CostWeights, file: Path | None, out: Output
) -> None:
    """Print the verdict, the sequences with their costs, and why branches died."""
    word = verdict(result.found is not None, "found", "NOT found")
    why = "" if result.found else f" ({_ENDED[result.ended]})"
    out.say(f"{escape(scene)}, goal {escape(result.goal)}: {word}{why}")
    for gait in [result.found, *result.others] if result.found else []:
        assert gait is not None
        _show_gait(gait, weights, out)
    deaths = [
        (stage, escape(reason), str(number)) for stage, reason, number in result.deaths.rows()
    ]
    columns = [("test", "left"), ("reason", "left"), ("branches", "right")]
    out.table("why branches died, from the cheapest test to the dearest", columns, deaths)
    news = result.news
    out.say(
        f"time: {result.elapsed_s:.1f} s; {news.expanded} grasps left, {news.waiting} branches "
        f"waiting, postures of {news.postures}, {news.plans} planned fully"
    )
    if result.found is not None and file is not None:
        out.say(f"scene: {escape(str(file))}; plan it: pivotgait plan {escape(str(file))}")


def _show_gait(gait: FoundGait, weights: CostWeights, out: Output) -> None:
    moves = [(str(k), move.kind, _places(move)) for k, move in enumerate(gait.moves, start=1)]
    columns = [("", "right"), ("move", "left"), ("contacts: along the handle, around it", "left")]
    out.table("sequence, certified", columns, moves)
    costs = {"planned": gait.cost, "estimate": gait.estimate}
    columns = [("cost", "left"), ("total", "right"), ("turn", "right"), ("margin", "right")]
    columns += [("fingertips' way", "right"), ("time", "right")]
    out.table("", columns, [_cost_row(name, cost, weights) for name, cost in costs.items()])


def _places(move: Move) -> str:
    return escape(
        "; ".join(
            f"{each.name} ({1e3 * each.along_m:g} mm, {each.around_deg:g} deg)"
            for each in move.contacts
        )
    )


def _cost_row(name: str, cost: Cost, weights: CostWeights) -> tuple[str, ...]:
    numbers = cost.as_json(weights)
    return (
        name,
        f"{numbers['total']:.2f}",
        f"{numbers['reorientation_deg']:.1f} deg",
        f"{numbers['margin_shortfall']:.2f}",
        f"{1e3 * numbers['path_m']:.0f} mm",
        f"{numbers['time_s']:.2f} s",
    )


def _scene_name(path: Path | None, scene: Scene) -> str:
    """Of the found scene: its file's, as far as names may go."""
    if path is None:
        return f"{scene.name}_found"[:64]
    name = _NOT_IN_NAMES.sub("_", path.stem)[:64]
    return name if name[:1].isalpha() else f"found_{name}"[:64]
