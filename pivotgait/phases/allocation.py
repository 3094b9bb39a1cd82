"""From a tool motion and its contacts to the allocation problem of eqs (4)-(6) and (8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pivotgait.dynamics import required_wrench
from pivotgait.forces import Allocation, AllocationProblem, LinearRows, allocate
from pivotgait.models import HandleContact
from pivotgait.phases.grasp import Setting
from pivotgait.plans import PIVOT, ToolMotion

Array = NDArray[np.float64]


def allocation_problem(
    setting: Setting,
    motion: ToolMotion,
    fingers: Sequence[HandleContact],
    *,
    ramp: Mapping[str, Array] | None = None,
    rows: LinearRows | None = None,
) -> AllocationProblem:
    """Which forces of the pivot and the fingers carry the tool along a motion.

    Args:
        setting: tool and table.
        motion: N samples.
        fingers: the fingers in contact.
        ramp: finger name -> (N,) prescribed normal force [N] (eqs 7, 8); its lower bound is 0.
        rows: further rows on the stacked forces, such as joint torque limits.

    Returns:
        The problem in world axes, contacts in the order pivot, fingers.
    """
    scene, ramp = setting.scene, ramp or {}
    samples, turn = len(motion.position), motion.rotation.as_matrix()
    points = np.stack([finger.point for finger in fingers])
    inward = np.stack([finger.normal for finger in fingers])
    lever = np.einsum("nij,mj->nmi", turn, np.vstack((setting.body.pivot_in_tool, points)))
    normals = np.empty_like(lever)
    normals[:, 0] = (0.0, 0.0, 1.0)
    normals[:, 1:] = np.einsum("nij,mj->nmi", turn, inward)
    fixed = np.full((samples, 1 + len(fingers)), np.nan)
    lower = np.tile([scene.table.normal_min, *(f.normal_min for f in fingers)], (samples, 1))
    upper = np.tile([scene.table.normal_max, *(f.normal_max for f in fingers)], (samples, 1))
    for place, finger in enumerate(fingers, start=1):
        if finger.finger in ramp:
            fixed[:, place], lower[:, place] = ramp[finger.finger], 0.0
    return AllocationProblem(
        names=(PIVOT, *(finger.finger for finger in fingers)),
        lever=lever,
        normals=normals,
        friction=setting.usable_friction(fingers),
        normal_min=lower,
        normal_max=upper,
        wrench=required_wrench(setting.body, motion),
        normal_fixed=fixed,
        rows=rows,
        objective=scene.allocation.objective,
    )


def allocate_smoothly(
    problem: AllocationProblem,
    *,
    step_s: float,
    rate_max: float | None,
    start: Array | None = None,
    end: Array | None = None,
) -> Allocation:
    """Allocate along a trajectory: forces join at its ends and keep their rate.

    Solves the samples one by one first: if that answer already keeps the rate and the ends, it
    is the optimum of the coupled problem too, which has only more constraints. Else the whole
    trajectory is solved as one problem.

    Args:
        problem: uncoupled, N samples.
        step_s: time between samples [s].
        rate_max: bound of the change of each contact force [N/s], None for none.
        start: (m, 3) forces at the first sample, world [N].
        end: (m, 3) forces at the last sample, world [N].

    Raises:
        InfeasibleError: no such forces; names the contact and limit that bind.
    """
    coupled = replace(problem, start=start, end=end, force_rate_max=rate_max, step_s=step_s)
    if not coupled.coupled:
        return allocate(problem).require()
    free = allocate(problem)
    if free.feasible.all() and _joins(free.force, coupled):
        return free
    return allocate(coupled).require()


def _joins(force: Array, coupled: AllocationProblem) -> bool:
    close = 1e-9  # [N]: a hundredth of the tightest tolerance of the certificate
    jumps = [
        np.abs(force[place] - wanted).max() <= close
        for place, wanted in ((0, coupled.start), (-1, coupled.end))
        if wanted is not None
    ]
    if coupled.force_rate_max is not None and coupled.step_s is not None:
        change = np.linalg.norm(np.diff(force, axis=0), axis=-1)
        jumps.append(bool(change.max(initial=0.0) <= coupled.force_rate_max * coupled.step_s))
    return all(jumps)
