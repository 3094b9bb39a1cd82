"""Static verdicts by the batch against a loop over one parametrised CVXPY program."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.contacts import contact_frame, grasp_map
from pivotgait.feasibility import Grasps, static_verdicts
from pivotgait.forces.proxqp_build import load_cvxpy
from pivotgait.frozen import Array

SAMPLES, PEER_SAMPLES, BATCHES = 8192, 400, 3
SPREAD = 3.0
"""Of the random places: leaves about a third of the grasps infeasible."""


def feasibility_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Seconds for one verdict on random grasps of a knife, in one thread of each.

    Args:
        quick: fewer problems for the peer.

    Returns:
        One dict per number of contacts, as :func:`allocation_rows`, with ``agreement``: the share
        of grasps on which the two agree.
    """
    rows = []
    for contacts in (3, 4):
        rng = np.random.default_rng(7)
        problem = random_problem(rng, SAMPLES, contacts, "effort", spread=SPREAD)
        grasps = Grasps(problem, rng.uniform(0.3, 0.9, (SAMPLES, contacts)))
        begin = time.perf_counter()
        for _ in range(BATCHES):
            ours = static_verdicts(grasps).feasible
        ours_s = (time.perf_counter() - begin) / (BATCHES * SAMPLES)
        begin = time.perf_counter()
        peer = CvxpyVerdict(contacts)
        peer.feasible(grasps, 0)  # compiles what is compiled late
        build = time.perf_counter() - begin
        count = PEER_SAMPLES // 10 if quick else PEER_SAMPLES
        begin = time.perf_counter()
        theirs = np.array([peer.feasible(grasps, k) for k in range(count)])
        peer_s = (time.perf_counter() - begin) / count
        rows.append(
            {
                "name": f"static verdict: {contacts} contacts, batch of {SAMPLES}",
                "ours_s": ours_s,
                "peer": peer.name,
                "peer_s": peer_s,
                "ratio": peer_s / ours_s,
                "peer_build_s": build,
                "agreement": float(np.mean(ours[:count] == theirs)),
            }
        )
    return rows


class CvxpyVerdict:
    """Feasibility as one CVXPY program whose data are parameters (DPP), on Clarabel.

    Args:
        contacts: number of contacts.
    """

    name = "CVXPY + Clarabel, parametrised"

    def __init__(self, contacts: int) -> None:
        cp = load_cvxpy()

        m = contacts
        x = cp.Variable((m, 3))
        self.grasp, self.wrench = cp.Parameter((6, 3 * m)), cp.Parameter(6)
        self.friction = cp.Parameter(m, nonneg=True)
        self.low, self.high = cp.Parameter(m), cp.Parameter(m)
        rows = [self.grasp @ cp.vec(x, order="C") == self.wrench, x[:, 2] >= self.low]
        rows += [x[:, 2] <= self.high]
        rows += [cp.norm(x[i, :2]) <= self.friction[i] * x[i, 2] for i in range(m)]
        self.program = cp.Problem(cp.Minimize(0.0), rows)

    def feasible(self, grasps: Grasps, k: int) -> bool:
        """The verdict on grasp k."""
        cp = load_cvxpy()

        problem = grasps.problem
        turn: Array = contact_frame(problem.normals[k])
        local = grasp_map(problem.lever[k]).reshape(6, -1, 1, 3) @ turn
        self.grasp.value, self.wrench.value = local.reshape(6, -1), problem.wrench[k]
        self.friction.value = grasps.friction[k]
        self.low.value, self.high.value = problem.normal_min[k], problem.normal_max[k]
        self.program.solve(solver=cp.CLARABEL)
        return bool(self.program.status in ("optimal", "optimal_inaccurate"))
