"""A knife held by three fingers, and relocations planned from there."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.benchmarks.relocation import Grip, knife_grip, relocation_problems
from pivotgait.planning.problem import RelocationProblem
from pivotgait.planning.relocation import plan_relocation
from tests.planning.solved import SEED, Solved


@pytest.fixture(scope="session")
def grip() -> Grip:
    return knife_grip()


@pytest.fixture(scope="session")
def problems(grip: Grip) -> dict[str, RelocationProblem]:
    return relocation_problems(grip)


@pytest.fixture(scope="session", params=["index, contact", "middle, first", "middle, straight"])
def solved(problems: dict[str, RelocationProblem], request: pytest.FixtureRequest) -> Solved:
    problem = next(each for name, each in problems.items() if name.startswith(request.param))
    return Solved(problem, plan_relocation(problem, np.random.default_rng(SEED)))


@pytest.fixture(scope="session")
def first_contact(problems: dict[str, RelocationProblem]) -> RelocationProblem:
    return problems["middle, first contact"]
