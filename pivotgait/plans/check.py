"""What must hold of a plan before anybody may compute with it.

These are rules of form (shapes, finite numbers, order, signs). Whether the plan obeys mechanics is
the business of the certificate.
"""

from __future__ import annotations

import numpy as np

from pivotgait.exceptions import PlanFileError
from pivotgait.plans.check_robot import check_robot
from pivotgait.plans.check_values import check_array, check_finite
from pivotgait.plans.layout import (
    MAX_CONTACTS,
    MAX_PHASES,
    MAX_SAMPLES,
    MOTION,
    is_contact_name,
    phase_name,
)
from pivotgait.plans.plan import PHASE_KINDS, PIVOT, ContactTrack, GaitPlan, Phase, PlannedTool

UNIT_TOLERANCE = 1e-3
"""A quaternion farther from unit length than this is not an orientation at all."""


def check_plan(plan: GaitPlan, *, where: str = "plan") -> None:
    """Refuse a plan whose values cannot be meant.

    Args:
        plan: any plan, read or made in memory.
        where: name of the plan in messages.

    Raises:
        PlanFileError: naming the field, the value and the way to mend it.
    """
    check_array(plan.gravity, (3,), f"{where}: gravity")
    check_finite(plan.table_height, f"{where}: table height")
    if not 0 <= plan.seed < 2**63:
        raise PlanFileError(f"seed {plan.seed} is out of range", where=where, mend="0 to 2^63 - 1")
    if not all(isinstance(text, str) for pair in plan.versions.items() for text in pair):
        raise PlanFileError("versions must map names to texts", where=where, mend="use str")
    _check_tool(plan.tool, f"{where}: tool")
    if not 1 <= len(plan.phases) <= MAX_PHASES:
        raise PlanFileError(
            f"has {len(plan.phases)} phases", where=where, mend=f"1 to {MAX_PHASES} are allowed"
        )
    for place, phase in enumerate(plan.phases):
        _check_phase(phase, place, f"{where}: phase {phase.name}")
    check_robot(plan, where)


def _check_tool(tool: PlannedTool, where: str) -> None:
    check_finite(tool.mass, f"{where} mass")
    if not tool.mass > 0.0:
        raise PlanFileError(f"mass is {tool.mass:g} kg", where=where, mend="it must be positive")
    check_array(tool.inertia, (3, 3), f"{where} inertia")
    check_array(tool.pivot_in_tool, (3,), f"{where} pivot_in_tool")
    check_array(tool.centre_of_mass_in_root, (3,), f"{where} centre_of_mass_in_root")


def _check_phase(phase: Phase, place: int, where: str) -> None:
    if phase.kind not in PHASE_KINDS:
        raise PlanFileError(
            f"unknown kind {phase.kind!r}", where=where, mend=f"one of {', '.join(PHASE_KINDS)}"
        )
    expected = phase_name(place, phase.kind)
    if phase.name != expected:
        raise PlanFileError("name does not tell its place", where=where, mend=f"use {expected}")
    count = phase.time.size
    if not 2 <= count <= MAX_SAMPLES:
        raise PlanFileError(
            f"has {count} samples", where=where, mend=f"2 to {MAX_SAMPLES} are allowed"
        )
    check_array(phase.time, (count,), f"{where}: time")
    if phase.time[0] != 0.0 or not np.all(np.diff(phase.time) > 0.0):
        raise PlanFileError("time does not start at 0 s and increase", where=where, mend="sort it")
    for name in MOTION:
        width = 4 if name == "orientation" else 3
        check_array(getattr(phase.tool, name), (count, width), f"{where}: tool/{name}")
    stretch = float(np.max(np.abs(np.linalg.norm(phase.tool.orientation, axis=1) - 1.0)))
    if stretch > UNIT_TOLERANCE:
        raise PlanFileError(
            f"tool/orientation is {stretch:g} away from unit length", where=where, mend="normalise"
        )
    _check_contacts(phase, count, where)


def _check_contacts(phase: Phase, count: int, where: str) -> None:
    if PIVOT not in phase.contacts:
        raise PlanFileError(f"contact {PIVOT!r} is missing", where=where, mend="add it")
    if len(phase.contacts) > MAX_CONTACTS:
        raise PlanFileError(
            f"has {len(phase.contacts)} contacts", where=where, mend=f"at most {MAX_CONTACTS}"
        )
    changing = phase.kind in ("removal", "addition")
    if changing and (phase.finger == PIVOT or phase.finger not in phase.contacts):
        listed = ", ".join(name for name in phase.contacts if name != PIVOT)
        raise PlanFileError(
            f"finger {phase.finger!r} is not among its contacts", where=where, mend=f"has: {listed}"
        )
    for name, contact in phase.contacts.items():
        _check_contact(name, contact, count, f"{where}: contact {name}")


def _check_contact(name: str, contact: ContactTrack, count: int, where: str) -> None:
    if contact.name != name or not is_contact_name(name):
        raise PlanFileError(f"name {contact.name!r} cannot be used", where=where, mend="rename it")
    check_array(contact.point, (3,), f"{where} point")
    check_array(contact.normal, (3,), f"{where} normal")
    check_array(contact.force, (count, 3), f"{where} force")
    if contact.moment is not None:
        check_array(contact.moment, (count,), f"{where} moment")
    for field in ("friction", "normal_min", "normal_max", "torsion"):
        check_finite(getattr(contact, field), f"{where} {field}")
    if not contact.friction > 0.0:
        raise PlanFileError(
            f"friction is {contact.friction:g}", where=where, mend="it must be positive"
        )
    if contact.torsion < 0.0:
        raise PlanFileError(
            f"torsion is {contact.torsion:g} m", where=where, mend="it must not be negative"
        )
    if not 0.0 <= contact.normal_min <= contact.normal_max:
        raise PlanFileError(
            f"normal force bounds [{contact.normal_min:g}, {contact.normal_max:g}] N",
            where=where,
            mend="need 0 <= normal_min <= normal_max",
        )
