"""One run: a controller against a simulator, from the closing fingers to the final hold."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import dist, isfinite

import numpy as np

from pivotgait.control.controller import Controller
from pivotgait.control.recovery_options import RecoveryOptions
from pivotgait.control.reference import Reference
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation.closing import closing_distances
from pivotgait.validation.controllers import make_controller
from pivotgait.validation.grasp import standing_off, with_grasp
from pivotgait.validation.guarding import (
    guarded,
    is_over,
    most_cycles,
    plan_time,
    with_events,
)
from pivotgait.validation.perturbation import Perturbation
from pivotgait.validation.real_tool import RealTool, real_tool
from pivotgait.validation.sensing import Sensors
from pivotgait.validation.series import RunSeries
from pivotgait.validation.simulator import (
    Simulator,
    SimulatorOptions,
    SimulatorState,
    make_simulator,
)
from pivotgait.validation.tape import Tape
from pivotgait.validation.world import World

_LOST_M = 1.0
_LARGEST_SPEED = 1e3


@dataclass(frozen=True)
class RunOptions:
    """How a run is carried out.

    Attributes:
        simulator: its name.
        controller: name of the control law.
        engine: step and contacts of the simulator.
        control_period_s: of the controller, a multiple of the engine's step unless that is longer.
        grasp_s: time in which the fingers close and take hold before the plan begins [s].
        gap_m: of the fingertips from the tool when the controller takes over: fingers close
            along their planned normals until they nearly touch, as a guarded move does [m].
        hold_s: time for which the final grasp is held [s].
        recovery: thresholds under which forces are allocated anew or a finger is put back; None
            for a run that follows its plan whatever happens.
    """

    simulator: str = "pybullet"
    controller: str = "hybrid"
    engine: SimulatorOptions = field(default_factory=SimulatorOptions)
    control_period_s: float = 1e-3
    grasp_s: float = 0.8
    gap_m: float = 2e-4
    hold_s: float = 2.0
    recovery: RecoveryOptions | None = None

    @property
    def steps_per_cycle(self) -> int:
        """Simulator's steps in a control cycle.

        Raises:
            InputError: if the period is no multiple of the step.
        """
        ratio = max(self.control_period_s / self.engine.step_s, 1.0)
        if abs(ratio - round(ratio)) > 1e-6:
            what = f"{self.control_period_s:g} s is no multiple of the step"
            raise InputError(what, where="control period", mend="choose a step that divides it")
        return round(ratio)

    @property
    def cycle_s(self) -> float:
        """Length of a control cycle [s]: the period, or the engine's step if that is longer."""
        return self.steps_per_cycle * self.engine.step_s


@dataclass(frozen=True)
class Timing:
    """Mean times of a control cycle on this machine.

    Attributes:
        control_s: of the controller [s].
        simulator_s: of the simulator's steps and its state [s].
    """

    control_s: float
    simulator_s: float


def run(
    plan: GaitPlan,
    scene: Scene,
    perturbation: Perturbation,
    options: RunOptions,
    *,
    controller: Callable[[Reference], Controller] | None = None,
    duration: Callable[[], float] | None = None,
) -> tuple[RunSeries, Timing]:
    """Carry a plan out in a simulator.

    Args:
        plan: with a robot.
        scene: of the plan.
        perturbation: how the world and the sensors differ from the plan.
        options: of the run.
        controller: maker of a control law of one's own, else that of ``options``.
        duration: of the run without its final hold, as the control law has it by now [s], for one
            that changes its plan; else that of the plan and of closing the fingers.

    Raises:
        PivotGaitError: bad input.
    """
    robot = scene.robot
    if robot is None or plan.robot is None:
        raise InputError("has no robot", where="plan", mend="plan a scene with a robot")
    longer = with_grasp(plan, robot, options.grasp_s)
    reference = Reference.of(longer, robot)
    if controller is None:
        law = make_controller(options.controller, reference, options.cycle_s)
    else:
        law = controller(reference)
    law = guarded(law, options.recovery)
    real = real_tool(plan, scene, perturbation)
    start = standing_off(plan, robot, closing_distances(plan, robot, real, options.gap_m))
    with make_simulator(
        options.simulator, real_world(plan, real, perturbation), options.engine
    ) as simulator:
        simulator.reset(start, np.zeros(robot.nv), real.position, real.rotation)
        sensors = Sensors(perturbation, tuple(robot.fingers), options.cycle_s)
        lasting = duration or (lambda: reference.duration)

        def cycles() -> int:
            return most_cycles(law, round((lasting() + options.hold_s) / options.cycle_s))

        tape = Tape(tuple(robot.fingers), robot.joint_names)
        loop = _Loop(simulator, law, sensors, tape, robot.effort_max, options)
        diverged, timing = loop.turn(cycles)
    series = tape.series(diverged=diverged, pivot_in_tool=real.tool.pivot_in_tool)
    return with_events(series, law, options.grasp_s), timing


def real_world(plan: GaitPlan, real: RealTool, perturbation: Perturbation) -> World:
    """The world of a plan with the perturbation's tool and frictions."""
    world = World.of(plan)
    scale = perturbation.finger_friction_scale
    return replace(
        world,
        tool_urdf=real.tool.urdf,
        pivot_in_tool=real.tool.pivot_in_tool,
        finger_friction={name: scale * value for name, value in world.finger_friction.items()},
        finger_torsion={name: scale * value for name, value in world.finger_torsion.items()},
        table_friction=perturbation.table_friction_scale * world.table_friction,
        joint_friction=perturbation.joint_friction,
    )


@dataclass
class _Loop:
    """Controller and simulator in turns."""

    simulator: Simulator
    law: Controller
    sensors: Sensors
    tape: Tape
    effort_max: Array
    options: RunOptions

    def turn(self, cycles: Callable[[], int]) -> tuple[str, Timing]:
        """Run as many control cycles, or until the simulation has gone astray: why.

        Args:
            cycles: their number, as it is by now.
        """
        options, simulator = self.options, self.simulator
        thinking = stepping = 0.0
        self.law.reset()
        state = simulator.state()
        begin = state.tool_position.tolist()
        least, most = -self.effort_max, self.effort_max
        cycle = 0
        while cycle < cycles():
            time = cycle * options.cycle_s
            if is_over(self.law, time, options.hold_s):
                break
            measurement = self.sensors.read(time, state)
            before = clock.perf_counter()
            asked = self.law.torque(measurement)
            thinking += clock.perf_counter() - before
            astray = _astray(state, asked, begin)
            if astray:
                return astray, Timing(thinking / (cycle + 1), stepping / (cycle + 1))
            followed = plan_time(self.law, options.grasp_s)
            self.tape.write(time - options.grasp_s, state, asked, measurement.force, followed)
            torque = np.minimum(np.maximum(asked, least), most)
            before = clock.perf_counter()
            for _ in range(options.steps_per_cycle):
                simulator.step(torque)
            state = simulator.state()
            stepping += clock.perf_counter() - before
            cycle += 1
        return "", Timing(thinking / max(cycle, 1), stepping / max(cycle, 1))


def _astray(state: SimulatorState, torque: Array, start: Sequence[float]) -> str:
    """Why a run cannot go on, or an empty text."""
    # A sum is not finite if a summand is not; for numbers, as here, it does not overflow.
    if not isfinite(float(np.add.reduce(torque)) + float(np.add.reduce(state.q))):
        return "a torque or a joint position is not finite"
    if not (state.v.max() < _LARGEST_SPEED and state.v.min() > -_LARGEST_SPEED):
        return f"a joint moves faster than {_LARGEST_SPEED:g} rad/s"
    moved = dist(state.tool_position.tolist(), start)
    return "" if moved < _LOST_M else "the tool has left the table"
