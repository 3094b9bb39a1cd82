"""The whole certificate: every check on every phase."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from pivotgait.certification.certificate import Certificate, Finding, judge
from pivotgait.certification.clearance import check_clearance
from pivotgait.certification.forces import check_cones, check_dynamics, check_ramp
from pivotgait.certification.limits import Limit
from pivotgait.certification.motion import check_motion, check_pivot
from pivotgait.certification.robot import check_robot
from pivotgait.certification.sampling import check_sampling
from pivotgait.certification.scene_limits import scene_limits
from pivotgait.certification.seams import check_seams
from pivotgait.certification.solid import check_tool, rigid_tool
from pivotgait.certification.surface import check_surface
from pivotgait.certification.transfer import check_transfer
from pivotgait.plans import GaitPlan, check_plan, read_plan


def certify(
    plan: GaitPlan | Path | str, *, limits: Mapping[str, Limit] | None = None
) -> Certificate:
    """Recompute from a plan alone whether it keeps the laws it claims to keep.

    Args:
        plan: a plan, or the path of a plan file.
        limits: by which to judge; without them :data:`LIMITS`, with the clearance that the
            plan's scene asks for.

    Returns:
        The certificate; a plan that breaks limits gets one too, with its violations.

    Raises:
        PlanFileError: if the file or the plan cannot be computed with at all.
        UrdfError: if the tool's or the robot's URDF text cannot be.
        SceneError: if the scene's text is not YAML or its clearance not a distance.
    """
    if isinstance(plan, GaitPlan):
        check_plan(plan)
    else:
        plan = read_plan(plan)
    limits = scene_limits(plan.scene) if limits is None else limits
    return judge(_findings(plan, limits["hand_clearance_m"].bound), limits)


def _findings(plan: GaitPlan, clearance: float) -> Iterator[Finding]:
    rigid = rigid_tool(plan.tool)
    yield from check_tool(plan.tool, rigid)
    for phase in plan.phases:
        yield from check_motion(plan, phase)
        yield from check_pivot(plan, phase, rigid.tip_radius)
        if phase.kind == "transfer":
            yield from check_transfer(plan, phase, rigid.tip_radius)
        yield from check_sampling(phase)
        yield from check_dynamics(plan, phase)
        yield from check_cones(phase)
        yield from check_ramp(phase)
        yield from check_surface(rigid, phase)
        yield from check_clearance(plan, phase, rigid)
    yield from check_seams(plan)
    if plan.robot is not None:
        yield from check_robot(plan, plan.robot, rigid, clearance)
