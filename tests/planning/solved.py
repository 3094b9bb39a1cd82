"""A relocation's problem with its plan."""

from __future__ import annotations

from dataclasses import dataclass

from pivotgait.planning.problem import RelocationProblem
from pivotgait.planning.relocation import Relocation
from pivotgait.planning.trajectory import JointTrajectory

SEED = 3


@dataclass(frozen=True, eq=False)
class Solved:
    """A problem with its plan."""

    problem: RelocationProblem
    plan: Relocation

    @property
    def trajectory(self) -> JointTrajectory:
        return self.plan.require()
