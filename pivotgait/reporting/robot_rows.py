"""What the page says of the arm-hand: how near it comes to its limits, phase by phase."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.margins import largest_share
from pivotgait.margins.joints import LargestShare, ShareKind
from pivotgait.plans.plan import GaitPlan, Phase
from pivotgait.plotting.posture import Skeleton, skeleton
from pivotgait.reporting.numbers import UNKNOWN, quantity

CLEARANCE = "hand_clearance_m"
"""Name of the certificate's residual."""


@dataclass(frozen=True)
class RobotRow:
    """A phase in the table of the arm-hand; texts with units, ``*_joint`` says which joint."""

    name: str
    torque: str
    torque_joint: str
    speed: str
    speed_joint: str
    range: str
    range_joint: str
    path: str


@dataclass(frozen=True)
class Clearance:
    """Smallest distance of the robot to anything; ``limit`` says the least allowed and where."""

    value: str
    limit: str


def robot_rows(plan: GaitPlan) -> tuple[RobotRow, ...]:
    """The phases in order; none for a plan without a robot.

    Raises:
        UrdfError: if the robot's URDF is broken.
    """
    if plan.robot is None:
        return ()
    body = skeleton(plan.robot)
    rows = []
    for phase in plan.phases:
        torque, speed, place = (_share(plan, kind, phase) for kind in ("torque", "speed", "range"))
        rows.append(RobotRow(phase.name, *torque, *speed, *place, _path(plan, phase, body)))
    return tuple(rows)


def robot_headline(plan: GaitPlan, certificate: Mapping[str, Any]) -> str:
    """The gait's largest shares and smallest clearance in one line; empty without a robot."""
    largest = {kind: largest_share(plan, kind) for kind in ("torque", "speed")}
    parts = [f"{kind} up to {_percent(found)}" for kind, found in largest.items() if found]
    least = clearance(certificate).value
    parts += [f"clearance {least}"] if parts and least != UNKNOWN else []
    return ", ".join(parts)


def clearance(certificate: Mapping[str, Any]) -> Clearance:
    """What a certificate (as ``pivotgait certify --json`` gives it) says of the clearance."""
    least = _millimetres(certificate.get("residuals", {}))
    bound = _millimetres(certificate.get("tolerances", {}))
    place = certificate.get("worst", {}).get(CLEARANCE, {})
    limit = f"limit ≥ {bound}" if bound != UNKNOWN else ""
    return Clearance(least, ", ".join(part for part in (limit, place.get("phase")) if part))


def _millimetres(values: Mapping[str, Any]) -> str:
    found = values.get(CLEARANCE)
    return quantity(1e3 * found if isinstance(found, float) else None, "mm")


def _share(plan: GaitPlan, kind: ShareKind, phase: Phase) -> tuple[str, str]:
    found = largest_share(plan, kind, phase=phase.name)
    return (_percent(found), found.joint) if found else (UNKNOWN, "")


def _percent(found: LargestShare) -> str:
    return quantity(100.0 * found.value, "%")


def _path(plan: GaitPlan, phase: Phase, body: Skeleton) -> str:
    """How far the tip of a relocated finger travels as seen from the tool [mm]."""
    if plan.robot is None or phase.robot is None or phase.kind != "relocation":
        return UNKNOWN
    if phase.finger not in plan.robot.fingers:
        return UNKNOWN
    tip = body.poses(phase.robot.q)[plan.robot.fingers[phase.finger].tip_frame][:, :3, 3]
    turn = phase.tool.rotation.as_matrix()
    local = np.einsum("nji,nj->ni", turn, tip - phase.tool.position)
    return quantity(1e3 * float(np.linalg.norm(np.diff(local, axis=0), axis=1).sum()), "mm")
