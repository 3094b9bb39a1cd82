"""The gaits that ``tests/plotting`` draws, with and without an arm-hand."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

_KNIFE = Path(__file__).parents[1] / "plotting" / "conftest.py"


@pytest.fixture(scope="session")
def knife_module():
    spec = spec_from_file_location("knife_plan", _KNIFE)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def plan(knife_module):
    return knife_module.knife_plan()


@pytest.fixture(scope="session")
def robot_plan(plan, knife_module):
    return knife_module.with_robot(plan)
