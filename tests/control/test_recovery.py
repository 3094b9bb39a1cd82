"""Recovery: margins as certified, thresholds, balanced forces, time that runs back, no change."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.contacts import friction_margin
from pivotgait.control import (
    HybridController,
    Measurement,
    RecoveringController,
    RecoveryOptions,
    Reference,
)
from pivotgait.control.grasp_monitor import GraspMonitor
from pivotgait.control.plan_clock import PACE_CHANGE, PlanClock
from pivotgait.control.put_back import PutBack
from pivotgait.control.reallocation import Reallocation, least_margin
from pivotgait.control.threshold import Threshold
from pivotgait.exceptions import InputError
from pivotgait.forces import allocate
from pivotgait.frozen import Array
from pivotgait.gaits import plan_gait
from pivotgait.models import load_scene

Read = Callable[..., Measurement]
PERIOD = 1e-3
UNGUARDED = RecoveryOptions(reallocate_below=-1e9, put_back_below=-1e9)


@pytest.fixture(scope="module")
def gait() -> Reference:
    """The knife's gait: planned forces that carry it."""
    return Reference.of(plan_gait(load_scene("knife")))


@pytest.fixture(scope="module")
def law_of_gait(gait: Reference) -> HybridController:
    return HybridController(gait)


@pytest.fixture(scope="module")
def law(reference: Reference) -> HybridController:
    return HybridController(reference)


@pytest.mark.parametrize("time", [0.1, 0.3, 0.5])
def test_margins_of_exact_readings_are_those_of_the_plan(
    reference: Reference, law: HybridController, read: Read, time: float
) -> None:
    monitor = GraspMonitor(reference, lag_s=0.0, orientation_deg=5.0)
    wanted = reference.at(time)
    task = law.tasks[wanted.phase]
    found = monitor.margins(task, wanted, read(time))
    phase = reference.phases[wanted.phase]
    tracks = [phase.samples.contacts[name] for name in found.fingers]
    assert phase.samples.finger not in found.fingers
    place = [task.finger_names.index(name) for name in found.fingers]
    force = wanted.force_in_tool[place]
    normals = np.array([track.normal for track in tracks])
    certified = friction_margin(force, normals, np.array([track.friction for track in tracks]))
    np.testing.assert_allclose(found.friction, certified, atol=1e-12)
    least = np.array([max(track.normal_min, 1e-9) for track in tracks])
    np.testing.assert_allclose(found.pressing, np.sum(force * normals, axis=1) / least, rtol=1e-9)
    assert found.orientation == pytest.approx(1.0, abs=1e-6)


def test_a_finger_without_force_and_a_turned_tool_have_no_margin(
    reference: Reference, law: HybridController, read: Read
) -> None:
    monitor = GraspMonitor(reference, lag_s=0.0, orientation_deg=5.0)
    wanted, exact = reference.at(0.3), read(0.3)
    task = law.tasks[wanted.phase]
    name = monitor.margins(task, wanted, exact).fingers[-1]
    lost = exact._replace(force={**exact.force, name: np.zeros(3)})
    assert monitor.margins(task, wanted, lost).least() == (name, -1.0)
    turn = Rotation.from_rotvec(np.radians([0.0, 5.0, 0.0])).as_matrix()
    turned = exact._replace(tool_rotation=turn @ exact.tool_rotation)
    assert monitor.margins(task, wanted, turned).orientation == pytest.approx(0.0, abs=1e-6)


def test_the_low_pass_follows_a_step_with_its_time_constant(
    reference: Reference, law: HybridController, read: Read
) -> None:
    monitor = GraspMonitor(reference, lag_s=0.02, orientation_deg=5.0)
    base = read(0.3)
    task, wanted = law.tasks[0], reference.at(0.3)
    pressing = []
    for cycle in range(101):
        share = 1.0 if cycle == 0 else 0.5
        force = {name: share * each for name, each in base.force.items()}
        reading = base._replace(time=cycle * PERIOD, force=force)
        pressing.append(monitor.margins(task, wanted, reading).pressing[0])
    left = (np.array(pressing) / pressing[0] - 0.5) / 0.5
    assert left[20] == pytest.approx(np.exp(-1.0), abs=0.02)
    assert left[100] < 0.01


def test_a_threshold_waits_and_has_hysteresis() -> None:
    threshold = Threshold(0.3, 0.1, lasting_s=0.02)
    values = [0.5] * 5 + [0.2] * 10 + [0.5] * 5 + [0.2] * 30 + [0.35] * 50 + [0.45] * 30
    states = [threshold.update(value, k * PERIOD) for k, value in enumerate(values)]
    assert not any(states[:40])  # short dips do not count
    assert states.index(True) == 40
    assert all(states[40:100])  # between the thresholds nothing changes
    assert not states[-1]


@pytest.mark.parametrize("phase", [0, 2, 3, 4, 5])
@pytest.mark.parametrize("off_deg", [0.0, 1.0])
def test_forces_allocated_anew_balance_the_measured_tool(
    gait: Reference, law_of_gait: HybridController, phase: int, off_deg: float
) -> None:
    reference, plan = gait.phases[phase], gait.plan
    wanted, task = gait.at(reference.start + 0.3), law_of_gait.tasks[phase]
    turn = Rotation.from_rotvec(np.radians([0.0, off_deg, 0.0])).as_matrix()
    rotation = turn @ wanted.tool.rotation
    problem = Reallocation(gait, 1.6).problem(task, wanted, rotation)
    found = allocate(problem, "clarabel").require().force[0, 1:] @ rotation
    normal = np.sum(found * task.normals_in_tool, axis=1)
    across = found - normal[:, None] * task.normals_in_tool
    contacts = reference.samples.contacts
    tracks = [contacts[name] for name in task.finger_names]
    assert all(
        np.linalg.norm(each) <= track.friction * size + 1e-7
        for each, size, track in zip(across, normal, tracks, strict=True)
    )
    assert np.all(normal <= [track.normal_max + 1e-7 for track in tracks])
    # What is left for the table passes through the pivot, and lies in its cone.
    tool, inertia = wanted.tool, rotation @ plan.tool.inertia @ rotation.T
    table = plan.tool.mass * (tool.linear_acceleration - plan.gravity) - (found @ rotation.T).sum(0)
    moment = np.cross(task.contacts_in_tool, found).sum(axis=0) @ rotation.T
    moment = moment + np.cross(rotation @ plan.tool.pivot_in_tool, table)
    omega = tool.angular_velocity
    turning = inertia @ tool.angular_acceleration + np.cross(omega, inertia @ omega)
    np.testing.assert_allclose(moment, turning, atol=1e-7)
    assert np.hypot(*table[:2]) <= contacts["pivot"].friction * table[2] + 1e-7


@pytest.mark.parametrize("phase", range(6))
def test_forces_are_taken_only_if_their_margin_is_larger(
    gait: Reference, law_of_gait: HybridController, phase: int
) -> None:
    task, reference = law_of_gait.tasks[phase], gait.phases[phase]
    wanted = gait.at(reference.start + 0.5 * reference.duration)
    found = Reallocation(gait, 1.6).forces(task, wanted, wanted.tool.rotation)
    planned = least_margin(task, wanted.force_in_tool)
    assert found is None or least_margin(task, found) > planned


def test_nothing_changes_without_a_trigger(reference: Reference, read: Read) -> None:
    plain = HybridController(reference)
    guarded = RecoveringController(HybridController(reference), UNGUARDED)
    plain.reset()
    guarded.reset()
    for time in np.arange(0.0, 1.2, 0.013).tolist():
        measured = read(time, off=1e-3)
        assert np.array_equal(plain.torque(measured), guarded.torque(measured))
    assert guarded.events == ()


def test_a_small_margin_moves_the_forces_without_a_jump(
    gait: Reference, law_of_gait: HybridController
) -> None:
    guarded = RecoveringController(law_of_gait)
    start = gait.phases[2].start + 0.2
    forces = _followed(guarded)
    turn = Rotation.from_rotvec(np.radians([0.0, 4.5, 0.0])).as_matrix()
    for cycle in range(400):
        time = start + cycle * PERIOD
        wanted = gait.at(time)
        names = guarded.law.tasks[wanted.phase].finger_names
        force = wanted.force_in_tool @ wanted.tool.rotation.T
        guarded.torque(
            Measurement(
                time,
                wanted.q,
                wanted.v,
                dict(zip(names, force, strict=True)),
                wanted.tool.position,
                turn @ wanted.tool.rotation if cycle > 50 else wanted.tool.rotation,
                wanted.tool.linear_velocity,
                wanted.tool.angular_velocity,
            )
        )
    change = np.array([f - gait.at(start + k * PERIOD).force_in_tool for k, f in enumerate(forces)])
    assert np.abs(change[:50]).max() == 0.0
    assert np.abs(change[-1]).max() > 0.1
    assert np.abs(np.diff(change, axis=0)).max() < 0.1
    (event,) = guarded.events
    assert (event.measure, event.finger) == ("reallocate", "tool")
    assert event.margin_before < 0.4


def _followed(guarded: RecoveringController) -> list[Array]:
    """Forces that the law is told to follow, as they come."""
    forces: list[Array] = []
    follow = guarded.law.follow

    def note(wanted, measurement):  # type: ignore[no-untyped-def]
        forces.append(wanted.force_in_tool)
        return follow(wanted, measurement)

    guarded.law.follow = note  # type: ignore[method-assign]
    return forces


def test_time_turns_back_continuously(reference: Reference) -> None:
    clock, seen = PlanClock(), []
    for cycle in range(700):
        clock.wanted_speed = -1.0 if cycle >= 200 else 1.0
        clock.advance(cycle * PERIOD)
        seen.append((clock.plan_time(cycle * PERIOD), clock.instant(reference, cycle * PERIOD)))
    times = np.array([time for time, _ in seen])
    speed = np.diff(times) / PERIOD
    assert speed[100] == pytest.approx(1.0)
    assert speed[-1] == pytest.approx(-1.0)
    assert np.abs(np.diff(speed)).max() <= PACE_CHANGE * PERIOD * (1.0 + 1e-6)
    # Velocities are those of the path as it is run, signs included; accelerations likewise.
    for k in (100, 300, 395, 650):
        before, now, after = seen[k - 1][1], seen[k][1], seen[k + 1][1]
        np.testing.assert_allclose((after.q - before.q) / (2 * PERIOD), now.v, atol=2e-4)
        moved = after.tool.position - before.tool.position
        np.testing.assert_allclose(moved / (2 * PERIOD), now.tool.linear_velocity, atol=2e-5)
        np.testing.assert_allclose((after.v - before.v) / (2 * PERIOD), now.a, atol=2e-2)
        turned = Rotation.from_matrix(after.tool.rotation @ before.tool.rotation.T).as_rotvec()
        np.testing.assert_allclose(turned / (2 * PERIOD), now.tool.angular_velocity, atol=2e-4)


def test_a_clock_as_planned_is_the_runs_to_the_bit() -> None:
    clock = PlanClock()
    for time in np.random.default_rng(0).uniform(size=200).cumsum().tolist():
        clock.advance(time)
        assert clock.plan_time(time) == time


def _put_back_run(
    reference: Reference, options: RecoveryOptions, margin: Callable[[float, int], float]
) -> tuple[PutBack, PlanClock, Array]:
    """A put-back whose margin depends on the plan's time and the number of tries."""
    clock = PlanClock()
    guard = PutBack(clock, reference.phases[:1], options)
    times = []
    for cycle in range(4000):
        time = cycle * PERIOD
        clock.advance(time)
        at = clock.plan_time(time)
        tries = sum(event.measure == "try again" for event in guard.events)
        guard.update(time, "thumb", margin(at, tries))
        times.append(at)
    return guard, clock, np.array(times)


def test_a_removal_is_put_back_and_completed_at_the_second_try(reference: Reference) -> None:
    options = RecoveryOptions()
    guard, clock, times = _put_back_run(
        reference, options, lambda at, tries: -1.0 if at > 0.4 and tries == 0 else 1.0
    )
    assert [event.measure for event in guard.events] == ["put back", "try again"]
    assert guard.given_up_s is None
    assert times[-1] > reference.phases[0].duration
    assert clock.pace.speed == 1.0
    assert all(event.end_s is not None for event in guard.events)
    slow = np.diff(times)[(times[:-1] > 0.54) & (times[:-1] < 0.59)] / PERIOD
    np.testing.assert_allclose(slow, options.retry_speed, atol=1e-6)


@pytest.mark.parametrize("least", [0.05, 0.4])
def test_a_removal_that_fails_again_ends_at_its_start(reference: Reference, least: float) -> None:
    guard, _, times = _put_back_run(
        reference, RecoveryOptions(), lambda at, tries: -1.0 if at > least else 1.0
    )
    measures = [event.measure for event in guard.events]
    assert measures == ["put back", "try again", "put back", "give up"]
    assert guard.given_up_s is not None
    np.testing.assert_allclose(times[-500:], reference.phases[0].start, atol=1e-5)


@pytest.mark.parametrize(
    "bad",
    [
        {"squeeze": 0.5},
        {"ramp_s": 0.0},
        {"hysteresis": -0.1},
        {"retry_speed": 2.0},
        {"put_back_below": 0.5},
        {"lag_s": float("nan")},
    ],
)
def test_bad_options_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(InputError):
        RecoveryOptions(**bad)  # type: ignore[arg-type]


def test_cones_count_only_if_asked_for(
    reference: Reference, law: HybridController, read: Read
) -> None:
    monitor = GraspMonitor(reference, lag_s=0.0, orientation_deg=5.0)
    found = monitor.margins(law.tasks[0], reference.at(0.3), read(0.3))
    edge = found._replace(friction=found.friction - 2.0)
    assert edge.least()[1] < 0.0
    assert edge.least(friction=False) == found.least(friction=False)
    assert found.least(friction=False)[1] > 0.5
