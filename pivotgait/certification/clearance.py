"""How far the tool stays above the table, by the exact support of each of its shapes."""

from __future__ import annotations

from collections.abc import Iterator

import coal
import numpy as np

from pivotgait.certification.certificate import Finding, smallest
from pivotgait.certification.solid import RigidTool, Solid
from pivotgait.frozen import Array
from pivotgait.plans import GaitPlan, Phase


def check_clearance(plan: GaitPlan, phase: Phase, rigid: RigidTool) -> Iterator[Finding]:
    """Lowest point of the tool, its tip apart, over the table at every sample [m].

    A lift starts with the tool at rest on the table, hence has a limit of its own.
    """
    if not rigid.body:
        return
    upward = phase.tool.rotation.as_matrix()[:, 2, :]  # height of a tool vector v is upward @ v
    lowest = np.min([_lowest(solid, upward) for solid in rigid.body], axis=0)
    height = phase.tool.position[:, 2] + lowest - plan.table_height
    what = "lift_clearance_m" if phase.kind == "lift" else "table_clearance_m"
    yield smallest(what, height, phase)


def _lowest(solid: Solid, upward: Array) -> Array:
    """(N,) least height of a shape relative to the tool's origin [m]; ``upward`` is (N, 3)."""
    axis = upward @ solid.rotation  # world's z in the shape's frame
    shape = solid.geometry
    if isinstance(shape, coal.Box):
        extent = np.abs(axis) @ np.array(shape.halfSide)
    elif isinstance(shape, coal.Capsule):
        extent = shape.radius + shape.halfLength * np.abs(axis[:, 2])
    elif isinstance(shape, coal.Cylinder):
        rim = np.hypot(axis[:, 0], axis[:, 1])
        extent = shape.radius * rim + shape.halfLength * np.abs(axis[:, 2])
    else:
        extent = np.full(len(axis), shape.radius)
    return np.asarray(upward @ solid.translation - extent)
