"""Direct labels: a line's name at its end instead of a legend over the data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class EndLabel(NamedTuple):
    """Text to put beside ``height`` (data units) at the right edge of a panel."""

    text: str
    height: float
    colour: str


def label_right(axes: Any, labels: Sequence[EndLabel], *, gap: float = 0.12) -> None:
    """Write ``labels`` right of ``axes``, moved apart until none covers another.

    Args:
        axes: whose y limits are final.
        labels: in any order.
        gap: least distance between two labels [in].
    """
    low, high = axes.get_ylim()
    inches = axes.get_position().height * axes.figure.get_figheight()
    step = gap / inches
    order = sorted(range(len(labels)), key=lambda i: labels[i].height)
    wanted = np.array([(labels[i].height - low) / (high - low) for i in order])
    placed = spread(np.clip(wanted, 0.0, 1.0), step)
    for i, height in zip(order, placed, strict=True):
        axes.annotate(
            labels[i].text,
            (1.0, height),
            xycoords="axes fraction",
            xytext=(4, 0),
            textcoords="offset points",
            ha="left",
            va="center",
            fontsize=7,
            color=labels[i].colour,
            annotation_clip=False,
        )


def spread(heights: ArrayLike, step: float, low: float = 0.0, high: float = 1.0) -> Array:
    """Move sorted ``heights`` (n,) at least ``step`` apart, within ``low`` to ``high`` if they fit.

    Heights that crowd form a cluster centred on where its members wanted to be.
    """
    clusters: list[tuple[float, int]] = []
    for height in np.asarray(heights, dtype=float):
        centre, count = float(height), 1
        while clusters and centre - clusters[-1][0] < step * (count + clusters[-1][1]) / 2:
            other, size = clusters.pop()
            centre, count = (centre * count + other * size) / (count + size), count + size
            half = step * (count - 1) / 2
            fits = 2 * half < high - low
            centre = min(max(centre, low + half), high - half) if fits else (low + high) / 2
        clusters.append((centre, count))
    placed = [centre + step * (np.arange(count) - (count - 1) / 2) for centre, count in clusters]
    return np.concatenate(placed or [np.empty(0)])
