"""Force allocation against its peers, on random grasps of a kitchen knife."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame, grasp_map
from pivotgait.forces import AllocationProblem, Objective, allocate
from pivotgait.forces.proxqp_build import load_cvxpy

Array = NDArray[np.float64]
NAMES = ("pivot", "thumb", "index", "middle", "ring")
BATCHES = 4
KNIFE_MASS = 0.225  # [kg]
TIP_TO_COM = 0.22  # [m]
HANDLE_HALF_WIDTH, HANDLE_HALF_HEIGHT = 0.010, 0.0145  # [m] stadium cross-section
AROUND = np.radians((90.0, -90.0, 180.0, 0.0))
"""Places of thumb, index, middle, ring around the handle, from its top (z) towards y."""


def random_problem(
    rng: np.random.Generator,
    samples: int,
    contacts: int,
    objective: Objective = "alignment",
    *,
    spread: float = 1.0,
) -> AllocationProblem:
    """Random samples of a knife that pivots on the table, held by ``contacts - 1`` fingers.

    The knife of 0.225 kg is lifted by about 25 degrees, the fingers hold its handle about
    0.27 m from the pivot; friction 0.4 at the table, 0.8 at the fingers, finger forces in
    [0.3, 4] N. With two contacts, which cannot apply every wrench, the wrench is that of random
    forces. Most samples are feasible; a larger ``spread`` of the places makes fewer so.

    Args:
        rng: source of randomness.
        samples: number of samples T.
        contacts: 2 to 5, the pivot among them.
        objective: of the problem.
        spread: scales the random part of contact places and accelerations.
    """
    fingers = contacts - 1
    shape = (samples, fingers)
    angle = AROUND[:fingers] + spread * rng.normal(0.0, 0.15, shape)
    along = -0.05 + spread * rng.uniform(-0.03, 0.03, shape)
    normals = np.zeros((samples, contacts, 3))
    lever = np.zeros((samples, contacts, 3))
    normals[:, 1:, 1], normals[:, 1:, 2] = -np.sin(angle), -np.cos(angle)
    straight = HANDLE_HALF_HEIGHT - HANDLE_HALF_WIDTH
    lever[:, 1:] = -HANDLE_HALF_WIDTH * normals[:, 1:]
    lever[:, 1:, 2] += straight * np.cos(angle)
    lever[:, 1:, 0] = along
    lever[:, 0] = (TIP_TO_COM, 0.0, -0.02)

    pitch = np.radians(25.0) + spread * rng.normal(0.0, 0.1, samples)
    roll = spread * rng.normal(0.0, 0.1, samples)
    tilt = _rotation_y(pitch) @ _rotation_x(roll)
    normals, lever = normals @ np.swapaxes(tilt, 1, 2), lever @ np.swapaxes(tilt, 1, 2)
    normals[:, 0] = (0.0, 0.0, 1.0)

    friction = np.full(contacts, 0.8)
    friction[0] = 0.4
    if fingers == 1:
        along_normal = rng.uniform(0.5, 3.0, (samples, contacts, 1))
        force = along_normal * (normals + 0.2 * spread * rng.normal(size=normals.shape))
        moment = np.cross(lever, force).sum(axis=1)
        wrench = np.concatenate((force.sum(axis=1), moment), axis=1)
    else:
        wrench = np.zeros((samples, 6))
        wrench[:, :3] = KNIFE_MASS * spread * rng.normal(0.0, 0.3, (samples, 3))
        wrench[:, 2] += KNIFE_MASS * 9.81
        wrench[:, 3:] = spread * rng.normal(0.0, 0.004, (samples, 3))
    normal_min = np.full((samples, contacts), 0.3)
    normal_min[:, 0] = 0.05
    normal_max = np.full((samples, contacts), 4.0)
    normal_max[:, 0] = 10.0
    return AllocationProblem(
        names=NAMES[:contacts],
        lever=lever,
        normals=normals,
        friction=friction,
        normal_min=normal_min,
        normal_max=normal_max,
        wrench=wrench,
        objective=objective,
    )


def _rotation_y(angle: Array) -> Array:
    out = np.zeros((len(angle), 3, 3))
    out[:, 0, 0] = out[:, 2, 2] = np.cos(angle)
    out[:, 0, 2], out[:, 2, 0], out[:, 1, 1] = np.sin(angle), -np.sin(angle), 1.0
    return out


def _rotation_x(angle: Array) -> Array:
    out = np.zeros((len(angle), 3, 3))
    out[:, 1, 1] = out[:, 2, 2] = np.cos(angle)
    out[:, 1, 2], out[:, 2, 1], out[:, 0, 0] = -np.sin(angle), np.sin(angle), 1.0
    return out


def allocation_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Time allocations against their peers, in one run and one thread of each.

    Peers are built (parametrised, compiled) once and warm; their building is reported apart.

    Args:
        quick: fewer problems for the peers.

    Returns:
        One dict per row: ``name``, ``ours_s``, ``peer``, ``peer_s`` (seconds per problem),
        ``ratio`` = peer_s / ours_s, ``peer_build_s``, and ``worst_gap``, the largest relative
        excess of our objective over the peer's.
    """
    samples, count = 1000, 40 if quick else 400
    peers: dict[Objective, tuple[Callable[[AllocationProblem], Peer], ...]] = {
        "tangential": (CvxpyPeer,),
        "effort": (CvxpyPeer,),
        "alignment": (IpoptPeer, ThoroughIpoptPeer),
    }
    rows = []
    for objective, makes in peers.items():
        problem = random_problem(np.random.default_rng(7), samples, 4, objective)
        ours = allocate(problem, "interior_point").objective[:count]
        batch_s = _mean_s(problem, BATCHES) / samples
        singles = [problem.sample(k) for k in range(count)]
        alone = np.array([allocate(single).objective[0] for single in singles])
        begin = time.perf_counter()
        for single in singles:
            allocate(single)
        one_s = (time.perf_counter() - begin) / count
        for make in makes:
            begin = time.perf_counter()
            peer = make(problem)
            peer.solve(problem, 0)  # compiles what is compiled late
            build = time.perf_counter() - begin
            begin = time.perf_counter()
            values = np.array([peer.solve(problem, k) for k in range(count)])
            peer_s = (time.perf_counter() - begin) / count
            for name, ours_s, value in (
                (f"{objective}, batch of {samples}", batch_s, ours),
                (f"{objective}, one", one_s, alone),
            ):
                excess = float(np.nanmax((value - values) / values))
                rows.append(_row(name, ours_s, peer, peer_s, build, excess))
    return rows


def _row(
    name: str, ours_s: float, peer: Peer, peer_s: float, build: float, excess: float
) -> dict[str, Any]:
    return {
        "name": f"allocation: {name}",
        "ours_s": ours_s,
        "peer": peer.name,
        "peer_s": peer_s,
        "ratio": peer_s / ours_s,
        "peer_build_s": build,
        "worst_gap": excess,
    }


def _mean_s(problem: AllocationProblem, times: int) -> float:
    """Mean seconds of a few batches, as the peers' problems are averaged too."""
    begin = time.perf_counter()
    for _ in range(times):
        allocate(problem, "interior_point")
    return (time.perf_counter() - begin) / times


class Peer(Protocol):
    """A solver of one problem at a time, prepared for one shape."""

    name: str

    def solve(self, problem: AllocationProblem, k: int) -> float:
        """Objective of sample k, NaN where infeasible."""
        ...


class CvxpyPeer:
    """Tangential or effort as a parametrised CVXPY problem on Clarabel.

    In contact coordinates, where the parameters enter affinely (DPP), so that CVXPY compiles
    once and only fills in numbers afterwards.
    """

    name = "CVXPY + Clarabel, parametrised"

    def __init__(self, problem: AllocationProblem) -> None:
        cp = load_cvxpy()

        m = problem.contacts
        self.x = cp.Variable((m, 3))
        self.grasp = cp.Parameter((6, 3 * m))
        self.wrench = cp.Parameter(6)
        rows = [self.grasp @ cp.vec(self.x, order="C") == self.wrench]
        rows += [
            cp.norm(self.x[i, :2]) <= float(problem.friction[i]) * self.x[i, 2] for i in range(m)
        ]
        rows += [self.x[:, 2] >= problem.normal_min[0], self.x[:, 2] <= problem.normal_max[0]]
        if problem.objective == "effort":
            goal = cp.sum_squares(self.x)
        else:
            goal = sum(cp.quad_over_lin(self.x[i, :2], self.x[i, 2]) for i in range(m))
        self.program = cp.Problem(cp.Minimize(goal), rows)

    def solve(self, problem: AllocationProblem, k: int) -> float:
        """Objective of sample k, NaN where infeasible."""
        cp = load_cvxpy()

        turn = contact_frame(problem.normals[k])
        grasp = grasp_map(problem.lever[k]).reshape(6, -1, 1, 3) @ turn
        self.grasp.value, self.wrench.value = grasp.reshape(6, -1), problem.wrench[k]
        self.program.solve(solver=cp.CLARABEL)
        return float(self.program.value) if self.program.status == "optimal" else np.nan


class IpoptPeer:
    """The exact alignment (Xue et al., eq. 4) by CasADi and IPOPT, compiled once.

    Contact coordinates. The first start presses every contact midway between its bounds, which
    is inside them and aligned. Each further start presses one contact no more than it must, as
    ours do: local minima differ in the contact they give up.
    """

    def __init__(self, problem: AllocationProblem, starts: int = 1) -> None:
        import casadi

        m = problem.contacts
        x, grasp = casadi.SX.sym("x", 3, m), casadi.SX.sym("G", 6, 3 * m)
        wrench = casadi.SX.sym("w", 6)
        goal = casadi.SX(0)
        rows = [grasp @ casadi.vec(x) - wrench]
        for i in range(m):
            square = x[0, i] ** 2 + x[1, i] ** 2
            goal += square / (square + x[2, i] ** 2)
            rows.append((float(problem.friction[i]) * x[2, i]) ** 2 - square)
        self.solver = casadi.nlpsol(
            "alignment",
            "ipopt",
            {
                "x": casadi.vec(x),
                "f": goal,
                "g": casadi.vertcat(*rows),
                "p": casadi.vertcat(casadi.vec(grasp), wrench),
            },
            {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-8},
        )
        self.low, self.high = np.full((m, 3), -np.inf), np.full((m, 3), np.inf)
        self.low[:, 2], self.high[:, 2] = problem.normal_min[0], problem.normal_max[0]
        many = f"best of {starts} starts" if starts > 1 else "from one start"
        self.name = f"CasADi + IPOPT, compiled, {many}"
        self.starts = np.zeros((starts, m, 3))
        self.starts[..., 2] = 0.5 * (problem.normal_min[0] + np.minimum(problem.normal_max[0], 4.0))
        for k in range(1, starts):
            self.starts[k, k - 1, 2] = problem.normal_min[0, k - 1]
        self.top = np.concatenate((np.zeros(6), np.full(m, np.inf)))

    def solve(self, problem: AllocationProblem, k: int) -> float:
        """Least objective of sample k, NaN where infeasible."""
        turn = contact_frame(problem.normals[k])
        grasp = (grasp_map(problem.lever[k]).reshape(6, -1, 1, 3) @ turn).reshape(6, -1)
        best = np.inf
        for start in self.starts:
            answer = self.solver(
                x0=start.ravel(),
                p=np.concatenate((grasp.ravel(order="F"), problem.wrench[k])),
                lbx=self.low.ravel(),
                ubx=self.high.ravel(),
                lbg=0.0,
                ubg=self.top,
            )
            if self.solver.stats()["success"]:
                best = min(best, float(answer["f"]))
        return best if np.isfinite(best) else np.nan


class ThoroughIpoptPeer(IpoptPeer):
    """IPOPT from as many starts as ours: the same certainty of having the least minimum."""

    def __init__(self, problem: AllocationProblem) -> None:
        super().__init__(problem, starts=problem.contacts + 1)
