"""Figures as files and bytes, the same bytes for the same figure."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from pivotgait.plotting.style import styled

PRINT_DPI, SCREEN_DPI = 300, 150
"""Of bitmaps, unless told otherwise."""


@dataclass(frozen=True)
class SavedFigure:
    """Where the files of a figure are.

    Attributes:
        pdf: vector file for a paper, fonts embedded.
        png: bitmap file for the web.
    """

    pdf: Path
    png: Path


def save_figure(figure: Any, folder: Path, name: str) -> SavedFigure:
    """Write ``name.pdf`` and ``name.png`` into ``folder`` (made if missing), return their paths.

    No time stamp enters the files: equal figures give equal bytes.

    Raises:
        OSError: if the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    pdf, png = folder / f"{name}.pdf", folder / f"{name}.png"
    pdf.write_bytes(figure_bytes(figure, "pdf"))
    png.write_bytes(figure_bytes(figure, "png"))
    return SavedFigure(pdf, png)


@styled
def figure_bytes(figure: Any, form: str, *, dpi: float | None = None) -> bytes:
    """``figure`` as the bytes of a ``pdf``, ``png``, ``svg`` or ``webp`` file without time stamp.

    ``dpi`` is that of bitmaps, also of those inside a vector picture: by default print quality,
    but a screen's for the two forms of the web.
    """
    options: dict[str, dict[str, Any]] = {
        "pdf": {"metadata": {"CreationDate": None, "ModDate": None}},
        "png": {"metadata": {"Software": None}},
        "svg": {"metadata": {"Date": None}},
        "webp": {"pil_kwargs": {"quality": 85, "method": 6}},
    }
    usual = SCREEN_DPI if form in ("svg", "webp") else PRINT_DPI
    target = BytesIO()
    figure.savefig(target, format=form, dpi=dpi or usual, **options[form])
    return target.getvalue()
