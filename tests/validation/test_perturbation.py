"""Draws, the tool as it really is, and sensors as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError, SceneError
from pivotgait.models import Scene, load_scene, parse_scene
from pivotgait.models.validation_config import ValidationConfig
from pivotgait.plans import GaitPlan
from pivotgait.validation import ForceSensing, Perturbation, SimulatorState, TrialOptions
from pivotgait.validation.moved_scene import moved
from pivotgait.validation.perturbation import size_of_errors
from pivotgait.validation.real_tool import real_tool
from pivotgait.validation.sensing import Sensors

SEEDS = range(200)


def test_draws_stay_within_the_scene(scene: Scene) -> None:
    config, robot = ValidationConfig(), scene.robot
    draws = [Perturbation.draw(config, robot, seed) for seed in SEEDS]
    half_widths = {
        "mass_scale": (1.0, config.mass_share),
        "finger_friction_scale": (1.0, config.friction_share),
        "table_friction_scale": (1.0, config.friction_share),
        "handle_growth": (0.0, config.handle_width_m),
    }
    for name, (centre, half_width) in half_widths.items():
        values = np.array([getattr(draw, name) for draw in draws]) - centre
        assert np.abs(values).max() <= half_width
        # uniform: fills its range and leans to no side
        assert np.ptp(values) > 1.9 * half_width
        assert abs(values.mean()) < 0.2 * half_width
    laid = np.abs([draw.laid for draw in draws]).max(axis=0)
    assert (laid <= [0.005, 0.005, np.radians(3.0)]).all()
    angles = [Rotation.from_matrix(t).magnitude() for d in draws for t in d.sensing.turn.values()]
    assert np.radians(28.0) < max(angles) <= np.radians(30.0)
    assert all((draw.joint_friction >= 0.0).all() for draw in draws)


def test_a_seed_is_a_draw(scene: Scene) -> None:
    config = ValidationConfig()
    one, same, other = (Perturbation.draw(config, scene.robot, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(one.laid, same.laid)
    assert one.mass_scale == same.mass_scale != other.mass_scale


def errors(draw: Perturbation) -> np.ndarray:
    """Every error of a draw, each 0 in a world as planned."""
    sensing = draw.sensing
    scales = [draw.mass_scale, draw.finger_friction_scale, draw.table_friction_scale]
    turns = [Rotation.from_matrix(turn).as_rotvec() for turn in sensing.turn.values()]
    single = [draw.handle_growth, sensing.noise, sensing.delay_s]
    gains = [gain - 1.0 for gain in sensing.gain.values()]
    parts = [draw.offset, np.array(scales) - 1.0, single, gains, draw.joint_friction, *turns]
    return np.concatenate(parts)


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 2.5])
def test_every_error_grows_alike(scene: Scene, factor: float) -> None:
    for seed in range(2000, 2010):
        draw = Perturbation.draw(ValidationConfig(), scene.robot, seed)
        larger = draw.enlarged(factor)
        np.testing.assert_allclose(errors(larger), factor * errors(draw), rtol=1e-9, atol=1e-12)
        # where the tool lies is planned for
        np.testing.assert_array_equal(larger.laid, draw.laid)
        assert larger.seed == seed


@pytest.mark.parametrize("factor", [-0.1, 20.0, np.nan])
def test_errors_leave_a_world(scene: Scene, factor: float) -> None:
    draw = Perturbation.draw(ValidationConfig(), scene.robot, 2000)
    with pytest.raises(InputError, match="times as large"):
        draw.enlarged(factor)


def test_sizes_of_errors_fill_their_range(scene: Scene) -> None:
    sizes = np.array([size_of_errors(seed, 2.5) for seed in SEEDS])
    assert sizes.min() >= 1.0
    assert sizes.max() <= 2.5
    assert np.ptp(sizes) > 1.4
    assert sizes.mean() == pytest.approx(1.75, abs=0.1)


def test_a_trial_has_errors_of_its_size(scene: Scene) -> None:
    usual = TrialOptions().perturbation(scene, scene.robot, 2001)
    larger = TrialOptions(errors_up_to=2.5).perturbation(scene, scene.robot, 2001)
    drawn = Perturbation.draw(scene.config.validation, scene.robot, 2001)
    np.testing.assert_array_equal(errors(usual), errors(drawn))
    size = size_of_errors(2001, 2.5)
    np.testing.assert_allclose(errors(larger), size * errors(drawn), rtol=1e-9, atol=1e-12)
    none = TrialOptions(perturbed=False, errors_up_to=2.5).perturbation(scene, scene.robot, 2001)
    np.testing.assert_array_equal(errors(none), 0.0)


def test_the_scene_says_how_much(scene: Scene) -> None:
    text = scene.yaml + "validation: {mass_share: 0.0, laid_m: 0.0}\n"
    config = parse_scene(text).config.validation
    draw = Perturbation.draw(config, scene.robot, 3)
    assert draw.mass_scale == 1.0
    np.testing.assert_array_equal(draw.laid[:2], 0.0)
    with pytest.raises(SceneError, match="mass_share"):
        parse_scene(scene.yaml + "validation: {mass_share: 1.5}\n")
    with pytest.raises(SceneError, match="unknown"):
        parse_scene(scene.yaml + "validation: {mas_share: 0.1}\n")


def test_the_unperturbed_tool_is_the_plans(plan: GaitPlan, scene: Scene) -> None:
    real = real_tool(plan, scene, Perturbation.none(scene.robot))
    assert real.tool.mass == scene.tool.mass
    np.testing.assert_allclose(real.position, plan.phases[0].tool.position[0], atol=1e-9)
    planned = plan.phases[0].tool.rotation[0].as_matrix()
    np.testing.assert_allclose(real.rotation, planned, atol=1e-9)


@pytest.mark.parametrize("name", ["knife", "screwdriver"])
@pytest.mark.parametrize("growth", [-1e-3, 1e-3])
def test_a_wider_handle_moves_its_surface(name: str, growth: float) -> None:
    scene = load_scene(name)
    robot = scene.robot
    start = type("Start", (), {})  # only the first tool pose of a plan is read

    def phase() -> object:
        motion = type("Motion", (), {})()
        motion.position = scene.rest_position[None]
        holder = start()
        holder.tool = motion
        return holder

    plan = type("Plan", (), {})()
    plan.phases, plan.table_height = (phase(),), scene.table.height
    draw = replace(Perturbation.none(robot), handle_growth=growth, mass_scale=1.1)
    real = real_tool(plan, scene, draw)
    for contact in scene.config.contacts.values():
        place = (contact.along_m, np.radians(contact.around_deg))
        before, after = scene.tool.place(*place), real.tool.place(*place)
        out = -(after.point - before.point) @ before.normal
        assert out == pytest.approx(0.5 * growth, abs=1e-6)
    assert real.tool.mass == pytest.approx(1.1 * scene.tool.mass)
    np.testing.assert_allclose(real.tool.inertia, 1.1 * scene.tool.inertia)
    # it lies on the table, neither above nor in it
    assert float(real.tool.height(real.rotation)) == pytest.approx(0.0, abs=1e-9)
    tip = real.position + real.rotation @ real.tool.pivot_in_tool
    assert tip[2] == pytest.approx(scene.table.height + scene.tool.tip_radius)


def test_an_offset_turns_about_the_centre_of_mass(plan: GaitPlan, scene: Scene) -> None:
    none = Perturbation.none(scene.robot)
    exact = real_tool(plan, scene, none)
    offset = np.array([1e-3, -2e-3, np.radians(1.0)])
    real = real_tool(plan, scene, replace(none, offset=offset))
    np.testing.assert_allclose(real.position - exact.position, [1e-3, -2e-3, 0.0], atol=1e-12)
    turn = Rotation.from_matrix(real.rotation @ exact.rotation.T).as_rotvec()
    np.testing.assert_allclose(turn, [0.0, 0.0, offset[2]], atol=1e-12)


def test_a_moved_scene_is_the_scene_moved(scene: Scene) -> None:
    laid = np.array([0.004, -0.003, np.radians(2.0)])
    other = moved(scene, laid)
    np.testing.assert_allclose(other.pivot - scene.pivot, [0.004, -0.003, 0.0], atol=1e-12)
    turn = (other.rest_rotation * scene.rest_rotation.inv()).as_rotvec()
    np.testing.assert_allclose(turn, [0.0, 0.0, laid[2]], atol=1e-12)
    assert other.tool.urdf == scene.tool.urdf
    assert other.robot.urdf == scene.robot.urdf


def state(force: np.ndarray, nv: int) -> SimulatorState:
    return SimulatorState(
        time=0.0,
        q=np.zeros(nv),
        v=np.zeros(nv),
        tool_position=np.array([0.3, 0.0, 0.1]),
        tool_rotation=np.eye(3),
        tool_linear_velocity=np.zeros(3),
        tool_angular_velocity=np.zeros(3),
        finger_force={"thumb": force},
        finger_point={},
        pivot_force=np.zeros(3),
        unwanted=(),
    )


def sensors(scene: Scene, sensing: ForceSensing, **values: object) -> Sensors:
    draw = replace(Perturbation.none(scene.robot), sensing=sensing, **values)
    return Sensors(draw, ("thumb",), 1e-3)


def test_readings_have_gain_direction_and_delay(scene: Scene) -> None:
    turn = Rotation.from_rotvec([0.0, 0.0, 0.5]).as_matrix()
    found = sensors(scene, ForceSensing({"thumb": 1.2}, {"thumb": turn}, delay_s=0.003))
    forces = [np.array([float(k), 1.0, 0.0]) for k in range(8)]
    read = [found.read(0.001 * k, state(f, 19)).force["thumb"] for k, f in enumerate(forces)]
    for k in range(3, 8):
        np.testing.assert_allclose(read[k], 1.2 * turn @ forces[k - 3], atol=1e-15)


def test_noise_has_its_size_and_seed(scene: Scene) -> None:
    sensing = ForceSensing({"thumb": 1.0}, {"thumb": np.eye(3)}, noise=0.05)

    def read(seed: int) -> np.ndarray:
        found = sensors(scene, sensing, seed=seed)
        return np.array([found.read(0.0, state(np.ones(3), 19)).force["thumb"] for _ in range(900)])

    one = read(1)
    assert one.std() == pytest.approx(0.05, rel=0.1)
    assert abs(one.mean() - 1.0) < 0.005
    np.testing.assert_array_equal(one, read(1))
    assert np.any(one != read(2))


def test_the_camera_shares_the_planners_error(scene: Scene) -> None:
    exact = ForceSensing({"thumb": 1.0}, {"thumb": np.eye(3)})
    offset = np.array([1e-3, 2e-3, 0.01])
    seen = sensors(scene, exact, offset=offset).read(0.0, state(np.zeros(3), 19))
    np.testing.assert_allclose(seen.tool_position, [0.299, -0.002, 0.1], atol=1e-15)
    turn = Rotation.from_matrix(seen.tool_rotation).as_rotvec()
    np.testing.assert_allclose(turn, [0.0, 0.0, -0.01], atol=1e-12)
