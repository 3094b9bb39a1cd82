"""The path of a contact force inside its friction cone (as Xue et al., Fig. 4a)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame
from pivotgait.exceptions import UnknownNameError
from pivotgait.margins.gait import LEAST_FORCE_N
from pivotgait.plans.plan import ContactTrack, GaitPlan, Phase
from pivotgait.plotting.style import (
    LIMIT_COLOUR,
    PAGE_WIDTH,
    contact_colours,
    new_figure,
    styled,
)
from pivotgait.plotting.timeline import find_phase, phase_title

Array = NDArray[np.float64]


@styled
def force_in_cone(plan: GaitPlan, phase: str, contact: str) -> Any:
    """A contact's force over a phase: its size inside the cone, and its direction seen end-on.

    Left, tangential against normal force with the cone as a wedge; right, the tangential force
    divided by its limit ``mu f_n``, which the cone holds inside the unit circle.

    Args:
        plan: a gait.
        phase: the phase's name in ``plan``.
        contact: ``"pivot"`` or a finger that touches in that phase.

    Returns:
        A matplotlib ``Figure`` of page width.

    Raises:
        UnknownNameError: if there is no such phase or contact.
    """
    shown = find_phase(plan, phase)
    if contact not in shown.contacts:
        raise UnknownNameError("contact", contact, shown.contacts, where=phase)
    track = shown.contacts[contact]
    colour = contact_colours(plan)[contact]
    figure = new_figure(PAGE_WIDTH, 3.0)
    side, end = figure.subplots(1, 2)
    local = _in_contact_frame(track, shown)
    _draw_wedge(side, local, track.friction, colour)
    _draw_disc(end, local, track.friction, colour)
    figure.suptitle(f"{contact} during {phase_title(shown)}", fontsize=8, fontweight="bold")
    return figure


def _in_contact_frame(track: ContactTrack, phase: Phase) -> Array:
    """(N, 3) force [N] as two tangential components and the normal one, on the surface's axes."""
    force = track.force
    if not track.is_pivot:
        force = np.einsum("nji,nj->ni", phase.tool.rotation.as_matrix(), force)
    return np.asarray(force @ contact_frame(track.normal))


def _draw_wedge(axes: Any, local: Array, friction: float, colour: str) -> None:
    normal, tangential = local[:, 2], np.linalg.norm(local[:, :2], axis=1)
    top = 1.15 * max(float(normal.max()), LEAST_FORCE_N)
    wedge = [[0.0, 0.0], [friction * top, top], [0.0, top]]
    axes.add_patch(Polygon(wedge, facecolor=colour, alpha=0.13, lw=0))
    axes.plot([0.0, friction * top], [0.0, top], color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    axes.annotate(
        f"limit, μ = {friction:g}",
        (friction * top * 0.82, top * 0.82),
        xytext=(5, -2),
        textcoords="offset points",
        ha="left",
        va="top",
        fontsize=7,
        color=LIMIT_COLOUR,
    )
    _draw_path(axes, tangential, normal, colour, reach=top)
    axes.set_xlim(0.0, 1.45 * friction * top)
    axes.set_ylim(0.0, top)
    axes.set_xlabel("tangential force [N]")
    axes.set_ylabel("normal force [N]")


def _draw_disc(axes: Any, local: Array, friction: float, colour: str) -> None:
    loaded = local[:, 2] > LEAST_FORCE_N
    share = local[loaded, :2] / (friction * local[loaded, 2:])
    axes.add_patch(Circle((0.0, 0.0), 1.0, facecolor=colour, alpha=0.13, lw=0))
    axes.add_patch(
        Circle((0.0, 0.0), 1.0, fill=False, edgecolor=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    )
    axes.annotate("limit", (0.72, 0.72), fontsize=7, color=LIMIT_COLOUR)
    if loaded.any():
        _draw_path(axes, share[:, 0], share[:, 1], colour, reach=1.0)
    reach = 1.1 * max(1.0, float(np.abs(share).max(initial=0.0)))
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel("tangential x / (μ normal) [-]")
    axes.set_ylabel("tangential y / (μ normal) [-]")


def _draw_path(axes: Any, x: Array, y: Array, colour: str, *, reach: float) -> None:
    """A path with its ends named: together if they lie within a few percent of ``reach``."""
    axes.plot(x, y, color=colour, zorder=3)
    axes.plot(x[0], y[0], "o", color="white", mec=colour, ms=5, zorder=4, clip_on=False)
    axes.plot(x[-1], y[-1], "o", color=colour, ms=5, zorder=4, clip_on=False)
    apart = float(np.hypot(x[-1] - x[0], y[-1] - y[0])) / reach
    # ends that are close have their names above and below, else the names would cover each other
    up, down = (8, -8) if apart < 0.25 else (4, 4)
    start, end = (up, down) if y[0] >= y[-1] else (down, up)
    names = [("start, end", -1, 4)] if apart < 0.1 else [("start", 0, start), ("end", -1, end)]
    for word, place, rise in names:
        axes.annotate(
            word,
            (x[place], y[place]),
            xytext=(6, rise),
            textcoords="offset points",
            va="center",
            fontsize=7,
            color=colour,
            annotation_clip=False,
        )
