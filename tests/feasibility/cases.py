"""Random grasps and independent judges of them."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from pivotgait.contacts import contact_frame, grasp_map
from pivotgait.feasibility import Grasps
from pivotgait.forces import AllocationProblem

PIVOT_IN_TOOL = np.array([0.2, 0.0, -0.02])


def random_grasps(rng: np.random.Generator, count: int, contacts: int) -> Grasps:
    """Tools of random places, normals, friction, bounds and load: about half can be held."""
    fingers = contacts - 1
    angle = np.linspace(0.0, 2.0 * np.pi, fingers, endpoint=False)
    angle = angle + rng.normal(0.0, 0.5, (count, fingers))
    out = np.stack((0.4 * rng.normal(size=angle.shape), np.cos(angle), np.sin(angle)), axis=-1)
    inward = -out / np.linalg.norm(out, axis=-1, keepdims=True)
    points = -0.02 * inward
    points[..., 0] += rng.uniform(-0.12, -0.02, (count, fingers))
    lever = np.concatenate((np.broadcast_to(PIVOT_IN_TOOL, (count, 1, 3)), points), axis=1)
    normals = np.concatenate((np.broadcast_to([0.0, 0.0, 1.0], (count, 1, 3)), inward), axis=1)
    low = rng.uniform(0.0, 0.3, (count, contacts))
    wrench = np.zeros((count, 6))
    wrench[:, :3] = rng.normal(0.0, 0.5, (count, 3))
    wrench[:, 2] += rng.uniform(0.5, 3.0, count)
    wrench[:, 3:] = rng.normal(0.0, 0.02, (count, 3))
    problem = AllocationProblem(
        names=("pivot", "thumb", "index", "middle", "ring")[:contacts],
        lever=lever,
        normals=normals,
        friction=np.full(contacts, 0.5),
        normal_min=low,
        normal_max=low + rng.uniform(1.0, 5.0, (count, contacts)),
        wrench=wrench,
        objective="effort",
    )
    return Grasps(problem, rng.uniform(0.2, 0.9, (count, contacts)))


def pyramid_verdict(grasps: Grasps, k: int, facets: int, *, outer: bool) -> bool:
    """Whether a linear program with pyramids instead of cones finds forces of grasp ``k``.

    Generators on the cone (inner), or on the circumscribed pyramid's edges (outer).
    """
    problem, m = grasps.problem, len(grasps.names)
    angle = 2.0 * np.pi * np.arange(facets) / facets
    widen = 1.0 / np.cos(np.pi / facets) if outer else 1.0
    maps = grasp_map(problem.lever[k]).reshape(6, m, 3)
    columns, normal_rows = [], np.zeros((m, m * facets))
    for i in range(m):
        radius = widen * grasps.friction[k, i]
        edges = np.stack((radius * np.cos(angle), radius * np.sin(angle), np.ones(facets)))
        columns.append(maps[:, i] @ contact_frame(problem.normals[k, i]) @ edges)
        normal_rows[i, i * facets : (i + 1) * facets] = 1.0
    answer = linprog(
        np.zeros(m * facets),
        A_eq=np.concatenate(columns, axis=1),
        b_eq=problem.wrench[k],
        A_ub=np.concatenate((normal_rows, -normal_rows)),
        b_ub=np.concatenate((problem.normal_max[k], -problem.normal_min[k])),
        bounds=(0.0, None),
        method="highs",
    )
    assert answer.status in (0, 2)
    return answer.status == 0


def one(grasps: Grasps, k: int) -> Grasps:
    """Grasp ``k`` alone."""
    return grasps.take(np.array([k]))
