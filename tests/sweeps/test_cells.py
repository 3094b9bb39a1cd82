"""Cells made from their numbers: mixed radix, draws, names by content."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.stats import kstest

from pivotgait.sweeps import CellSpace, Study, parse_study
from pivotgait.sweeps.axes import Axis
from pivotgait.sweeps.cells import cell_hash
from pivotgait.sweeps.study_config import AxisConfig, Between, Normal
from tests.sweeps.cases import DRAWN


def test_numbers_count_like_nested_loops(grid: Study) -> None:
    space = grid.cells
    assert space.count == 30
    values = [[axis.value(k) for k in range(axis.count)] for axis in space.axes]
    found = [tuple(space.cell(number).values.values()) for number in range(space.count)]
    assert found == list(product(*values))


def test_grids_end_where_they_say(grid: Study) -> None:
    pitch, table, fingers = grid.cells.axes
    assert [pitch.value(k) for k in range(pitch.count)] == [20.0, 40.0]
    assert (table.value(0), table.value(table.count - 1)) == (0.1, 0.9)
    assert [fingers.value(k) for k in range(fingers.count)] == pytest.approx(
        [0.2, 0.4, 0.6, 0.8, 1.0]
    )


@pytest.mark.parametrize("number", [-1, 30])
def test_there_are_no_other_cells(grid: Study, number: int) -> None:
    with pytest.raises(IndexError):
        grid.cells.cell(number)


def test_a_huge_sweep_has_a_last_cell() -> None:
    axes = tuple(
        Axis(name, AxisConfig.model_validate({"values": tuple(map(float, range(1000)))}))
        for name in "abc"
    )
    space = CellSpace(axes, draws=1000, seed=0)
    assert space.count == 10**12
    last = space.cell(10**12 - 1)
    assert (list(last.values.values()), last.draw) == ([999.0] * 3, 999)


def test_draws_are_the_same_at_every_place_of_the_grid(drawn: Study) -> None:
    cells = [drawn.cells.cell(number) for number in range(20)]
    for first, second in zip(cells[:10], cells[10:], strict=True):
        assert first.draw == second.draw
        assert first.values["table.friction"] != second.values["table.friction"]
        assert list(first.values.values())[1:] == list(second.values.values())[1:]
    assert len({cell.values["tool.mass_scale"] for cell in cells}) == 10


def test_more_draws_keep_those_before(drawn: Study) -> None:
    more = parse_study(DRAWN.replace("draws: 10", "draws: 100")).cells
    for number in range(10):
        assert more.cell(number).values == drawn.cells.cell(number).values


def test_same_seed_same_draws(drawn: Study) -> None:
    again = parse_study(DRAWN).cells
    other = parse_study(DRAWN.replace("seed: 4", "seed: 5")).cells
    for number in range(20):
        assert again.cell(number) == drawn.cells.cell(number)
        assert other.cell(number).values != drawn.cells.cell(number).values


@pytest.mark.parametrize(
    ("config", "law"),
    [
        (AxisConfig(uniform=Between(from_=2.0, to=5.0)), ("uniform", (2.0, 3.0))),
        (AxisConfig(loguniform=Between(from_=0.1, to=10.0)), ("loguniform", (0.1, 10.0))),
        (AxisConfig(normal=Normal(mean=-1.0, sd=0.5)), ("norm", (-1.0, 0.5))),
    ],
    ids=["uniform", "loguniform", "normal"],
)
def test_draws_follow_their_law(config: AxisConfig, law: tuple[str, tuple[float, ...]]) -> None:
    axis = Axis("any", config)
    draws = [axis.draw(0, k) for k in range(2000)]
    assert kstest(draws, law[0], args=law[1]).pvalue > 0.01
    other = [Axis("other", config).draw(0, k) for k in range(2000)]
    assert abs(np.corrcoef(draws, other)[0, 1]) < 0.08


def test_names_are_of_the_content(grid: Study) -> None:
    cells = [grid.cells.cell(number) for number in range(30)]
    names = {cell_hash("a", cell, draw_matters=False) for cell in cells}
    assert len(names) == 30
    assert cell_hash("b", cells[0], draw_matters=False) not in names
    moved = type(cells[0])(17, 3, dict(reversed(cells[0].values.items())))
    assert cell_hash("a", moved, draw_matters=False) in names
    assert cell_hash("a", moved, draw_matters=True) not in names
