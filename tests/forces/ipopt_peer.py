"""The exact alignment problem (eq. 4) by CasADi and IPOPT: shares nothing with the package."""

from __future__ import annotations

from typing import Any

import numpy as np


class IpoptAlignment:
    """Problems of m contacts, compiled once; world coordinates, friction as its square."""

    def __init__(self, contacts: int, tolerance: float = 1e-12) -> None:
        import casadi as ca

        m = contacts
        f = ca.SX.sym("f", 3, m)
        normal, lever = ca.SX.sym("n", 3, m), ca.SX.sym("r", 3, m)
        wrench, mu = ca.SX.sym("w", 6), ca.SX.sym("mu", m)
        moments = [ca.cross(lever[:, i], f[:, i]) for i in range(m)]
        cost, rows = 0, [ca.sum2(f) - wrench[:3], ca.sum2(ca.horzcat(*moments)) - wrench[3:]]
        for i in range(m):
            along = ca.dot(f[:, i], normal[:, i])
            square = ca.dot(f[:, i], f[:, i])
            cost += 1 - along**2 / square
            rows += [(1 + mu[i] ** 2) * along**2 - square, along]
        p = ca.vertcat(ca.vec(normal), ca.vec(lever), wrench, mu)
        self.solver = ca.nlpsol(
            "alignment",
            "ipopt",
            {"x": ca.vec(f), "f": cost, "g": ca.vertcat(*rows), "p": p},
            {
                "ipopt.print_level": 0,
                "print_time": 0,
                "ipopt.sb": "yes",
                "ipopt.tol": tolerance,
                "ipopt.constr_viol_tol": 1e-10,
                "ipopt.bound_relax_factor": 0.0,
                "ipopt.max_iter": 500,
            },
        )

    def solve(self, problem: Any, k: int, start: np.ndarray) -> tuple[np.ndarray, float, bool]:
        """Forces (m, 3), sum of sin^2 and success, from a start (m, 3)."""
        m = problem.contacts
        places = (problem.normals[k].ravel(), problem.lever[k].ravel())
        p = np.concatenate((*places, problem.wrench[k], problem.friction))
        low, high = np.zeros(6 + 2 * m), np.zeros(6 + 2 * m)
        low[7::2], high[7::2] = problem.normal_min[k], problem.normal_max[k]
        high[6::2] = np.inf
        out = self.solver(x0=start.ravel(), p=p, lbg=low, ubg=high)
        force = np.array(out["x"]).reshape(m, 3)
        return force, float(out["f"]), bool(self.solver.stats()["success"])
