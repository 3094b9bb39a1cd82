"""The made-up gait, with and without an arm-hand, and a run of it."""

import pytest

from tests.plotting.knife_gait import knife_plan, motion_of, with_robot


@pytest.fixture(scope="session")
def plan():
    return knife_plan()


@pytest.fixture(scope="session")
def robot_plan(plan):
    return with_robot(plan)


@pytest.fixture(scope="session")
def motion(robot_plan):
    return motion_of(robot_plan)
