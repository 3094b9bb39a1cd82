import re

import pytest

from pivotgait.plotting import angle_to_normal, figure_bytes, save_figure, tool_snapshots

LIFT = "00_lift"


@pytest.mark.parametrize("form", ["pdf", "png", "svg", "webp"])
def test_equal_figures_give_equal_bytes(form, plan):
    first, second = (figure_bytes(angle_to_normal(plan, LIFT), form) for _ in range(2))
    assert first == second


def test_drawings_with_bitmaps_are_deterministic_too(plan):
    first, second = (figure_bytes(tool_snapshots(plan, LIFT), "pdf") for _ in range(2))
    assert first == second


def test_no_time_stamp(plan):
    for form in ("pdf", "svg", "png"):
        data = figure_bytes(angle_to_normal(plan, LIFT), form)
        assert b"CreationDate" not in data
        assert b"<dc:date>" not in data


def test_pdf_embeds_its_fonts(plan):
    data = figure_bytes(angle_to_normal(plan, LIFT), "pdf")
    assert b"/FontFile2" in data
    assert b"/Subtype /Type3" not in data


def test_files_lie_in_the_folder(plan, tmp_path):
    saved = save_figure(angle_to_normal(plan, LIFT), tmp_path / "new" / "figures", "angles")
    assert saved.pdf.read_bytes().startswith(b"%PDF")
    assert saved.png.read_bytes().startswith(b"\x89PNG")
    assert saved.pdf.name == "angles.pdf"
    # 3.5 in at 300 dpi
    assert int.from_bytes(saved.png.read_bytes()[16:20], "big") == 1050


def test_svg_needs_no_font_and_no_network(plan):
    text = figure_bytes(angle_to_normal(plan, LIFT), "svg").decode()
    assert "<text" not in text
    assert not re.search(r'(?:xlink:)?href="(?!#|data:)', text)
