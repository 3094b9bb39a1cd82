"""Names beside the contacts of a picture, and its scale bars."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from pivotgait.plans.plan import ContactTrack
from pivotgait.plotting.labels import spread
from pivotgait.plotting.picture import LONGEST_ARROW, TIP_RADIUS, Look, Moment, arrow_ends

Array = NDArray[np.float64]
Naming = Literal["names", "forces"]
"""Whether contacts are named only or their forces told too."""
_LINE_INCH = 0.115
_HALO = withStroke(linewidth=2.0, foreground="#FFFFFFD0")  # names may lie on a dark grip


class _Name(NamedTuple):
    text: str
    side: str
    anchor: Array
    colour: str


def name_contacts(axes: Any, look: Look, moment: Moment, naming: Naming) -> None:
    """Name the contacts of ``moment``: fingers beyond their arrows, the pivot under its point.

    Names on one side of the tool are moved apart until none covers another. The limits of
    ``axes`` are final.
    """
    tracks = moment.phase.contacts.values()
    names = [_name(look, moment, track, naming) for track in tracks]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    inches = axes.get_position().width * axes.figure.get_figwidth()
    step = _LINE_INCH * (right - left) / inches * (2 if naming == "forces" else 1)
    for side in ("left", "right", "center"):
        group = sorted((n for n in names if n.side == side), key=lambda n: float(n.anchor[1]))
        heights = spread([n.anchor[1] for n in group], step, low + step, high - step / 2)
        for name, height in zip(group, heights, strict=True):
            axes.annotate(
                name.text,
                (name.anchor[0], height),
                ha=name.side,
                va="center",
                xytext=({"left": 4, "right": -4}.get(name.side, 0), 0),
                textcoords="offset points",
                fontsize=7,
                linespacing=0.95,
                color=name.colour,
                zorder=6,
                path_effects=[_HALO],
            )


def _name(look: Look, moment: Moment, track: ContactTrack, naming: Naming) -> _Name:
    point, normal, force = moment.contact(track)
    tail, _ = arrow_ends(look, moment, track)
    text, colour = track.name, look.colours[track.name]
    if naming == "forces":
        text += f"\n{np.linalg.norm(force):.1f} N"
    if track.is_pivot:
        under = look.camera.project(point)[:2] - np.array([0.0, 2 * TIP_RADIUS])
        return _Name(text, "center", under, colour)
    outside = point - 2 * look.tip_radius[track.name] * normal
    outer = max(tail, outside, key=lambda end: float(np.linalg.norm(end - point)))
    start, anchor = look.camera.project(np.stack((point, outer)))[:, :2]
    return _Name(text, "left" if anchor[0] >= start[0] else "right", anchor, colour)


def scale_bars(axes: Any, look: Look) -> None:
    """Bars of a round force [N] and a round length [mm] under the picture."""
    newtons = _round_down(0.4 * LONGEST_ARROW / look.metres_per_newton)
    bars = ((newtons * look.metres_per_newton, f"{newtons:g} N"), (0.03, "30 mm"))
    (left, right), (low, _) = axes.get_xlim(), axes.get_ylim()
    height = low - 0.05 * (right - left)
    for start, (length, text) in zip((left, (left + right) / 2), bars, strict=True):
        ends = [start, start + length]
        axes.plot(ends, [height, height], color="#222222", lw=1.5, clip_on=False)
        axes.annotate(
            text,
            (ends[1], height),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
            annotation_clip=False,
        )


def _round_down(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))
