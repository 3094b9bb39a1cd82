"""Maps of feasibility over two parameters, their border traced instead of a grid filled."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from pivotgait.exceptions import InputError, SceneError
from pivotgait.feasibility.borders import border
from pivotgait.feasibility.changes import Variants
from pivotgait.feasibility.quadtree import COARSE, NONE, refine
from pivotgait.feasibility.questions import Question
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import Scene
from pivotgait.models.parameters import Value

LEVELS_MAX = 8
Tell = Callable[[int], None]


@dataclass(frozen=True)
class MapAxis:
    """One axis of a map.

    Attributes:
        parameter: see :func:`pivotgait.models.parameters.places_of`.
        low: value at its beginning, in the parameter's own unit.
        high: value at its end.

    Raises:
        InputError: a range that is empty or not finite.
    """

    parameter: str
    low: float
    high: float

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            what = f"goes from {self.low:g} to {self.high:g}"
            raise InputError(what, where=self.parameter, mend="give the smaller value first")

    def at(self, share: Array) -> Array:
        """Values at shares of the axis, 0 at its beginning."""
        return np.asarray(self.low + share * (self.high - self.low))


@dataclass(frozen=True, eq=False)
class FeasibilityMap(FrozenArrays):
    """A question answered over two parameters.

    Attributes:
        across: horizontal axis.
        up: vertical axis.
        question: that was asked.
        fixed: the parameters that are the same all over the map.
        points: (n, 2) where it was answered, in the parameters' units.
        value: (n,) of the question's quantity there.
        feasible: (n,) 1 or 0; NaN where the values make no scene.
        border: (s, 2, 2) segments about what is feasible, in the parameters' units.
        own: (2,) the scene's own values; NaN where it has none on the map.
        tolerance: of the border, share of either axis.
        area: feasible share of the map's area.
        grid: points of a grid that would be everywhere as fine.
    """

    across: MapAxis
    up: MapAxis
    question: Question
    fixed: Mapping[str, Value]
    points: Array
    value: Array
    feasible: Array
    border: Array
    own: Array
    tolerance: float
    area: float
    grid: int

    @property
    def evaluated(self) -> int:
        """Number of points at which the question was answered."""
        return len(self.value)

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line; what is not finite is None."""
        return {
            "across": vars(self.across),
            "up": vars(self.up),
            "question": vars(self.question),
            "fixed": dict(self.fixed),
            "tolerance": self.tolerance,
            "feasible_area": self.area,
            "evaluated": self.evaluated,
            "grid": self.grid,
            "points": self.points.tolist(),
            "value": _plain(self.value),
            "feasible": _plain(self.feasible),
            "border": self.border.tolist(),
        }


def trace_map(
    variants: Variants,
    question: Question,
    across: MapAxis,
    up: MapAxis,
    *,
    fixed: Mapping[str, Value] = MappingProxyType({}),
    tolerance: float = 1.0 / 128.0,
    tell: Tell = lambda count: None,
) -> FeasibilityMap:
    """Answer a question over two parameters, densely only about the border of what is feasible.

    Args:
        variants: of the scene.
        question: asked at every point.
        across: first parameter.
        up: second parameter.
        fixed: other parameters that are set.
        tolerance: size of the cells about the border, share of either axis.
        tell: called with the number of points of each round before it is computed.

    Raises:
        InputError: both axes are of one parameter or of a fixed one; a tolerance beyond 1/8 or
            below 1/2048.
        UnknownNameError: no such parameter.
    """
    _check_names((across.parameter, up.parameter, *fixed))
    tree = refine(
        partial(_answers, variants, question, (across, up), fixed, tell),
        levels=_levels(tolerance),
    )
    nodes = tree.nodes
    place = tuple(nodes.T)
    state = tree.state[place]
    return FeasibilityMap(
        across=across,
        up=up,
        question=question,
        fixed=dict(fixed),
        points=_scaled(nodes / tree.side, across, up),
        value=tree.kept[place],
        feasible=np.where(state == NONE, np.nan, state),
        border=_scaled(border(tree), across, up),
        own=_own(variants, across, up),
        tolerance=1.0 / tree.side,
        area=tree.share(1.0),
        grid=tree.grid,
    )


def trace_slices(
    variants: Variants,
    question: Question,
    across: MapAxis,
    up: MapAxis,
    slices: Sequence[tuple[str, Value]],
    **options: Any,
) -> tuple[FeasibilityMap, ...]:
    """Maps for several values of a third parameter.

    Args:
        variants: of the scene.
        question: asked at every point.
        across: first parameter.
        up: second parameter.
        slices: the third parameter and its value, one map each; the parameter ``removed`` names
            a finger that does not hold (see :class:`Question`), empty for none.
        options: further arguments of :func:`trace_map`.

    Raises:
        InputError, UnknownNameError: as :func:`trace_map` and :meth:`Question.without`.
    """
    fixed = dict(options.pop("fixed", {}))
    found = []
    for name, value in slices:
        if name == "removed":
            asked = question.without(str(value), variants.scene)
            sliced = trace_map(variants, asked, across, up, fixed=fixed, **options)
            found.append(replace(sliced, fixed={**fixed, name: value}))
        else:
            more = {**fixed, name: value}
            found.append(trace_map(variants, question, across, up, fixed=more, **options))
    return tuple(found)


def scenes_at(
    variants: Variants, changes: Sequence[Mapping[str, Value]]
) -> tuple[list[Scene], list[int]]:
    """The scenes after each of some changes, and the places of those that make one.

    Raises:
        UnknownNameError: no such parameter.
    """
    scenes, places = [], []
    for place, each in enumerate(changes):
        try:
            scenes.append(variants.scene_with(each))
        except SceneError:
            continue
        places.append(place)
    return scenes, places


def _answers(
    variants: Variants,
    question: Question,
    axes: tuple[MapAxis, MapAxis],
    fixed: Mapping[str, Value],
    tell: Tell,
    points: Array,
) -> Array:
    tell(len(points))
    names = [axis.parameter for axis in axes]
    rows = _scaled(points, *axes).tolist()
    changes = [{**fixed, **dict(zip(names, row, strict=True))} for row in rows]
    scenes, places = scenes_at(variants, changes)
    found = np.full((3, len(points)), np.nan)
    if scenes:
        answers = question.answers(scenes)
        found[:, places] = answers.feasible, answers.depth, answers.value
    return found


def _scaled(unit: Array, across: MapAxis, up: MapAxis) -> Array:
    return np.stack((across.at(unit[..., 0]), up.at(unit[..., 1])), axis=-1)


def _own(variants: Variants, across: MapAxis, up: MapAxis) -> Array:
    own = np.array([float(variants.value(axis.parameter)) for axis in (across, up)])
    inside = all(a.low <= each <= a.high for a, each in zip((across, up), own, strict=True))
    return own if inside else np.full(2, np.nan)


def _levels(tolerance: float) -> int:
    finest = COARSE << LEVELS_MAX
    if not 1.0 / finest <= tolerance <= 1.0 / COARSE:
        mend = f"give a share of the axes from 1/{finest} to 1/{COARSE}"
        raise InputError(f"tolerance is {tolerance:g}", where="map", mend=mend)
    return int(np.ceil(np.log2(1.0 / tolerance / COARSE) - 1e-9))


def _check_names(names: Sequence[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            mend = "give another parameter"
            raise InputError(f"{name!r} is set twice", where="map", mend=mend)


def _plain(values: Array) -> list[float | None]:
    return [each if np.isfinite(each) else None for each in values.tolist()]
