"""While a free finger moves, the tool rests under forces that stay as they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pivotgait.phases.grasp import Grasp
from pivotgait.phases.relocation import relocation_phase, resting_tool
from pivotgait.plans import PIVOT, Phase


@pytest.mark.parametrize("count", [2, 30])
def test_a_grasp_kept_for_a_while(
    count: int, moment: Callable[..., Any], assert_laws: Callable[[Any, Phase], None]
) -> None:
    before = moment("knife", 1)
    time = np.linspace(0.0, 0.7, count)
    setting, grasp = before.setting, before.grasp
    phase = relocation_phase(setting, grasp, "middle", time, name="01_relocation")
    assert_laws(before, phase)
    assert (phase.name, phase.kind, phase.finger) == ("01_relocation", "relocation", "middle")
    assert phase.duration_s == pytest.approx(0.7)
    assert phase.reorientation_deg == 0.0
    assert phase.contacts.keys() == {PIVOT, *grasp.fingers}
    assert phase.robot is None
    for name, track in phase.contacts.items():
        np.testing.assert_array_equal(track.force, np.tile(grasp.forces[name], (count, 1)))
    after = Grasp.after(phase.tool, grasp.fingers, phase.contacts)
    assert (after.rotation.inv() * grasp.rotation).magnitude() < 1e-12
    for name, force in grasp.forces.items():
        np.testing.assert_array_equal(after.forces[name], force)


def test_the_tool_rests_on_its_pivot(moment: Callable[..., Any]) -> None:
    before = moment("screwdriver", 1)
    tool = resting_tool(before.setting, before.grasp.rotation, 5)
    for array in (
        tool.linear_velocity,
        tool.angular_velocity,
        tool.linear_acceleration,
        tool.angular_acceleration,
    ):
        np.testing.assert_array_equal(array, np.zeros((5, 3)))
    place = before.setting.scene.centre_of_mass(before.grasp.rotation)
    np.testing.assert_allclose(tool.position, np.tile(place, (5, 1)), atol=1e-15)
