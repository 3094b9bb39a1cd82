"""Forces anew for a tool that is measured elsewhere than planned."""

from __future__ import annotations

import numpy as np

from pivotgait.contacts import friction_margin
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant, Reference
from pivotgait.forces import AllocationProblem, allocate
from pivotgait.frozen import Array
from pivotgait.plans import PIVOT


class Reallocation:
    """Contact forces that carry the measured tool farther from their cones than the planned ones.

    Fingers may press harder, but need not: two that do not oppose each other lose margin by it.

    Attributes:
        reference: the plan.
        squeeze: largest normal force of a finger over its planned one, up to the plan's bound.
    """

    def __init__(self, reference: Reference, squeeze: float) -> None:
        """Allocations for the phases of a plan."""
        self.reference, self.squeeze = reference, squeeze

    def forces(self, task: PhaseTask, wanted: Instant, rotation: Array) -> Array | None:
        """(m, 3) forces of the phase's holds on the tool, **tool axes** [N].

        Args:
            task: of the phase.
            wanted: the plan now, whose motion the forces carry out.
            rotation: (3, 3) measured, world <- tool.

        Returns:
            None where none are found with a larger least friction margin than the planned forces
            have, in a transfer (fingertips would need torsion) and without holding fingers.
        """
        if not task.finger_names or task.reference.samples.kind == "transfer":
            return None
        found = allocate(self.problem(task, wanted, rotation), "clarabel")
        if not found.feasible[0]:
            return None
        forces = np.asarray(found.force[0, 1:].dot(rotation))
        better = least_margin(task, forces) > least_margin(task, wanted.force_in_tool)
        return forces if better else None

    def problem(self, task: PhaseTask, wanted: Instant, rotation: Array) -> AllocationProblem:
        """One sample in world axes: the pivot, then the holds; least |f_t|^2 / f_n (eqs 3, 5-8).

        A finger that comes or goes keeps its planned normal force.
        """
        samples, tool = task.reference.samples, self.reference.plan.tool
        pivot = samples.contacts[PIVOT]
        tracks = [samples.contacts[name] for name in task.finger_names]
        planned = np.einsum("ki,ki->k", wanted.force_in_tool, task.normals_in_tool)
        high = np.array([track.normal_max for track in tracks])
        comes_or_goes = np.array([track.normal_min <= 0.0 for track in tracks])
        comes_or_goes |= np.array([name == samples.finger for name in task.finger_names])
        planned = np.clip(planned, 0.0, high)
        low = np.array([track.normal_min for track in tracks])
        low = np.where(comes_or_goes, 0.0, np.minimum(low, planned))
        # The objective alone would press as hard as the bounds allow.
        most = np.where(comes_or_goes, high, np.minimum(self.squeeze * planned, high))
        fixed = np.where(comes_or_goes, planned, np.nan)
        points = np.vstack((tool.pivot_in_tool, task.contacts_in_tool))
        normals = np.vstack((pivot.normal, task.normals_in_tool.dot(rotation.T)))
        return AllocationProblem(
            names=(PIVOT, *task.finger_names),
            lever=points.dot(rotation.T)[None],
            normals=normals[None],
            friction=np.array([pivot.friction, *(track.friction for track in tracks)]),
            normal_min=np.array([[pivot.normal_min, *low]]),
            normal_max=np.array([[pivot.normal_max, *most]]),
            wrench=self._wrench(wanted, rotation)[None],
            normal_fixed=np.array([[np.nan, *fixed]]),
            objective="tangential",
        )

    def _wrench(self, wanted: Instant, rotation: Array) -> Array:
        """(6,) that the planned motion asks for (eq. 3): force [N], moment about o [N m]."""
        plan, moving = self.reference.plan, wanted.tool
        inertia = rotation.dot(plan.tool.inertia).dot(rotation.T)
        omega = moving.angular_velocity
        force = plan.tool.mass * (moving.linear_acceleration - plan.gravity)
        moment = inertia @ moving.angular_acceleration + np.cross(omega, inertia @ omega)
        return np.concatenate((force, moment))


def least_margin(task: PhaseTask, forces: Array) -> float:
    """The least 1 - |f_t| / (mu f_n) of the fingers that hold all through a phase.

    Args:
        task: of the phase.
        forces: (m, 3) of its holds, tool axes [N].
    """
    samples = task.reference.samples
    staying = [k for k, name in enumerate(task.finger_names) if name != samples.finger]
    friction = np.array([samples.contacts[task.finger_names[k]].friction for k in staying])
    margins = friction_margin(forces[staying], task.normals_in_tool[staying], friction)
    return float(np.nan_to_num(margins, nan=-1.0).min(initial=1.0))
