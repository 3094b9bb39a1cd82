"""How likely a grasp holds where some parameters are not known well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.feasibility.changes import Variants
from pivotgait.feasibility.maps import MapAxis, Tell, scenes_at
from pivotgait.feasibility.questions import Question
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.parameters import Value

CELLS, DRAWS = 12, 64


@dataclass(frozen=True, eq=False)
class ShareMap(FrozenArrays):
    """Share of draws in which a grasp holds, over two parameters.

    Attributes:
        across: horizontal axis.
        up: vertical axis.
        question: that was asked.
        spread: standard deviation by parameter, in its own unit.
        x: (n,) values across.
        y: (m,) values up.
        share: (m, n) of the draws that make a scene; NaN where none does.
        draws: at each point.
        standard_error: (m, n) of the share.
    """

    across: MapAxis
    up: MapAxis
    question: Question
    spread: Mapping[str, float]
    x: Array
    y: Array
    share: Array
    draws: int
    standard_error: Array

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line; what is not finite is None."""
        rows = [[None if np.isnan(each) else each for each in row] for row in self.share.tolist()]
        return {
            "across": vars(self.across),
            "up": vars(self.up),
            "spread": dict(self.spread),
            "draws": self.draws,
            "x": self.x.tolist(),
            "y": self.y.tolist(),
            "share": rows,
        }


def share_map(
    variants: Variants,
    question: Question,
    across: MapAxis,
    up: MapAxis,
    spread: Mapping[str, float],
    rng: np.random.Generator,
    *,
    fixed: Mapping[str, Value] = MappingProxyType({}),
    cells: int = CELLS,
    draws: int = DRAWS,
    tell: Tell = lambda count: None,
) -> ShareMap:
    """Share of feasible draws at every point of a grid.

    Each parameter of ``spread`` is drawn from a normal distribution about its value at that point
    of the map. All points meet the same draws, so that differences between them are no chance.

    Args:
        variants: of the scene.
        question: asked in every draw.
        across: first parameter.
        up: second parameter.
        spread: parameter -> standard deviation, in its own unit.
        rng: of the draws.
        fixed: other parameters that are set.
        cells: of the grid along each side.
        draws: at each point.
        tell: called with the number of scenes of each row before it is computed.

    Raises:
        InputError: nothing is spread, or by no positive number.
        UnknownNameError: no such parameter.
    """
    if not spread or not all(0.0 < each < np.inf for each in spread.values()):
        mend = "give PATH=SD with a positive standard deviation"
        raise InputError("nothing to draw from", where="spread", mend=mend)
    normal = rng.normal(size=(draws, len(spread)))
    x, y = (axis.at(np.linspace(0.0, 1.0, cells + 1)) for axis in (across, up))
    centre = {**{name: float(variants.value(name)) for name in spread}, **fixed}
    share, error = np.full((2, len(y), len(x)), np.nan)
    for row, second in enumerate(y.tolist()):
        places = [{**fixed, across.parameter: a, up.parameter: second} for a in x.tolist()]
        changes = [
            {**at, **_drawn({**centre, **at}, spread, z)} for at in places for z in normal.tolist()
        ]
        tell(len(changes))
        scenes, found = scenes_at(variants, changes)
        holds = np.full(len(changes), np.nan)
        if scenes:
            holds[found] = question.answers(scenes).feasible
        by_point = holds.reshape(len(x), draws)
        count = np.sum(~np.isnan(by_point), axis=1)
        enough = count > 0
        share[row, enough] = np.nansum(by_point[enough], axis=1) / count[enough]
        error[row, enough] = np.sqrt(share[row, enough] * (1 - share[row, enough]) / count[enough])
    return ShareMap(across, up, question, dict(spread), x, y, share, draws, error)


def _drawn(
    centre: Mapping[str, Value], spread: Mapping[str, float], normal: list[float]
) -> dict[str, float]:
    return {
        name: float(centre[name]) + size * each
        for (name, size), each in zip(spread.items(), normal, strict=True)
    }
