"""Coal's answers about the arm-hand: consistent, differentiable, never about NaN."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.benchmarks.relocation import Grip
from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.planning.collision import CollisionWorld

HOLDING = frozenset({"thumb", "index"})


def random_states(grip: Grip, count: int, seed: int = 0) -> list[tuple[Array, Array, Array]]:
    """Joint positions around home, with the knife in front of the arm."""
    rng, robot = np.random.default_rng(seed), grip.world.robot
    half = 0.5 * (robot.upper - robot.lower)
    states = []
    for _ in range(count):
        q = np.clip(robot.home + 0.6 * half * rng.normal(size=robot.nv), robot.lower, robot.upper)
        turn = Rotation.random(random_state=int(rng.integers(1 << 31))).as_matrix()
        states.append((q, turn, rng.uniform((0.5, -0.1, 0.1), (0.8, 0.1, 0.3))))
    return states


def test_free_agrees_with_the_smallest_distance(grip: Grip) -> None:
    world = grip.world.holding(HOLDING, padding=5e-4)
    verdicts = []
    for state in random_states(grip, 300):
        distance, _ = world.clearance(*state)
        verdicts.append(world.free(*state))
        assert verdicts[-1] == (distance > world.clearance_min + 5e-4)
    assert 30 < sum(verdicts) < 270


def test_the_tree_of_boxes_finds_what_all_pairs_find(grip: Grip) -> None:
    world = grip.world
    for state in random_states(grip, 200, seed=1):
        full = world._place(*state)
        model, data = world.bodies.model, world._data
        all_pairs = pin.computeCollisions(model, data, world._geometry, world._shapes, full, True)
        assert world.free(*state) == (not all_pairs)


def test_pairs_leave_out_neighbours_and_what_stands_on_the_table(grip: Grip) -> None:
    bodies = grip.world.bodies
    for pair in bodies.geometry.collisionPairs:
        joints = [bodies.geometry.geometryObjects[k].parentJoint for k in (pair.first, pair.second)]
        names = {bodies.names[pair.first], bodies.names[pair.second]}
        assert joints[0] != joints[1]
        assert bodies.model.parents[joints[0]] != joints[1] or joints[1] == 0
        assert not ("table" in names and names & {"pedestal", "arm_base"})


def test_gradients_are_those_of_finite_differences(grip: Grip) -> None:
    world, step = grip.world.holding(HOLDING), 2e-4
    rng, compared = np.random.default_rng(2), 0
    for q, turn, position in random_states(grip, 12, seed=3):
        direction = rng.normal(size=len(q))
        here, ahead, behind = (
            world.near(q + k * step * direction, turn, position, below=0.02) for k in (0, 1, -1)
        )
        if not len(here) == len(ahead) == len(behind):
            continue
        for (_, gradient), (more, _), (less, _) in zip(here, ahead, behind, strict=True):
            assert (more - less) / (2 * step) == pytest.approx(gradient @ direction, abs=2e-2)
            compared += 1
    assert compared > 30


def test_near_has_every_pair_below(grip: Grip) -> None:
    world = grip.world.holding(HOLDING)
    for state in random_states(grip, 40, seed=4):
        distance, _ = world.clearance(*state)
        found = world.near(*state, below=0.01)
        assert min((d for d, _ in found), default=np.inf) == pytest.approx(
            distance if distance < 0.01 else np.inf, abs=1e-6
        )


def test_only_the_tips_that_hold_may_touch_the_tool(grip: Grip) -> None:
    state = (grip.q, *grip.tool.pose(0.0))
    assert grip.world.holding({"thumb", "index", "middle"}).free(*state)
    for finger, tip in (("thumb", "thtip"), ("index", "fftip"), ("middle", "mftip")):
        world = grip.world.holding({"thumb", "index", "middle"} - {finger})
        distance, pair = world.clearance(*state)
        assert not world.free(*state)
        assert distance == pytest.approx(0.0, abs=1e-6)
        assert tip in pair
        assert world.tip_gap(finger, *state) == pytest.approx(0.0, abs=1e-6)


def test_the_table_is_seen(grip: Grip) -> None:
    high = CollisionWorld(grip.world.robot, grip.world.tool, 0.3, 1e-3)
    distance, pair = high.clearance(grip.q, *grip.tool.pose(0.0))
    assert distance < 0.0
    assert "table" in pair


def test_worlds_are_made_once(grip: Grip) -> None:
    assert grip.world.holding(HOLDING) is grip.world.holding(set(HOLDING))
    assert grip.world.holding(frozenset()) is grip.world


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["q", "turn", "position"])
@pytest.mark.parametrize("question", ["free", "clearance", "near"])
def test_poses_that_are_not_finite_are_refused(
    grip: Grip, bad: float, where: str, question: str
) -> None:
    state = {"q": grip.q.copy(), "turn": grip.tool.oRtool.copy()}
    state["position"] = grip.tool.position.copy()
    state[where].flat[1] = bad
    with pytest.raises(InputError):
        getattr(grip.world, question)(*state.values())
    assert grip.world.holding(set(grip.holds)).free(grip.q, *grip.tool.pose(0.0))


def test_bad_input(grip: Grip) -> None:
    turn, position = grip.tool.pose(0.0)
    with pytest.raises(InputError, match="no rotation"):
        grip.world.free(grip.q, 1.01 * turn, position)
    with pytest.raises(InputError, match="shape"):
        grip.world.free(grip.q[:-1], turn, position)
    with pytest.raises(UnknownNameError, match="ring"):
        grip.world.holding({"ring"})
    with pytest.raises(UnknownNameError, match="ring"):
        grip.world.tip_gap("ring", grip.q, turn, position)
    with pytest.raises(InputError, match="padding"):
        grip.world.holding({"thumb"}, padding=-1.0)
    for height, clearance in ((np.nan, 0.001), (0.0, -0.001), (0.0, np.nan)):
        with pytest.raises(InputError):
            CollisionWorld(grip.world.robot, grip.world.tool, height, clearance)
