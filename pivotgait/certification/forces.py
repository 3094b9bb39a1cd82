"""Whether the contact forces move the tool as the plan says, inside cones, bounds and ramps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pivotgait.certification.certificate import Finding, largest, smallest
from pivotgait.frozen import Array
from pivotgait.plans import ContactTrack, GaitPlan, Phase


def check_dynamics(plan: GaitPlan, phase: Phase) -> Iterator[Finding]:
    """Residual of Newton-Euler about the centre of mass (Xue et al., eq. 3, with f_0)."""
    tool, rotation = phase.tool, phase.tool.rotation.as_matrix()
    force = plan.tool.mass * (tool.linear_acceleration - plan.gravity)
    # I_W w' + w x I_W w, formed in the tool frame where the inertia is constant.
    omega = np.einsum("nji,nj->ni", rotation, tool.angular_velocity)
    sigma = np.einsum("nji,nj->ni", rotation, tool.angular_acceleration)
    inertia = plan.tool.inertia
    in_tool = sigma @ inertia.T + np.cross(omega, omega @ inertia.T)
    moment = np.einsum("nij,nj->ni", rotation, in_tool)
    for _, contact in sorted(phase.contacts.items()):
        lever = contact.point - tool.position if contact.is_pivot else rotation @ contact.point
        force = force - contact.force
        moment = moment - np.cross(lever, contact.force)
        if contact.moment is not None:
            moment = moment - contact.moment[:, None] * _world_normal(contact, phase)
    yield largest("force_balance_n", np.linalg.norm(force, axis=1), phase)
    yield largest("moment_balance_nm", np.linalg.norm(moment, axis=1), phase)


def check_cones(phase: Phase) -> Iterator[Finding]:
    """Exact friction cones (5) and normal force bounds (6) of every contact and sample.

    A moment m about the normal of a soft contact with the coefficient of torsional friction e
    counts in the cone as a tangential force mu m / e (the ellipsoid of Howe and Cutkosky 1996).

    The finger that a removal or an addition changes may go down to 0 N: (6) would otherwise
    contradict (7) at its end and (8) at its start.
    """
    for name, contact in sorted(phase.contacts.items()):
        normal = _world_normal(contact, phase)
        pressing = _normal_force(contact, phase)
        sliding = np.linalg.norm(contact.force - pressing[:, None] * normal, axis=1)
        sliding = np.hypot(sliding, _spinning(contact))
        yield smallest("cone_margin_n", contact.friction * pressing - sliding, phase, name)
        lower = 0.0 if _changes(phase, name) else contact.normal_min
        beyond = np.maximum(lower - pressing, pressing - contact.normal_max)
        yield largest("normal_bound_n", np.maximum(beyond, 0.0), phase, name)


def check_ramp(phase: Phase) -> Iterator[Finding]:
    """Linear ramp of the changing finger's normal force, eqs (7) and (8), down to or up from 0."""
    if phase.kind == "relocation":
        if phase.finger in phase.contacts:
            force = np.linalg.norm(phase.contacts[phase.finger].force, axis=1)
            yield largest("free_force_n", force, phase, phase.finger)
        return
    if phase.kind not in ("removal", "addition"):
        return
    contact = phase.contacts[phase.finger]
    pressing = _normal_force(contact, phase)
    share = np.linspace(0.0, 1.0, len(pressing))
    leaving = phase.kind == "removal"
    ramp = (1.0 - share) * pressing[0] if leaving else share * pressing[-1]
    yield largest("ramp_n", np.abs(pressing - ramp), phase, phase.finger)
    free = -1 if leaving else 0
    size, time = float(np.linalg.norm(contact.force[free])), float(phase.time[free])
    yield Finding("free_force_n", size, phase.name, phase.finger, time)


def _spinning(contact: ContactTrack) -> Array:
    """(N,) moment about the normal as a tangential force [N]; infinite without torsion."""
    if contact.moment is None:
        return np.zeros(len(contact.force))
    if contact.torsion <= 0.0:
        return np.where(contact.moment == 0.0, 0.0, np.inf)
    return np.asarray(contact.friction / contact.torsion * contact.moment)


def _changes(phase: Phase, name: str) -> bool:
    return phase.kind in ("removal", "addition") and name == phase.finger


def _world_normal(contact: ContactTrack, phase: Phase) -> Array:
    if contact.is_pivot:
        return np.broadcast_to(contact.normal, contact.force.shape)
    return np.asarray(phase.tool.rotation.as_matrix() @ contact.normal)


def _normal_force(contact: ContactTrack, phase: Phase) -> Array:
    return np.asarray(np.sum(contact.force * _world_normal(contact, phase), axis=1))
