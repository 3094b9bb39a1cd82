"""Whether states and the ways between them are free of collisions."""

from __future__ import annotations

import numpy as np

from pivotgait.frozen import Array
from pivotgait.planning.manifold import Manifold
from pivotgait.planning.problem import RelocationProblem

TOUCH_TOLERANCE = 1e-6
"""How deep the moving tip may be in the tool by rounding where it touches [m]."""
LEAST_MOBILITY = 1e-6
"""Squared motion of a gap per squared weighted motion of the joints, below which it is fixed."""
MOST_WIDENED = 0.0003
"""What a narrow gap is asked to widen at once [m]."""
MOST_HALVINGS = 4
"""Of the step between collision checks."""


class Validity:
    """Collision rule of a relocation.

    Everything keeps the world's clearance, but for the tips that hold, and for the moving tip
    within ``touch_zone`` of its place (in the tool frame) at a start or goal that touches: there
    it may come up to the tool's surface.

    Between two states the way is checked in steps in which no two shapes move by more than
    ``step`` relative to one another. Each moment in between is then within step / 2 of a checked
    one, so that a padding of step / 2 covers it.
    """

    def __init__(
        self, problem: RelocationProblem, manifold: Manifold, step: float | None = None
    ) -> None:
        """The rule of a problem, with ``step`` [m] of :func:`check_step` if not given."""
        self._manifold = manifold
        self._finger, self._zone = problem.finger, problem.options.touch_zone
        self.step = check_step(problem) if step is None else step
        holding = problem.holding
        self._world = problem.world.holding(holding, 0.5 * self.step)
        self._touching = problem.world.holding(holding | {problem.finger}, 0.5 * self.step)
        self._touches = [
            manifold.tip(q, s).translation
            for q, s, normal in (
                (problem.start, 0.0, problem.start_normal),
                (problem.goal, problem.s_goal, problem.goal_normal),
            )
            if normal is not None
        ]

    def free(self, q: Array, s: float) -> bool:
        """Whether a state keeps the rule, with the padding."""
        pose = self._manifold.tool.pose(s)
        if self._world.free(q, *pose):
            return True
        if not self._touches:
            return False
        place = self._manifold.tip(q, s).translation
        if min(float(np.linalg.norm(place - touch)) for touch in self._touches) > self._zone:
            return False
        if not self._touching.free(q, *pose):
            return False
        return self._world.tip_gap(self._finger, q, *pose) >= -TOUCH_TOLERANCE

    def narrow(self, q: Array, s: float) -> tuple[Array, Array]:
        """Gradients (M, nv) of the narrow gaps and what each lacks (M,) [m].

        Narrow are the pairs nearer than the clearance and a step between checks; the moving
        tip's distance to the tool does not count.
        """
        wanted = self._touching.clearance_min + self.step
        found = self._touching.near(q, *self._manifold.tool.pose(s), below=wanted)
        mobility = 1.0 / self._manifold.metric
        moving = [(d, g) for d, g in found if float(g @ (mobility * g)) > LEAST_MOBILITY]
        if not moving:
            return np.zeros((0, len(q))), np.zeros(0)
        gradients = np.array([gradient for _, gradient in moving])
        return gradients, np.minimum(wanted - np.array([d for d, _ in moving]), MOST_WIDENED)

    def way_free(self, qa: Array, sa: float, qb: Array, sb: float) -> bool:
        """Whether the straight way from a checked state keeps the rule, its end included.

        In the order of a coarse to fine grid, which finds a collision early.
        """
        parts = max(int(np.ceil(self._manifold.motion(qa, sa, qb, sb) / self.step)), 1)
        change, advance = qb - qa, sb - sa
        if not self.free(qb, sb):
            return False
        for k in coarse_to_fine(parts):
            share = k / parts
            if not self.free(qa + share * change, sa + share * advance):
                return False
        return True


def check_step(problem: RelocationProblem) -> float:
    """Step between checks [m]: as asked, or halved until start and goal have half of it to spare.

    Halves only, so that few padded worlds are ever made.
    """
    options, world = problem.options, problem.world
    spare = np.inf
    for q, s, normal in (
        (problem.start, 0.0, problem.start_normal),
        (problem.goal, problem.s_goal, problem.goal_normal),
    ):
        touching = problem.holding | ({problem.finger} if normal is not None else set())
        distance, _ = world.holding(touching).clearance(q, *problem.tool.pose(s))
        spare = min(spare, distance - world.clearance_min)
    halvings = np.ceil(np.log2(options.check_step / max(2.0 * spare, 1e-9)))
    return float(options.check_step * 0.5 ** np.clip(halvings, 0.0, MOST_HALVINGS))


def coarse_to_fine(parts: int) -> list[int]:
    """1 ... parts - 1 by halving: the middle first."""
    order, spans = [], [(0, parts)]
    for low, high in spans:
        middle = (low + high) // 2
        if middle > low:
            order.append(middle)
            spans += [(low, middle), (middle, high)]
    return order
