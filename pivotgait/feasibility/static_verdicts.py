"""Static verdicts by the batch: which grasps hold, with the proof either way.

A grasp that holds comes with forces; one that does not with a twist along which the load does
more work than any forces of the contacts can take up, whatever solver found it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import cone_margin, friction_margin, grasp_map
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.limits import separating_twist, tightest_labels
from pivotgait.feasibility.support import holding_power
from pivotgait.forces.local_form import LocalForm, local_form
from pivotgait.forces.null_space import Inconsistent, reduce
from pivotgait.forces.phase_one import FEASIBLE, phase_one
from pivotgait.frozen import Array, frozen

Mask = NDArray[np.bool_]
TINY = 1e-300
CHUNK = 4096
"""Grasps solved at once: enough to pay for numpy's overhead, few enough to stay in the cache."""


@dataclass(frozen=True, eq=False)
class StaticVerdicts:
    """Verdicts on B grasps; read-only arrays.

    Attributes:
        grasps: what was asked.
        feasible: (B,) whether forces within cones, bounds and rows apply the wrench.
        depth: (B,) how far inside: by so much [N] every limit could be tightened at once
            (negative: must be loosened). Converged only if ``exact`` was asked for; otherwise of
            the right sign. Minus infinity where no forces of any size apply the wrench.
        force: (B, m, 3) forces on the tool, problem's frame [N]; NaN where infeasible.
        twist: (B, 6) where infeasible, the twist that proves it, largest component 1 (moments
            over lengths in metres); NaN where feasible.
        tightest: of each grasp the kind (``friction``, ``normal_min``, ``normal_max``, ``rows``,
            or ``wrench`` where no forces of any size apply the load) and the contact (the row's
            number, or nobody) of the limit that keeps it from being deeper; empty unless
            ``exact`` was asked for.
    """

    grasps: Grasps
    feasible: Mask
    depth: Array
    force: Array
    twist: Array
    tightest: tuple[tuple[str, str], ...] = ()

    def wrench_residual(self) -> Array:
        """(B,) largest component of G f - w where feasible [N, N m], else NaN."""
        problem = self.grasps.problem
        flat = self.force.reshape(len(self.force), -1, 1)
        return np.asarray(
            np.abs((grasp_map(problem.lever) @ flat)[..., 0] - problem.wrench).max(axis=1)
        )

    def cone_margin(self) -> Array:
        """(B, m) mu f_n - |f_t| [N], at least 0 up to rounding where feasible, else NaN."""
        return cone_margin(self.force, self.grasps.problem.normals, self.grasps.friction)

    def friction_margin(self) -> Array:
        """(B,) smallest 1 - |f_t| / (mu f_n) of these forces, which need not be the best ones."""
        margin = friction_margin(self.force, self.grasps.problem.normals, self.grasps.friction)
        loaded = self.grasps.problem.loaded & ~np.isnan(margin)
        least = np.where(loaded, margin, np.inf).min(axis=1)
        return np.asarray(np.where(self.feasible, least, np.nan))

    def proof(self) -> Array:
        """(B,) for infeasible grasps the holding power along the twist: negative, so proven.

        Closed form, see :func:`pivotgait.feasibility.holding_power`; NaN where feasible. Only
        for grasps without rows.
        """
        twist = np.where(self.feasible[:, None], 0.0, self.twist)
        return np.asarray(np.where(self.feasible, np.nan, holding_power(self.grasps, twist)))


def static_verdicts(grasps: Grasps, *, exact: bool = False) -> StaticVerdicts:
    """Judge B grasps with exact friction cones, vectorised.

    Tens of thousands a second on one core (see ``pivotgait bench``); memory grows with B only by
    the answer.

    Args:
        grasps: B grasps of one shape.
        exact: converge the depth fully, which takes two to three times as long.
    """
    count, m = grasps.friction.shape
    feasible = np.zeros(count, dtype=bool)
    depth = np.full(count, -np.inf)
    force, twist = np.full((count, m, 3), np.nan), np.full((count, 6), np.nan)
    tightest = [("wrench", "")] * count
    for first in range(0, count, CHUNK):
        part = np.arange(first, min(first + CHUNK, count))
        some = grasps if len(part) == count else grasps.take(part)
        form = local_form(some.problem)
        for group in reduce(form, some.problem.wrench, some.friction):
            at = part[group.index]
            if isinstance(group, Inconsistent):
                twist[at] = _unreachable(form, some, group.index)
                continue
            end = phase_one(group.cones, exact=exact)
            depth[at] = -end.shift * group.scale
            good = end.shift <= FEASIBLE
            labels = tightest_labels(group, end.dual) if exact else []
            for place, (kind, index) in zip(at, labels, strict=False):
                contact = str(index) if kind == "rows" else grasps.names[index]
                tightest[place] = (kind, contact)
            feasible[at] = good
            local = np.zeros((len(at), m, 3))
            local[good] = group.forces(end.z)[good]
            turned = form.frames[group.index] @ local[..., None]
            force[at] = np.where(good[:, None, None], turned[..., 0], np.nan)
            opposed = separating_twist(form, group, end.dual)
            size = np.abs(opposed).max(axis=1, keepdims=True)
            twist[at] = np.where(good[:, None], np.nan, opposed / np.maximum(size, TINY))
    feasible.setflags(write=False)
    bound = tuple(tightest) if exact else ()
    return StaticVerdicts(grasps, feasible, frozen(depth), frozen(force), frozen(twist), bound)


def _unreachable(form: LocalForm, grasps: Grasps, index: NDArray[np.intp]) -> Array:
    """(B, 6) twists that no contact force opposes and the load drives."""
    problem = grasps.problem
    given = (form.value[index]).reshape(len(index), -1, 1)
    missing = problem.wrench[index][..., None] - form.grasp[index] @ given
    free = ~form.known[index[0]].reshape(-1)
    grasp = form.grasp[index][:, :, free]
    # moments over the grasp's size, else the projection would weigh metres against newtons
    size = np.sqrt(np.mean(np.sum(grasp[:, 3:] ** 2, axis=1), axis=1))
    weight = np.ones((len(index), 6, 1))
    weight[:, 3:] = (1.0 / np.where(size > 0.0, size, 1.0))[:, None, None]
    scaled = grasp * weight
    left = weight * missing - scaled @ (np.linalg.pinv(scaled, rcond=1e-8) @ (weight * missing))
    twist = (left * weight)[..., 0]
    return np.asarray(twist / np.abs(twist).max(axis=1, keepdims=True))
