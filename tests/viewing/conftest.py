"""The gaits that ``tests/plotting`` draws, with and without an arm-hand."""

import pytest

from tests.plotting.knife_gait import knife_plan, with_robot


@pytest.fixture(scope="session")
def plan():
    return knife_plan()


@pytest.fixture(scope="session")
def robot_plan(plan):
    return with_robot(plan)
