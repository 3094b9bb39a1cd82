"""A document of headings, paragraphs, tables and pictures as PDF pages."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imread

from pivotgait.plotting.style import styled

WIDTH_IN, HEIGHT_IN, MARGIN_IN = 8.27, 11.69, 0.9
"""A4 [in]."""
_POINT = 1.0 / 72.0
_ROOM = WIDTH_IN - 2.0 * MARGIN_IN
_LETTER, _GAP = 0.58, 2
"""Mean width of a letter over its size, with room to spare; letters between columns."""
_TABLE_SIZE, _SMALL_SIZE = 8.0, 6.5
_NARROW = 24
"""Letters to which columns are broken before the print shrinks."""
_BELOW, _ABOVE = 60.0 * _POINT, 100.0 * _POINT
"""Room for a picture's caption, and for a heading with a short text above one."""


@dataclass(frozen=True)
class Heading:
    """A line of larger print; level 1 is the title."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Paragraph:
    """Text that is broken into lines; ``fixed`` keeps its own lines, in typewriter print."""

    text: str
    fixed: bool = False


@dataclass(frozen=True)
class TableBlock:
    """A table; the first column is left aligned, the others right."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class PictureBlock:
    """A bitmap (PNG) with its caption, made smaller where it has no room on a page.

    Attributes:
        png: the file's bytes.
        caption: below it.
        dpi: pixels of an inch.
    """

    png: bytes
    caption: str
    dpi: float


Block = Heading | Paragraph | TableBlock | PictureBlock


@styled
def document_pdf(blocks: Sequence[Block], *, title: str) -> bytes:
    """The document as the bytes of a PDF file with embedded fonts and no time stamp."""
    target = BytesIO()
    metadata = {"Title": title, "CreationDate": None, "ModDate": None}
    with PdfPages(target, metadata=metadata) as pages:
        paper = _Paper(pages)
        for place, block in enumerate(blocks):
            paper.put(block, _with_it(blocks[place + 1 : place + 3]))
        paper.turn()
    return target.getvalue()


class _Paper:
    """A page that is being filled from above."""

    def __init__(self, pages: Any) -> None:
        self._pages, self._number = pages, 0
        self._start()

    def put(self, block: Block, keep: float = 0.0) -> None:
        """Add a block below the last one, on a new page where it has no room.

        Args:
            block: to be added.
            keep: height that a heading shares its page with [in].
        """
        if isinstance(block, Heading):
            size = 16.0 if block.level == 1 else 11.0
            self._space(9.0 * (self._at > MARGIN_IN))
            self._lines(block.text, size, weight="bold", keep=max(60.0, keep / _POINT))
        elif isinstance(block, Paragraph):
            self._lines(block.text, 7.0 if block.fixed else 9.0, fixed=block.fixed)
        elif isinstance(block, TableBlock):
            self._table(block)
        else:
            self._picture(block)
        self._space(5.0)

    def turn(self) -> None:
        """Write the page and begin another."""
        self._text(WIDTH_IN / 2.0, HEIGHT_IN - 0.5, str(self._number), 8.0, ha="center")
        self._pages.savefig(self._figure)
        self._start()

    def _start(self) -> None:
        self._number += 1
        self._figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN))
        self._at = MARGIN_IN

    def _space(self, points: float) -> None:
        self._at += points * _POINT

    def _need(self, inches: float) -> None:
        if self._at + inches > HEIGHT_IN - MARGIN_IN:
            self.turn()

    def _text(self, x: float, y: float, text: str, size: float, **more: Any) -> None:
        # a $ is no mathematics here
        shown = text.replace("$", r"\$")
        at = x / WIDTH_IN, 1.0 - y / HEIGHT_IN
        self._figure.text(*at, shown, fontsize=size, va="top", **more)

    def _lines(
        self,
        text: str,
        size: float,
        *,
        fixed: bool = False,
        weight: str = "normal",
        keep: float = 0.0,
    ) -> None:
        # a mean width of a letter, and room to spare
        across = int(_ROOM / (size * _POINT * (0.61 if fixed or weight == "bold" else 0.54)))
        family = "DejaVu Sans Mono" if fixed else "DejaVu Sans"
        lines = [
            part for line in text.splitlines() for part in (textwrap.wrap(line, across) or [""])
        ]
        for k, line in enumerate(lines):
            self._need(1.35 * size * _POINT + (keep * _POINT if k == 0 else 0.0))
            self._text(MARGIN_IN, self._at, line, size, weight=weight, family=family)
            self._space(1.35 * size)

    def _table(self, table: TableBlock) -> None:
        every = (table.head, *table.rows)
        widths, size = _columns(every)
        for k, row in enumerate(every):
            # a no-break space is for a narrow screen
            cells = [
                textwrap.wrap(cell.replace("\N{NO-BREAK SPACE}", " "), width) or [""]
                for cell, width in zip(row, widths, strict=True)
            ]
            lines = max(map(len, cells))
            self._need((1.25 * lines + 0.35) * size * _POINT)
            left, top = MARGIN_IN, self._at
            for place, (cell, width) in enumerate(zip(cells, widths, strict=True)):
                span = (width + _GAP) * _LETTER * size * _POINT
                look: dict[str, Any] = {"weight": "bold" if k == 0 else "normal"}
                look |= {"ha": "right" if place else "left"}
                x = left + span - _LETTER * size * _POINT if place else left
                for line, text in enumerate(cell):
                    self._text(x, top + 1.25 * line * size * _POINT, text, size, **look)
                left += span
            self._space((1.25 * lines + 0.35) * size)

    def _picture(self, block: PictureBlock) -> None:
        image = imread(BytesIO(block.png))
        width, height = _size(image, block.dpi)
        self._need(height + _BELOW)
        corner = (WIDTH_IN - width) / 2.0 / WIDTH_IN, 1.0 - (self._at + height) / HEIGHT_IN
        axes = self._figure.add_axes((*corner, width / WIDTH_IN, height / HEIGHT_IN))
        axes.imshow(image, interpolation="none", aspect="auto")
        axes.set_axis_off()
        self._at += height
        self._space(4.0)
        self._lines(block.caption, 8.0)


def _with_it(following: Sequence[Block]) -> float:
    """Height of the picture that follows, at once or after a paragraph [in]; else 0."""
    for block in following:
        if isinstance(block, PictureBlock):
            return _size(imread(BytesIO(block.png)), block.dpi)[1] + _BELOW
        if not isinstance(block, Paragraph):
            break
    return 0.0


def _size(image: Any, dpi: float) -> tuple[float, float]:
    """Width and height of a picture that a page has room for, under a heading [in]."""
    across, tall = image.shape[1] / dpi, image.shape[0] / dpi
    room = HEIGHT_IN - 2.0 * MARGIN_IN - _BELOW - _ABOVE
    shrunk = min(1.0, _ROOM / across, room / tall)
    return shrunk * across, shrunk * tall


def _columns(rows: Sequence[tuple[str, ...]]) -> tuple[list[int], float]:
    """Letters of each column, and the print's size: wide columns are broken, then print shrinks."""
    widths = [max(1, *(len(row[k]) for row in rows)) for k in range(len(rows[0]))]
    for narrow, size in ((_NARROW, _TABLE_SIZE), (_NARROW, _SMALL_SIZE), (1, _SMALL_SIZE)):
        room = int(_ROOM / (_LETTER * size * _POINT)) - _GAP * len(widths)
        fitted = list(widths)
        while sum(fitted) > room and max(fitted) > narrow:
            fitted[fitted.index(max(fitted))] -= 1
        if sum(fitted) <= room:
            break
    return fitted, size
