"""Whether consecutive phases join: pose, contact forces, contact places."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pivotgait.certification.certificate import Finding
from pivotgait.certification.limits import LIMITS
from pivotgait.plans import ContactTrack, GaitPlan, Phase

_FREE_N = LIMITS["free_force_n"].bound


def check_seams(plan: GaitPlan) -> Iterator[Finding]:
    """Jumps between each phase and its predecessor, reported at the later phase's start."""
    for before, after in zip(plan.phases[:-1], plan.phases[1:], strict=True):
        yield from _check_pose(before, after)
        for name in sorted({*before.contacts, *after.contacts}):
            yield from _check_contact(before, after, name)


def _check_pose(before: Phase, after: Phase) -> Iterator[Finding]:
    turn = before.tool.rotation[-1].inv() * after.tool.rotation[0]
    yield Finding("seam_orientation_rad", float(turn.magnitude()), after.name, time_s=0.0)
    jump = float(np.linalg.norm(after.tool.position[0] - before.tool.position[-1]))
    yield Finding("seam_position_m", jump, after.name, time_s=0.0)


def _check_contact(before: Phase, after: Phase, name: str) -> Iterator[Finding]:
    """A contact that one side lacks carries no force on the other; one held stays as it is.

    A finger free of force on both sides may have gone elsewhere in between.
    """
    left, right = before.contacts.get(name), after.contacts.get(name)
    force_left = np.zeros(3) if left is None else left.force[-1]
    force_right = np.zeros(3) if right is None else right.force[0]
    jump = float(np.linalg.norm(force_right - force_left))
    yield Finding("seam_force_n", jump, after.name, name, 0.0)
    if any(each is not None and each.moment is not None for each in (left, right)):
        turn = abs(_moment(right, 0) - _moment(left, -1))
        yield Finding("seam_moment_nm", turn, after.name, name, 0.0)
    held = max(np.linalg.norm(force_left), np.linalg.norm(force_right)) > _FREE_N
    if left is not None and right is not None and held:
        yield from _check_place(left, right, after.name)


def _moment(contact: ContactTrack | None, sample: int) -> float:
    if contact is None or contact.moment is None:
        return 0.0
    return float(contact.moment[sample])


def _check_place(left: ContactTrack, right: ContactTrack, phase: str) -> Iterator[Finding]:
    moved = float(np.linalg.norm(right.point - left.point))
    yield Finding("seam_contact_m", moved, phase, left.name, 0.0)
    # A plan must not buy feasibility with a coefficient that differs from phase to phase.
    yield Finding("seam_friction", abs(right.friction - left.friction), phase, left.name, 0.0)
