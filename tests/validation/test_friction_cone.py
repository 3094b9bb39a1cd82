"""The shape of each engine's friction cone, and that forces are told right in both shapes."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.exceptions import UnknownNameError
from pivotgait.validation import SimulatorOptions, make_simulator
from pivotgait.validation.simulator import FRICTION_CONES
from tests.validation.gantry_world import BOX_HEIGHT, SLIDE_MASS, box_tool, gantry_world

G, FRICTION, MASS = 9.81, 0.4, 0.2
DIAGONAL_SHARE = {
    ("pybullet", "elliptic"): 1.0,
    ("mujoco", "elliptic"): 1.0,
    ("pybullet", "pyramidal"): np.sqrt(2.0),
    ("mujoco", "pyramidal"): np.sqrt(0.5),
}
"""Of Coulomb's limit that a body withstands along a diagonal of the engine's axes."""


def pulled(name: str, cone: str, share: float, angle: float) -> tuple[float, np.ndarray]:
    """Way [m] of a box pulled with a share of Coulomb's limit, and the table's mean force [N]."""
    pull = share * FRICTION * G * np.array([np.cos(angle), np.sin(angle)])
    world = gantry_world(box_tool(MASS), tip_radius=0.3, gravity=(*pull, -G))
    holding = np.array([*(-3.0 * SLIDE_MASS * pull), SLIDE_MASS * G])
    with make_simulator(name, world, SimulatorOptions(friction_cone=cone)) as simulator:
        place = np.array([0.0, 0.0, 0.5 * BOX_HEIGHT])
        simulator.reset(np.array([0.0, 0.0, 1.0]), np.zeros(3), place, np.eye(3))
        forces = []
        for _ in range(300):
            simulator.step(holding)
            forces.append(simulator.state().pivot_force)
        way = simulator.state().tool_position[:2]
    # what the table gives to the end is what stops the box, whatever happens between
    return float(np.linalg.norm(way)), np.mean(forces, axis=0)


@pytest.mark.parametrize("cone", FRICTION_CONES)
@pytest.mark.parametrize("angle", [0.0, 0.25 * np.pi])
@pytest.mark.parametrize(("side", "slides"), [(0.95, False), (1.05, True)])
def test_the_threshold_is_that_of_the_shape(
    name: str, cone: str, angle: float, side: float, slides: bool
) -> None:
    threshold = DIAGONAL_SHARE[name, cone] if angle else 1.0
    way, force = pulled(name, cone, side * threshold, angle)
    assert (way > 0.5 * 0.5 * 0.05 * FRICTION * G * 0.3**2) == slides
    if not slides:  # what the table bears is what pulls and weighs
        pull = side * threshold * FRICTION * G * np.array([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(force, MASS * np.array([*-pull, G]), atol=0.02 * MASS * G)


def test_an_unknown_cone_is_told() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'elliptic'"):
        SimulatorOptions(friction_cone="eliptic")
