"""Laws of a planned relocation, and what is said when there is none."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.benchmarks.relocation import Grip
from pivotgait.exceptions import InfeasibleError, InputError, UnknownNameError
from pivotgait.kinematics import ClosedChain, project
from pivotgait.planning.problem import RelocationOptions, RelocationProblem
from pivotgait.planning.relocation import plan_relocation
from pivotgait.planning.tool_path import PivotingTool
from tests.planning.solved import SEED, Solved

ON_HOLD = 1e-7
"""Largest error of a holding tip's place [m]."""


def tip_in_tool(solved: Solved, q: np.ndarray, k: int) -> np.ndarray:
    robot, trajectory = solved.problem.robot, solved.trajectory
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    frame = robot.fingers[solved.problem.finger].tip_frame_id
    tip = pin.updateFramePlacement(robot.model, data, frame).translation
    return trajectory.tool.rotation[k].as_matrix().T @ (tip - trajectory.tool.position[k])


def test_it_is_found_and_says_so(solved: Solved) -> None:
    plan = solved.plan
    assert plan.found
    assert plan.failure == ""
    assert plan.nearest == 0.0
    assert plan.length_found > 0.0
    assert plan.summary()["found"] is True
    assert sum(plan.times_s.values()) < 5.0


def test_it_goes_from_start_to_goal(solved: Solved) -> None:
    for q in (solved.trajectory.q, solved.plan.q):
        np.testing.assert_allclose(q[0], solved.problem.start, atol=1e-8)
        np.testing.assert_allclose(q[-1], solved.problem.goal, atol=1e-8)


def test_holding_tips_stay(solved: Solved) -> None:
    problem, trajectory = solved.problem, solved.trajectory
    chain = ClosedChain(problem.robot, problem.holds)
    lengths = chain.row_lengths()
    for k, q in enumerate(trajectory.q):
        chain.update(q, trajectory.tool.rotation[k].as_matrix(), trajectory.tool.position[k])
        assert np.abs(chain.residual * lengths).max() < ON_HOLD
    assert trajectory.drift < 1e-5


def test_speed_and_acceleration_are_tangent(solved: Solved) -> None:
    problem, trajectory = solved.problem, solved.trajectory
    chain = ClosedChain(problem.robot, problem.holds)
    for k, q in enumerate(trajectory.q):
        chain.update(q, trajectory.tool.rotation[k].as_matrix(), trajectory.tool.position[k])
        twist = trajectory.tool.linear_velocity[k], trajectory.tool.angular_velocity[k]
        rate = chain.jacobian @ trajectory.v[k] - chain.target_rate(*twist)
        change = twist[0], twist[1], trajectory.tool.linear_acceleration[k]
        bias = chain.bias(trajectory.v[k], *change, trajectory.tool.angular_acceleration[k])
        assert np.abs(rate).max() < 1e-10
        assert np.abs(chain.jacobian @ trajectory.a[k] - bias).max() < 1e-9


def test_it_is_at_rest_at_both_ends(solved: Solved) -> None:
    for rates in (solved.trajectory.v, solved.trajectory.a):
        np.testing.assert_allclose(rates[[0, -1]], 0.0, atol=1e-9)


def test_speed_and_acceleration_are_derivatives(solved: Solved) -> None:
    """Hermite's rule, which is of fourth order, joins each sample to the next."""
    t = solved.trajectory
    h = t.time[1] - t.time[0]
    np.testing.assert_allclose(np.diff(t.time), h, rtol=1e-9)
    predicted = 0.5 * h * (t.v[1:] + t.v[:-1]) + h**2 / 12.0 * (t.a[:-1] - t.a[1:])
    assert np.abs(np.diff(t.q, axis=0) - predicted).max() < 1e-5
    # C2: accelerations change by little from sample to sample.
    assert np.abs(np.diff(t.a, axis=0)).max() < 0.35 * solved.problem.robot.acceleration_max.max()


def test_limits(solved: Solved) -> None:
    robot, options, t = solved.problem.robot, solved.problem.options, solved.trajectory
    assert robot.within_limits(t.q, slack=1e-9)
    assert np.all(np.abs(t.v) <= options.speed_share * robot.velocity_max * (1 + 1e-9))
    bound = options.acceleration_share * robot.acceleration_max
    assert np.all(np.abs(t.a) <= bound * (1 + 1e-9))
    assert max(t.speed_share, t.acceleration_share) > 0.5


def test_nothing_comes_nearer_than_the_clearance(solved: Solved) -> None:
    """At ten times the samples: only near its contacts may the moving tip, and it never enters."""
    problem, t = solved.problem, solved.trajectory
    world = problem.world.holding(problem.holding)
    touching = problem.world.holding(problem.holding | {problem.finger})
    touches = [
        tip_in_tool(solved, t.q[k], k)
        for k, normal in ((0, problem.start_normal), (-1, problem.goal_normal))
        if normal is not None
    ]
    for k in range(len(t.time) - 1):
        for share in np.linspace(0.0, 1.0, 10, endpoint=False):
            q = (1.0 - share) * t.q[k] + share * t.q[k + 1]
            state = q, t.tool.rotation[k].as_matrix(), t.tool.position[k]
            if world.free(*state):
                continue
            tip = tip_in_tool(solved, q, k)
            assert min(np.linalg.norm(tip - touch) for touch in touches) <= 0.005
            assert touching.clearance(*state)[0] >= world.clearance_min
            assert world.tip_gap(problem.finger, *state) >= -2e-6


def test_shortcuts_do_not_lengthen(solved: Solved) -> None:
    plan = solved.plan
    normals = (solved.problem.start_normal, solved.problem.goal_normal)
    ends = sum(normal is not None for normal in normals)
    # The ways along the normals come on top of what the search found.
    assert plan.length <= plan.length_found + 0.08 * ends


def test_the_same_seed_gives_the_same_plan(solved: Solved) -> None:
    again = plan_relocation(solved.problem, np.random.default_rng(SEED))
    np.testing.assert_array_equal(again.require().q, solved.trajectory.q)


def test_a_blocked_way_needs_the_trees(problems: dict[str, RelocationProblem]) -> None:
    blocked = problems["middle, straight way blocked"]
    plan = plan_relocation(blocked, np.random.default_rng(SEED))
    assert plan.iterations > 0
    assert min(plan.nodes) > 1
    assert plan.counts["collision"] > 0


def test_a_turning_tool_is_followed(grip: Grip, first_contact: RelocationProblem) -> None:
    turn, position = grip.tool.pose(0.0)
    pivot = position + turn @ grip.world.tool.pivot_in_tool
    tool = PivotingTool(turn, position, pivot, np.radians((0.5, 1.5, -1.0)))
    chain = ClosedChain(grip.world.robot, tuple(grip.holds.values()))
    near_limit = [grip.world.robot.joint_names.index(name) for name in ("WRJ2", "MFJ1")]
    goal = project(chain, grip.q, *tool.pose(1.0), fixed=near_limit)
    assert goal.converged
    problem = replace(first_contact, tool=tool, goal=goal.q)
    plan = plan_relocation(problem, np.random.default_rng(SEED))
    solved = Solved(problem, plan)
    t = solved.trajectory
    assert (t.s[0], t.s[-1]) == (0.0, 1.0)
    assert np.all(np.diff(t.s) >= -1e-12)
    assert np.any(t.tool.angular_velocity)
    whole = (t.tool.rotation[-1] * t.tool.rotation[0].inv()).as_rotvec()
    np.testing.assert_allclose(whole, tool.turn, atol=1e-9)
    for law in (
        test_it_goes_from_start_to_goal,
        test_holding_tips_stay,
        test_speed_and_acceleration_are_tangent,
        test_speed_and_acceleration_are_derivatives,
        test_it_is_at_rest_at_both_ends,
        test_limits,
        test_nothing_comes_nearer_than_the_clearance,
    ):
        law(solved)


def test_a_start_in_collision_is_named(first_contact: RelocationProblem) -> None:
    start = first_contact.start.copy()
    columns = first_contact.robot.fingers["middle"].columns
    start[list(columns)] = (0.0, 0.5, 0.8, 0.7)
    with pytest.raises(InfeasibleError, match=r"start: .*mm from") as caught:
        plan_relocation(replace(first_contact, start=start), np.random.default_rng(0))
    assert "mf" in caught.value.what


def test_a_start_off_its_holds_is_refused(first_contact: RelocationProblem) -> None:
    start = first_contact.start.copy()
    start[2] -= 1e-4
    with pytest.raises(InputError, match="off its hold"):
        plan_relocation(replace(first_contact, start=start), np.random.default_rng(0))


def test_a_posture_beyond_limits_is_named(first_contact: RelocationProblem) -> None:
    goal = first_contact.goal.copy()
    goal[first_contact.robot.joint_names.index("MFJ3")] = 1.6
    with pytest.raises(InfeasibleError, match="MFJ3"):
        plan_relocation(replace(first_contact, goal=goal), np.random.default_rng(0))


def test_a_contact_that_cannot_be_left_outward(first_contact: RelocationProblem) -> None:
    assert first_contact.goal_normal is not None
    wrong = replace(first_contact, goal_normal=-first_contact.goal_normal)
    plan = plan_relocation(wrong, np.random.default_rng(0))
    assert not plan.found
    assert "approach along the normal: collision binds" in plan.failure
    assert plan.nearest > 0.0
    with pytest.raises(InfeasibleError, match="collision binds"):
        plan.require()


def curled(problem: RelocationProblem, **options: float) -> RelocationProblem:
    """The middle finger curled up between palm and handle, inside the ring of the others."""
    start = problem.start.copy()
    start[list(problem.robot.fingers["middle"].columns)] = (-0.33, 1.52, 0.11, 0.01)
    return replace(problem, start=start, options=RelocationOptions(**options))


def test_a_finger_gets_out_of_the_ring(first_contact: RelocationProblem) -> None:
    problem = curled(first_contact)
    solved = Solved(problem, plan_relocation(problem, np.random.default_rng(SEED)))
    test_holding_tips_stay(solved)
    test_limits(solved)
    test_nothing_comes_nearer_than_the_clearance(solved)


def test_a_search_that_fails_leaves_its_record(first_contact: RelocationProblem) -> None:
    plan = plan_relocation(curled(first_contact, max_nodes=30), np.random.default_rng(0))
    assert not plan.found
    assert plan.trajectory is None
    assert "search: node limit" in plan.failure
    assert "binds" in plan.failure
    assert min(plan.nodes) > 1
    assert plan.iterations > 0
    assert plan.nearest > 0.0
    assert plan.summary()["failure"] == plan.failure
    plan = plan_relocation(curled(first_contact, time_limit_s=1e-9), np.random.default_rng(0))
    assert "search: time limit, collision binds" in plan.failure
    plan = plan_relocation(curled(first_contact, max_iterations=3), np.random.default_rng(0))
    assert "search: iteration limit" in plan.failure
    assert plan.iterations == 3


@pytest.mark.parametrize("name", ["start", "goal"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_postures_that_are_not_finite(
    first_contact: RelocationProblem, name: str, bad: float
) -> None:
    q = first_contact.start.copy()
    q[4] = bad
    with pytest.raises(InputError, match=name):
        replace(first_contact, **{name: q})


def test_bad_problems(first_contact: RelocationProblem) -> None:
    with pytest.raises(UnknownNameError, match="ring"):
        replace(first_contact, finger="ring")
    with pytest.raises(InputError, match="moves and holds"):
        replace(first_contact, finger="thumb")
    with pytest.raises(InputError, match="unit vector"):
        replace(first_contact, goal_normal=np.ones(3))


@pytest.mark.parametrize(
    "wrong",
    [{"stride": 0.0}, {"sample_s": np.nan}, {"goal_bias": 1.5}, {"acceleration_share": 0.0}],
)
def test_bad_options(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError):
        RelocationOptions(**wrong)
