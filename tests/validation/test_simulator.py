"""What every simulator must do right, on worlds whose answer is known."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.validation import Simulator, SimulatorOptions, SimulatorState, World, make_simulator
from pivotgait.validation.simulator import TABLE_TOUCH, check_simulator
from tests.validation.gantry_world import (
    BOX_HEIGHT,
    HALF_BOX,
    SLIDE_MASS,
    TIP_RADIUS,
    ball_tool,
    box_tool,
    gantry_world,
)

G = 9.81
UPRIGHT = np.eye(3)
LIES = np.array([0.0, 0.0, 0.5 * BOX_HEIGHT])
AWAY = np.array([0.0, 0.0, 1.0])
EIGHT = [np.array([np.cos(a), np.sin(a)]) for a in np.arange(8) * np.pi / 4]
HELD = np.array([0.0, 0.0, SLIDE_MASS * G])


def run(
    name: str,
    world: World,
    *,
    q: np.ndarray = AWAY,
    place: np.ndarray = LIES,
    turn: np.ndarray = UPRIGHT,
    torque: np.ndarray = HELD,
    seconds: float = 0.3,
    options: SimulatorOptions | None = None,
) -> SimulatorState:
    with make_simulator(name, world, options or SimulatorOptions()) as simulator:
        simulator.reset(q, np.zeros(3), place, turn)
        for _ in range(round(seconds / simulator.step_s)):
            simulator.step(torque)
        return simulator.state()


@pytest.mark.parametrize("step", [2e-3, 1e-3, 2.5e-4])
def test_a_free_tool_falls(name: str, step: float) -> None:
    world = gantry_world(box_tool(0.2))
    options = SimulatorOptions(step_s=step)
    state = run(name, world, place=np.array([0.0, 0.0, 2.0]), options=options)
    assert state.time == pytest.approx(0.3)
    assert state.tool_linear_velocity[2] == pytest.approx(-G * 0.3, rel=1e-9)
    # Semi-implicit Euler falls half a step too far.
    fall = 0.5 * G * 0.3 * (0.3 + step)
    assert 2.0 - state.tool_position[2] == pytest.approx(fall, rel=1e-9)
    assert state.unwanted == ()


def test_a_spinning_tool_keeps_its_momentum(name: str) -> None:
    """No hidden damping: Bullet's default takes 4 % a second."""
    world = gantry_world(ball_tool(0.2, 0.02), gravity=(0.0, 0.0, 0.0))
    with make_simulator(name, world, SimulatorOptions()) as simulator:
        simulator.reset(AWAY, np.array([0.0, 0.1, 0.0]), np.array([0.0, 0.0, 3.0]), UPRIGHT)
        for _ in range(500):
            simulator.step(np.zeros(3))
        state = simulator.state()
    assert state.v[1] == pytest.approx(0.1, rel=1e-12)
    assert state.q[1] == pytest.approx(0.05, rel=1e-9)


@pytest.mark.parametrize("direction", EIGHT, ids=lambda d: f"{np.degrees(np.arctan2(*d)):.0f}")
@pytest.mark.parametrize(("share", "slides"), [(0.95, False), (1.05, True)])
def test_friction_of_the_table(
    name: str, direction: np.ndarray, share: float, slides: bool
) -> None:
    pull = share * 0.4 * G * direction
    world = gantry_world(box_tool(0.2), gravity=(*pull, -G))
    state = run(name, world, torque=np.array([*(-3 * SLIDE_MASS * pull), SLIDE_MASS * G]))
    moved = np.linalg.norm(state.tool_position[:2])
    # 5 % above the threshold the box gains 0.05 mu g.
    assert (moved > 0.5 * 0.5 * 0.05 * 0.4 * G * 0.3**2) == slides
    assert moved < 1e-4 or slides


@pytest.mark.parametrize("direction", EIGHT, ids=lambda d: f"{np.degrees(np.arctan2(*d)):.0f}")
@pytest.mark.parametrize(("share", "slides"), [(0.95, False), (1.05, True)])
def test_friction_of_a_fingertip(
    name: str, direction: np.ndarray, share: float, slides: bool
) -> None:
    press = 4.0
    world = gantry_world(box_tool(20.0), table_friction=1.0)
    q = np.array([0.0, 0.0, BOX_HEIGHT + TIP_RADIUS])
    push = share * 0.8 * press * direction
    with make_simulator(name, world, SimulatorOptions()) as simulator:
        simulator.reset(q, np.zeros(3), LIES, UPRIGHT)
        for step in range(400):  # press first, then push
            lateral = push if step >= 200 else np.zeros(2)
            simulator.step(np.array([*lateral, SLIDE_MASS * G - press]))
        state = simulator.state()
    # 5 % above the threshold 0.05 mu f_n accelerates up to three slides.
    gained = 0.05 * 0.8 * press / (3 * SLIDE_MASS) * 0.2
    assert (np.linalg.norm(state.v[:2]) > 0.5 * gained) == slides
    if not slides:  # the finger bears on the tool with what drives it
        assert np.linalg.norm(state.v[:2]) < 0.1 * gained
        np.testing.assert_allclose(state.finger_force["ball"], [*push, -press], atol=0.1)


@pytest.mark.parametrize("stiffness", [2e3, 1e4, 2e4])
def test_contacts_are_as_stiff_as_asked(name: str, stiffness: float) -> None:
    press = 4.0
    world = gantry_world(box_tool(20.0))
    q = np.array([0.0, 0.0, BOX_HEIGHT + TIP_RADIUS])
    torque = np.array([0.0, 0.0, SLIDE_MASS * G - press])
    options = SimulatorOptions(contact_stiffness=stiffness)
    state = run(name, world, q=q, torque=torque, options=options, seconds=0.6)
    surface = state.tool_position[2] + 0.5 * BOX_HEIGHT
    depth = surface + TIP_RADIUS - state.q[2]
    assert depth == pytest.approx(press / stiffness, abs=1.5e-5)


def test_hard_contacts_hardly_give(name: str) -> None:
    world = gantry_world(box_tool(20.0))
    q = np.array([0.0, 0.0, BOX_HEIGHT + TIP_RADIUS])
    torque = np.array([0.0, 0.0, SLIDE_MASS * G - 4.0])
    options = SimulatorOptions(contact_stiffness=None)
    state = run(name, world, q=q, torque=torque, options=options)
    depth = state.tool_position[2] + 0.5 * BOX_HEIGHT + TIP_RADIUS - state.q[2]
    assert abs(depth) < 5e-5
    np.testing.assert_allclose(state.finger_force["ball"], [0.0, 0.0, -4.0], atol=0.05)


def test_the_tip_bears_weight_and_finger(name: str) -> None:
    """Forces act on the tool: the table lifts it, the finger presses it down."""
    mass, radius, press = 0.3, 0.02, 2.0
    world = gantry_world(ball_tool(mass, radius), tip_radius=radius)
    q = np.array([0.0, 0.0, 2 * radius + TIP_RADIUS])
    torque = np.array([0.0, 0.0, SLIDE_MASS * G - press])
    state = run(name, world, q=q, place=np.array([0.0, 0.0, radius]), torque=torque)
    np.testing.assert_allclose(state.finger_force["ball"], [0.0, 0.0, -press], atol=1e-3)
    np.testing.assert_allclose(state.pivot_force, [0.0, 0.0, mass * G + press], atol=2e-3)
    np.testing.assert_allclose(state.finger_point["ball"], [0.0, 0.0, 2 * radius], atol=5e-4)
    assert state.unwanted == ()


def test_forces_are_those_that_moved_the_tool(name: str) -> None:
    """Newton's law over each step of a ball that a finger rolls over the table."""
    mass, radius = 0.3, 0.02
    world = gantry_world(ball_tool(mass, radius), tip_radius=radius)
    q = np.array([0.0, 0.0, 2 * radius + TIP_RADIUS])
    torque = np.array([0.3, 0.2, SLIDE_MASS * G - 2.0])
    errors, sideways = [], 0.0
    with make_simulator(name, world, SimulatorOptions()) as simulator:
        simulator.reset(q, np.zeros(3), np.array([0.0, 0.0, radius]), UPRIGHT)
        before = simulator.state().tool_linear_velocity
        for _ in range(100):
            simulator.step(torque)
            state = simulator.state()
            gained = mass * (state.tool_linear_velocity - before) / simulator.step_s
            before = state.tool_linear_velocity
            forces = state.finger_force["ball"] + state.pivot_force + mass * world.gravity
            errors.append(np.abs(gained - forces).max())
            sideways = max(sideways, float(np.hypot(*state.finger_force["ball"][:2])))
    # Bullet tells its impulses, single in precision at places; forces here are some newtons.
    assert max(errors) < 1e-6
    assert sideways > 0.05


def test_a_joint_stops_at_its_limit(name: str) -> None:
    """Driven on by 5 N, from 1 mm before the end of the slide."""
    q, force = np.array([9.999, 0.0, 1.0]), np.array([5.0, 0.0, 0.0])
    state = run(name, gantry_world(box_tool(0.2)), q=q, torque=HELD + force)
    assert state.q[0] == pytest.approx(10.0, abs=1e-4)
    assert abs(state.v[0]) < 1e-3


def test_a_box_on_the_table_is_named(name: str) -> None:
    state = run(name, gantry_world(box_tool(0.2)), seconds=0.05)
    assert state.unwanted == (TABLE_TOUCH,)
    np.testing.assert_array_equal(state.pivot_force, np.zeros(3))
    np.testing.assert_array_equal(state.finger_force["ball"], np.zeros(3))
    assert "ball" not in state.finger_point


def test_a_link_on_the_table_is_named(name: str) -> None:
    beside = np.array([0.5, 0.0, TIP_RADIUS])
    world = gantry_world(box_tool(0.2))
    state = run(name, world, q=beside, place=AWAY, torque=np.zeros(3), seconds=0.05)
    assert state.unwanted == ("ball - table",)
    np.testing.assert_array_equal(state.finger_force["ball"], np.zeros(3))


def test_what_diverges_is_seen(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither started anew in silence nor written into the user's folder."""
    monkeypatch.chdir(tmp_path)
    state = run(name, gantry_world(box_tool(0.2)), torque=np.full(3, np.nan), seconds=0.003)
    assert not np.isfinite(state.q).all()
    assert not list(tmp_path.iterdir())


def test_the_pose_is_that_of_the_tool_frame(name: str) -> None:
    """Whatever axes the engine keeps an inertia with products of inertia in."""
    turn = Rotation.from_euler("ZYX", [0.3, -0.2, 1.1]).as_matrix()
    place = np.array([0.1, -0.2, 1.5])
    world = gantry_world(box_tool(0.2, products=4e-4))
    with make_simulator(name, world, SimulatorOptions()) as simulator:
        simulator.reset(AWAY, np.zeros(3), place, turn)
        state = simulator.state()
    np.testing.assert_allclose(state.tool_rotation, turn, atol=1e-12)
    np.testing.assert_allclose(state.tool_position, place, atol=1e-15)


def test_dry_friction_holds_a_joint(name: str) -> None:
    world = gantry_world(box_tool(0.2), joint_friction=1.0)
    below, above = (
        run(name, world, torque=HELD + np.array([force, 0.0, 0.0]), seconds=0.2)
        for force in (0.9, 1.5)
    )
    assert abs(below.q[0]) < 1e-6
    # what is left of the force moves the mass of all three slides
    assert above.v[0] == pytest.approx(0.5 / (3 * SLIDE_MASS) * 0.2, rel=1e-3)


def test_same_input_same_state_bit_for_bit(name: str) -> None:
    world = gantry_world(box_tool(0.2, products=2e-4))
    turn = Rotation.from_euler("xyz", [0.2, 0.3, 0.1]).as_matrix()
    place = np.array([0.0, 0.0, HALF_BOX + 0.1])
    q = np.array([0.01, 0.0, 0.3])
    one, two = (run(name, world, q=q, place=place, turn=turn, torque=np.zeros(3)) for _ in range(2))
    assert one.unwanted == two.unwanted
    for field in ("q", "v", "tool_position", "tool_rotation", "tool_angular_velocity"):
        np.testing.assert_array_equal(getattr(one, field), getattr(two, field))


def test_engines_live_side_by_side(name: str) -> None:
    """A simulator never touches the world of another."""
    options = SimulatorOptions()
    world = gantry_world(box_tool(0.2))

    def falls(simulator: Simulator) -> float:
        simulator.reset(AWAY, np.zeros(3), np.array([0.0, 0.0, 2.0]), UPRIGHT)
        for _ in range(10):
            simulator.step(HELD)
        return float(simulator.state().tool_position[2])

    with make_simulator(name, world, options) as alone:
        expected = falls(alone)
    with make_simulator(name, world, options) as one, make_simulator(name, world, options) as two:
        assert falls(one) == falls(two) == expected


@pytest.mark.parametrize(
    "values",
    [{"step_s": 0.0}, {"step_s": 1.0}, {"step_s": float("nan")}, {"contact_stiffness": -1.0}],
)
def test_bad_options_are_refused(values: dict[str, float]) -> None:
    with pytest.raises(InputError):
        SimulatorOptions(**values)


def test_missing_simulators_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)  # as if it were not installed
    with pytest.raises(InputError) as caught:
        make_simulator("mujoco", gantry_world(box_tool(0.2)), SimulatorOptions())
    said = "simulator: mujoco is not installed - pip install 'pivotgait[mujoco]'"
    assert str(caught.value) == said
    check_simulator("pybullet")


def test_unknown_simulators_are_told() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'pybullet'"):
        check_simulator("pybulet")
