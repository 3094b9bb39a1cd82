"""Force allocation: a solver-neutral problem, its solvers, a solution that proves itself."""

from pivotgait.forces.allocate import SOLVERS, Solver, allocate
from pivotgait.forces.diagnosis import Diagnosis, Mend, diagnose
from pivotgait.forces.problem import OBJECTIVES, AllocationProblem, LinearRows, Objective
from pivotgait.forces.solution import Allocation

__all__ = [
    "OBJECTIVES",
    "SOLVERS",
    "Allocation",
    "AllocationProblem",
    "Diagnosis",
    "LinearRows",
    "Mend",
    "Objective",
    "Solver",
    "allocate",
    "diagnose",
]
