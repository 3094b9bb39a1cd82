"""Maps and curves: every point is drawn in its own unit, gaps stay gaps."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from pivotgait.feasibility import FeasibilityMap, MapAxis, Question
from pivotgait.plotting import document, feasibility_maps, figure_bytes
from pivotgait.plotting.curves import Curve, Panel, curve_panels
from pivotgait.plotting.document import (
    Heading,
    Paragraph,
    PictureBlock,
    TableBlock,
    document_pdf,
)
from pivotgait.plotting.margin_prediction import MarginPrediction, margin_prediction
from pivotgait.plotting.parameters import parameter_label, parameter_value, parameter_words
from pivotgait.plotting.study_maps import GridLines, GridMap, grid_lines, grid_maps


def a_map(quantity, values, feasible, **fixed):
    along, around = MapAxis("contacts.a.along_m", 0.0, 0.1), MapAxis("table.friction", 0.0, 1.0)
    x, y = (each.reshape(-1) for each in np.meshgrid([0.0, 0.05, 0.1], [0.0, 0.5, 1.0]))
    return FeasibilityMap(
        along,
        around,
        Question("default", 0, quantity),
        fixed,
        np.stack((x, y), axis=1),
        np.broadcast_to(values, 9),
        np.broadcast_to(feasible, 9),
        np.array([[[0.02, 0.0], [0.02, 1.0]]]),
        np.array([0.05, 0.5]),
        0.1,
        0.5,
        9,
    )


@pytest.mark.parametrize("quantity", ["depth", "margin", "turn"])
@pytest.mark.parametrize("empty", [False, True])
def test_maps_are_drawn_in_the_labels_units(quantity, empty):
    values = np.linspace(-0.4, 0.6, 9)
    feasible = np.where(values >= 0.0, 1.0, 0.0)
    if empty:
        values[:2], feasible[:2] = np.nan, np.nan
    figure = feasibility_maps([a_map(quantity, values, feasible)])
    axes = figure.axes[0]
    assert axes.get_xlim() == (0.0, 100.0)
    assert "[mm]" in axes.get_xlabel()
    border = next(each for each in axes.collections if isinstance(each, LineCollection))
    assert np.allclose(border.get_segments()[0][:, 0], 20.0)
    shown = [text.get_text() for text in figure.legends[0].get_texts()]
    assert ("no such grasp" in shown) == empty
    assert figure_bytes(figure, "png")


@pytest.mark.parametrize("value", [-np.inf, np.nan, -1.0])
def test_a_map_in_which_nothing_holds_is_grey(value):
    figure = feasibility_maps([a_map("depth", value, 0.0)])
    assert figure_bytes(figure, "svg")


def test_slices_are_named():
    maps = [a_map("depth", 1.0, 1.0, removed=each) for each in ("", "thumb")]
    titles = [axes.get_title() for axes in feasibility_maps(maps).axes[:2]]
    assert titles == ["with all fingers", "without thumb"]


@pytest.mark.parametrize("count", [1, 3])
def test_grids_leave_gaps_where_nothing_is_known(count):
    value = np.arange(6.0 * count).reshape(count, 2, 3)
    value[0, 0, 0] = np.nan
    slices = tuple(10.0 * k for k in range(count)) if count > 1 else ("",)
    sliced = "tool.pitch_deg" if count > 1 else ""
    x, y = (0.1, 0.2, 0.3), ("a", "b")
    figure = grid_maps(
        GridMap("table.friction", "names", x, y, slices, sliced, value, value > 2.0, "N")
    )
    mesh = figure.axes[0].collections[0]
    assert mesh.get_array().mask.sum() == 1
    assert figure_bytes(figure, "png")


def test_lines_have_names_as_ticks():
    y = np.array([1.0, np.nan])
    figure = grid_lines(GridLines("allocation.objective", ("effort", "margin"), y, y, y, "N"))
    ticks = [each.get_text() for each in figure.axes[0].get_xticklabels()]
    assert ticks == ["effort", "margin"]


@pytest.mark.parametrize(
    ("parameter", "words", "value"),
    [
        ("contacts.thumb_spine.along_m", "thumb spine along the handle [mm]", 38.0),
        ("contacts.*.friction", "friction of the fingers [-]", 0.038),
        ("some.other.path", "some.other.path", 0.038),
    ],
)
def test_parameters_have_words_and_units(parameter, words, value):
    assert parameter_words(parameter) == words
    assert parameter_label(parameter).scale * 0.038 == pytest.approx(value)
    assert f"{value:g}" in parameter_value(parameter, 0.038)


def test_curves_of_a_finger_have_its_colour():
    x = np.arange(3.0)
    curves = (Curve("thumb", x, x), Curve("else", x, x * np.nan, style="", marker="o"))
    figure = curve_panels([[Panel("a", "x [m]", "y [N]", curves, limit=0.0)] * 2] * 2)
    assert {axes.lines[0].get_color() for axes in figure.axes} == {"#D55E00"}
    assert len(figure.legends[0].get_texts()) == 2


@pytest.mark.parametrize("n", [0, 1, 20])
def test_predictions_of_any_number_of_trials_are_drawn(n):
    rng = np.random.default_rng(0)
    line = np.array([0.0, 1.0])
    found = MarginPrediction(
        np.linspace(-1, 1, 3),
        {"mass_scale": np.zeros(3)},
        rng.uniform(size=n),
        np.round(rng.uniform(size=n)),
        {"margin": (line, line)},
        {"margin": float("nan") if n < 2 else 0.7},
    )
    assert figure_bytes(margin_prediction(found), "png")


@pytest.mark.parametrize("letters", [(5, 5), (120, 8, 8), (40, 30, 30, 30), (60,) * 6, (9,) * 20])
def test_columns_of_a_table_fit_the_page(letters):
    widths, size = document._columns([tuple("x" * n for n in letters), ("a",) * len(letters)])
    across = sum(w + document._GAP for w in widths) * document._LETTER * size / 72.0
    assert across <= document._ROOM
    assert all(1 <= width <= most for width, most in zip(widths, letters, strict=True))
    # nothing is broken or small that had room
    if sum(letters) <= 60:
        assert (widths, size) == (list(letters), document._TABLE_SIZE)


def test_a_picture_keeps_its_shape_and_its_page():
    for shape in ((100, 100), (9000, 300), (300, 9000), (5000, 5000)):
        width, height = document._size(np.zeros(shape), 300.0)
        assert width / height == pytest.approx(shape[1] / shape[0])
        assert width <= document._ROOM
        assert height <= document.HEIGHT_IN - 2.0 * document.MARGIN_IN


def test_a_heading_stands_above_its_picture():
    """Pages of text that leave less room than a picture needs: the heading goes with it."""
    png = figure_bytes(grid_lines(GridLines("a", (1.0,), *[np.ones(1)] * 3, "N")), "png")
    picture = PictureBlock(png, "caption", 100.0)
    assert document._with_it([picture]) == document._with_it([Paragraph("a"), picture]) > 1.0
    assert document._with_it([TableBlock(("a",), ()), picture]) == 0.0
    assert document._with_it([]) == 0.0


def test_a_document_goes_over_as_many_pages_as_it_needs():
    png = figure_bytes(grid_lines(GridLines("a", (1.0,), *[np.ones(1)] * 3, "N")), "png")
    blocks = [
        Heading("Title $1$", 1),
        Paragraph("word " * 900),
        TableBlock(("a", "b"), (("x", "1"),) * 80),
        PictureBlock(png, "caption", 300.0),
        Paragraph("key: value\n" * 90, fixed=True),
    ]
    one, other = (document_pdf(blocks, title="t") for _ in range(2))
    assert one == other
    assert one.startswith(b"%PDF")
    assert one.count(b"/Type /Page\n") + one.count(b"/Type /Page ") >= 4
