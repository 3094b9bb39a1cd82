"""What every simulator can do: a few methods, options and a state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, Self

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.validation.engine_check import check_engine
from pivotgait.validation.world import World

TABLE_TOUCH = "table - tool"
"""Name of a touch of the table with any place of the tool but its tip."""

FRICTION_CONES = ("elliptic", "pyramidal")


@dataclass(frozen=True)
class SimulatorOptions:
    """How a simulator computes, apart from the world it computes.

    Attributes:
        step_s: one step of the integration [s].
        contact_stiffness: of a contact point [N/m]; None for the engine's hard contacts.
        contact_damping: of a contact point [N s/m]; without effect on hard contacts.
        solver_iterations: of the contact solver.
        friction_cone: ``elliptic`` as Coulomb's, or the four-sided ``pyramidal`` one, inscribed
            in it (MuJoCo) or about it (PyBullet). MuJoCo's pyramidal contacts hardly give: it
            scales the normal softness with that of the friction.
    """

    step_s: float = 1e-3
    contact_stiffness: float | None = 2e4
    contact_damping: float = 100.0
    solver_iterations: int = 50
    friction_cone: Literal["elliptic", "pyramidal"] = "elliptic"

    def __post_init__(self) -> None:
        if not 0.0 < self.step_s <= 0.02:
            what = f"step of {self.step_s:g} s"
            raise InputError(what, where="simulator", mend="give up to 0.02 s")
        stiffness = self.contact_stiffness
        if stiffness is not None and not 0.0 < stiffness < float("inf"):
            what = f"contact stiffness of {stiffness:g} N/m"
            raise InputError(what, where="simulator", mend="give a positive number or None")
        if self.friction_cone not in FRICTION_CONES:
            raise UnknownNameError("friction cone", self.friction_cone, FRICTION_CONES)


@dataclass(frozen=True, slots=True, eq=False)
class SimulatorState:
    """Everything at one instant; the forces are those of the step that led to it.

    Not read-only and not copied: one is made at each of the thousands of steps.

    Attributes:
        time: since the reset [s].
        q: (nv,) joint positions, in the order of the world's joint names.
        v: (nv,) joint velocities.
        tool_position: (3,) centre of mass, world [m].
        tool_rotation: (3, 3) world <- tool frame (axes of the URDF's root link).
        tool_linear_velocity: (3,) of the centre of mass, world [m/s].
        tool_angular_velocity: (3,) world [rad/s].
        finger_force: (3,) force of each fingertip on the tool, world [N].
        finger_point: (3,) its point of application, world [m]; absent where none touches.
        pivot_force: (3,) force of the table on the tool's tip, world [N].
        unwanted: pairs of names that touch and should not, sorted; maybe :data:`TABLE_TOUCH`.
    """

    time: float
    q: Array
    v: Array
    tool_position: Array
    tool_rotation: Array
    tool_linear_velocity: Array
    tool_angular_velocity: Array
    finger_force: Mapping[str, Array]
    finger_point: Mapping[str, Array]
    pivot_force: Array
    unwanted: tuple[str, ...]


class Simulator(Protocol):
    """An engine that holds one world. Use it as a context: the engine is freed at its end."""

    @property
    def step_s(self) -> float:
        """Length of a step [s]."""

    def reset(self, q: Array, v: Array, tool_position: Array, tool_rotation: Array) -> None:
        """Start anew at rest or in motion, the tool at rest.

        Args:
            q: (nv,) joint positions.
            v: (nv,) joint velocities.
            tool_position: (3,) centre of mass, world [m].
            tool_rotation: (3, 3) world <- tool.
        """

    def step(self, torque: Array) -> None:
        """Advance one step under joint torques (nv,) [N m] or [N]."""

    def state(self) -> SimulatorState:
        """The present state."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *error: object) -> None: ...


def _pybullet(world: World, options: SimulatorOptions) -> Simulator:
    from pivotgait.validation.pybullet_ import PyBulletSimulator

    return PyBulletSimulator(world, options)


def _mujoco(world: World, options: SimulatorOptions) -> Simulator:
    from pivotgait.validation.mujoco_ import MuJoCoSimulator

    return MuJoCoSimulator(world, options)


SIMULATORS: Mapping[str, Callable[[World, SimulatorOptions], Simulator]] = {
    "pybullet": _pybullet,
    "mujoco": _mujoco,
}
"""Makers by name, which is that of the engine's package, too. A new simulator is a file
``<name>_.py``, a maker and a line here, and one in ``engine_check.py`` if it is an extra."""


def check_simulator(name: str) -> None:
    """Refuse a simulator that cannot be used, before work is spent.

    Raises:
        InputError: not installed.
        UnknownNameError: no such simulator.
    """
    check_engine("simulator", name, SIMULATORS)


def make_simulator(name: str, world: World, options: SimulatorOptions) -> Simulator:
    """A simulator of ``world``.

    Raises:
        InputError, UnknownNameError: as :func:`check_simulator`.
    """
    check_simulator(name)
    return SIMULATORS[name](world, options)
