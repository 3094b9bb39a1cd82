"""The tool with its contacts and forces at moments of a phase (as Xue et al., Fig. 3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.names import Naming, name_contacts, scale_bars
from pivotgait.plotting.picture import Look, Moment, draw_moment, frame, look_at
from pivotgait.plotting.style import PAGE_WIDTH, new_figure, styled
from pivotgait.plotting.timeline import find_phase, phase_title, spans


@styled
def tool_snapshots(plan: GaitPlan, phase: str) -> Any:
    """The tool at the start, the middle and the end of a phase, whole and close up.

    Arrows show the forces on the tool and end at the contact they push on; translucent cones
    are the friction cones they must stay in. All pictures of a row share one scale.

    Args:
        plan: a gait.
        phase: the phase's name in ``plan``.

    Returns:
        A matplotlib ``Figure`` of page width.

    Raises:
        UnknownNameError: if ``plan`` has no such phase.
    """
    shown = find_phase(plan, phase)
    last = len(shown.time) - 1
    moments = [Moment(shown, sample) for sample in (0, last // 2, last)]
    words = ("start", "middle", "end")
    titles = [f"{word}, {m.time:.2f} s" for word, m in zip(words, moments, strict=True)]
    look = look_at(plan, moments)
    whole, close = frame(look, moments, close=False), frame(look, moments, close=True)
    heights = [_height(box, PAGE_WIDTH / 3) for box in (whole, close)]
    figure = new_figure(PAGE_WIDTH, sum(heights) + 0.5)
    axes = figure.subplots(2, 3, height_ratios=heights)
    _draw_row(axes[0], look, moments, whole, names="names")
    _draw_row(axes[1], look, moments, close, names="forces")
    for row in axes:
        scale_bars(row[0], look)
    for panel, title in zip(axes[0], titles, strict=True):
        panel.set_title(title)
    figure.suptitle(phase_title(shown), fontsize=8, fontweight="bold")
    return figure


@styled
def gait_strip(plan: GaitPlan, *, columns: int = 4, width: float = PAGE_WIDTH) -> Any:
    """The gait at a glance: tool and hand at the start and at the end of every phase.

    A plan without a robot shows its fingertips only (as Xue et al., Fig. 6, with a hand).

    Args:
        plan: a gait.
        columns: most pictures beside each other.
        width: of the figure [in].

    Returns:
        A matplotlib ``Figure``.
    """
    timeline = spans(plan)
    moments = [Moment(timeline[0].phase, 0)]
    moments += [Moment(span.phase, len(span.phase.time) - 1) for span in timeline]
    titles = ["start"] + [f"{phase_title(s.phase)}\n{s.end:.2f} s" for s in timeline]
    return draw_strip(plan, moments, titles, columns=columns, width=width)


def draw_strip(
    plan: GaitPlan, moments: Sequence[Moment], titles: Sequence[str], *, columns: int, width: float
) -> Any:
    """Moments in rows of at most ``columns`` pictures, each with its title; all share one scale.

    Returns:
        A matplotlib ``Figure``, ``width`` [in] wide.
    """
    rows = -(-len(moments) // columns)
    columns = -(-len(moments) // rows)
    look = look_at(plan, moments, hand=True)
    box = frame(look, moments, close=False)
    figure = new_figure(width, rows * (_height(box, width / columns) + 0.35) + 0.1)
    panels = list(figure.subplots(rows, columns, squeeze=False).ravel())
    _draw_row(panels[: len(moments)], look, moments, box, names="names")
    for panel, title in zip(panels, titles, strict=False):
        panel.set_title(title)
    scale_bars(panels[(rows - 1) * columns], look)
    for panel in panels[len(moments) :]:
        panel.set_axis_off()
    return figure


def _height(box: Any, width: float) -> float:
    """Height [in] of a picture of ``box`` that is ``width`` [in] wide."""
    (left, low), (right, high) = box
    return float(width * (high - low) / (right - left))


def _draw_row(
    panels: Sequence[Any], look: Look, moments: Sequence[Moment], box: Any, *, names: Naming
) -> None:
    for panel, moment in zip(panels, moments, strict=True):
        panel.set_xlim(box[:, 0])
        panel.set_ylim(box[:, 1])
        draw_moment(panel, look, moment)
        name_contacts(panel, look, moment, names)
