"""The figures a report shows: drawn by ``plotting``, saved, and described in words."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pivotgait import plotting
from pivotgait.plans.plan import GaitPlan, Phase
from pivotgait.reporting.page import Picture


def draw_figures(plan: GaitPlan, folder: Path) -> dict[str, Picture]:
    """Draw every figure of ``plan`` and save it in ``folder`` as PDF and PNG.

    Returns:
        The pictures by name, as :func:`pivotgait.reporting.write_report` takes them.

    Raises:
        OSError: if the folder cannot be written.
    """
    pictures = dict(_gait_pictures(plan, folder))
    if plan.robot:
        pictures |= _robot_pictures(plan, folder)
    for phase in plan.phases:
        pictures |= _phase_pictures(plan, phase, folder)
    return pictures


def _gait_pictures(plan: GaitPlan, folder: Path) -> Iterator[tuple[str, Picture]]:
    tool, names = plan.tool.name, ", ".join(phase.name for phase in plan.phases)
    narrow = plotting.gait_strip(plan, columns=2, width=plotting.COLUMN_WIDTH)
    what = "The tool and the hand" if plan.robot else "The tool"
    holder = "the hand" if plan.robot else "its fingertips"
    hero = Picture(
        rendering(plotting.gait_strip(plan), folder, "hero"),
        alt=f"The {tool} on the table and {holder}, at the start and after each of {names}.",
        caption=f"{what} at the start and at the end of every phase. Arrows are the forces on "
        "the tool, cones the friction cones they must stay in.",
        narrow=plotting.figure_bytes(narrow, "webp"),
    )
    yield "hero", hero
    overview = Picture(
        drawing(plotting.overview(plan), folder, "overview"),
        alt=f"Normal forces, friction margins and orientation over time through {names}.",
        caption="Normal forces between their bounds, friction margins (a contact slips at 0), "
        "and the motion of the tool.",
    )
    yield "overview", overview


def _robot_pictures(plan: GaitPlan, folder: Path) -> dict[str, Picture]:
    drawings = {
        "joint_positions": (
            plotting.joint_positions,
            "Place of every joint between its lower limit (−1) and its upper one (1).",
        ),
        "joint_speeds": (plotting.joint_speeds, "Speed of every joint over its limit."),
        "joint_torques": (plotting.joint_torques, "Torque or force of every joint over its limit."),
    }
    arm = rendering(plotting.robot_scene(plan), folder, "robot_scene")
    pictures = {
        "robot_scene": Picture(
            arm,
            alt=f"The whole arm with its hand on the {plan.tool.name} at the table.",
            caption="The arm-hand at its table, at the end of the first phase.",
            narrow=arm,
            robot=True,
        )
    }
    for name, (draw, caption) in drawings.items():
        pictures[name] = Picture(
            drawing(draw(plan), folder, name),
            alt=f"{caption} Over time, one panel for arm and wrist and one for each finger.",
            caption=caption,
            robot=True,
        )
    return pictures


def _phase_pictures(plan: GaitPlan, phase: Phase, folder: Path) -> dict[str, Picture]:
    name = phase.name
    pictures = {
        f"{name}_snapshots": Picture(
            rendering(plotting.tool_snapshots(plan, name), folder, f"{name}_snapshots"),
            alt=f"The {plan.tool.name} at the start, the middle and the end of {name}: "
            "whole above, its fingers close up below.",
            caption="Contact forces at the start, the middle and the end of the phase.",
            phase=name,
        ),
        f"{name}_angles": Picture(
            drawing(plotting.angle_to_normal(plan, name), folder, f"{name}_angles"),
            alt=f"Angle of each contact force to its normal over {name}, and its limit.",
            caption="Angles between contact forces and normals; the limit of each is its "
            "friction angle, dashed.",
            phase=name,
        ),
    }
    if phase.finger in phase.contacts:
        figure = plotting.force_in_cone(plan, name, phase.finger)
        pictures[f"{name}_cone"] = Picture(
            drawing(figure, folder, f"{name}_cone"),
            alt=f"Path of the contact force of the {phase.finger} in its friction cone in {name}.",
            caption=f"The force of the {phase.finger}: its size against the cone, and its "
            "direction seen along the normal.",
            phase=name,
        )
    return pictures


def rendering(figure: Any, folder: Path, name: str) -> bytes:
    """Save a picture of the tool; a bitmap of it for the page."""
    plotting.save_figure(figure, folder, name)
    return plotting.figure_bytes(figure, "webp")


def drawing(figure: Any, folder: Path, name: str) -> bytes:
    """Save a line drawing; its vector picture for the page."""
    plotting.save_figure(figure, folder, name)
    return plotting.figure_bytes(figure, "svg")
