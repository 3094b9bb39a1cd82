"""A gait that keeps every law to rounding, made by linear algebra alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.plans import ContactTrack, GaitPlan, Phase, PlannedTool, ToolMotion
from tests.certification.gantry import with_gantry

URDF = """<?xml version="1.0"?>
<robot name="rod" version="1.1">
  <link name="rod">
    <inertial>
      <origin xyz="0.09 0 0" rpy="0 0 0"/>
      <mass value="0.1"/>
      <inertia ixx="8e-6" ixy="0" ixz="0" iyy="2.6e-4" iyz="0" izz="2.6e-4"/>
    </inertial>
    <collision name="tip">
      <origin xyz="0 0 0" rpy="0 0 0"/>
      <geometry>
        <sphere radius="0.002"/>
      </geometry>
    </collision>
    <collision name="shaft">
      <origin xyz="0.05 0 0" rpy="0 1.5707963267948966 0"/>
      <geometry>
        <capsule radius="0.002" length="0.08"/>
      </geometry>
    </collision>
    <collision name="handle">
      <origin xyz="0.13 0 0" rpy="0 0 0"/>
      <geometry>
        <box size="0.1 0.02 0.02"/>
      </geometry>
    </collision>
  </link>
</robot>
"""
CENTRE = np.array([0.09, 0.0, 0.0])
GRAVITY = np.array([0.0, 0.0, -9.81])
PIVOT = np.array([0.3, 0.1, 0.002])
MASS, INERTIA = 0.1, np.diag([8e-6, 2.6e-4, 2.6e-4])
NORMALS = {"thumb": [0.0, -1.0, 0.0], "index": [0.0, 1.0, 0.0], "middle": [0.0, 1.0, 0.0]}
PLACES = {"thumb": [0.13, 0.01, 0.0], "index": [0.125, -0.01, 0.0], "middle": [0.14, -0.01, 0.001]}
SAMPLES = 41

Forces = dict[str, np.ndarray]


@pytest.fixture(scope="session")
def valid_plan() -> GaitPlan:
    """Lift (trapezoidal), addition, removal (forward Euler), relocation, addition elsewhere."""
    lift = _lift()
    held = {"pivot": [0.0, 0.0, 1.0], "thumb": [0.0, -8.0, 0.0], "index": [0.0, 8.0, 0.0]}
    start = _balance(lift, {k: np.tile(v, (SAMPLES, 1)) for k, v in _turned(lift, held).items()})
    phases = [_phase(0, "lift", "", lift, start)]

    rest = _resting(lift)
    added = _ramped(phases[-1], rest, "middle", [0.2, 3.0, 0.1])
    phases.append(_phase(1, "addition", "middle", rest, added))

    swing = _euler(rest)
    goal = {"pivot": [0.0, 0.0, 1.0], "thumb": [0.0, -8.0, 0.0], "middle": [0.0, 8.0, 0.0]}
    removed = _unloaded(phases[-1], swing, "index", goal)
    phases.append(_phase(2, "removal", "index", swing, removed))

    rest = _resting(swing)
    holding = _last_forces(phases[-1], without="index")
    phases.append(_phase(3, "relocation", "index", rest, holding))

    elsewhere = {**PLACES, "index": [0.11, -0.01, 0.002]}
    again = _ramped(phases[-1], rest, "index", [0.1, 3.0, -0.2], elsewhere)
    phases.append(_phase(4, "addition", "index", rest, again, elsewhere))
    return GaitPlan(
        scene="tool: rod\n",
        seed=7,
        versions={"pivotgait": "0"},
        gravity=GRAVITY,
        table_height=0.0,
        tool=PlannedTool("rod", MASS, INERTIA, -CENTRE, URDF, CENTRE),
        phases=tuple(phases),
    )


@pytest.fixture(scope="session")
def robot_plan(valid_plan: GaitPlan) -> GaitPlan:
    """The same with an arm-hand, whose middle finger comes by a relocation of its own."""
    return with_gantry(valid_plan)


def _motion(rotation: Rotation, omega: np.ndarray, sigma: np.ndarray) -> ToolMotion:
    """Eqs (1) and (2), written with cross-product matrices."""
    arm = rotation.apply(CENTRE)
    skew = np.array([np.cross(w, np.eye(3)).T for w in omega])
    velocity = np.einsum("nij,nj->ni", skew, arm)
    acceleration = np.cross(sigma, arm) + np.einsum("nij,nj->ni", skew, velocity)
    return ToolMotion(PIVOT + arm, rotation.as_quat(), velocity, omega, acceleration, sigma)


def _lift() -> ToolMotion:
    """Trapezoidal velocity about one axis; acceleration jumps between samples and at the ends."""
    time = np.linspace(0.0, 1.0, SAMPLES)
    ramp, top = 0.33, 0.5  # [s], [rad/s]
    rate = np.clip(np.minimum(time, 1.0 - time) / ramp, 0.0, 1.0) * top
    slope = np.where(time < ramp, top / ramp, np.where(time > 1.0 - ramp, -top / ramp, 0.0))
    slope[[0, -1]] = 0.0  # the tool rests before and after
    early = np.where(time < ramp, 0.5 * time**2 / ramp, time - 0.5 * ramp)
    late = (1.0 - ramp) - 0.5 * (1.0 - time) ** 2 / ramp
    angle = top * np.where(time > 1.0 - ramp, late, early)
    axis = np.array([0.3, -1.0, 0.2]) / np.linalg.norm([0.3, -1.0, 0.2])
    rotation = Rotation.from_rotvec(angle[:, None] * axis) * Rotation.from_euler("Y", -0.3)
    return _motion(rotation, rate[:, None] * axis, slope[:, None] * axis)


def _euler(before: ToolMotion) -> ToolMotion:
    """r_{k+1} = exp(h w_k / 2) r_k and w_{k+1} = w_k + h s_k with a turning axis."""
    h, steps = 1.0 / (SAMPLES - 1), np.arange(SAMPLES)
    wave = np.sin(2.0 * np.pi * steps / (SAMPLES - 1))
    wave[[0, -1]] = 0.0
    sigma = np.stack((0.8 * wave, -2.0 * wave, 1.5 * np.sin(2.0 * np.pi * wave)), axis=1)
    omega = h * np.concatenate((np.zeros((1, 3)), np.cumsum(sigma[:-1], axis=0)))
    omega[-1] = 0.0
    rotation = [before.rotation[-1]]
    for rate in omega[:-1]:
        rotation.append(Rotation.from_rotvec(h * rate) * rotation[-1])
    return _motion(Rotation.concatenate(rotation), omega, sigma)


def _resting(before: ToolMotion) -> ToolMotion:
    zero = np.zeros((SAMPLES, 3))
    last = Rotation.concatenate([before.rotation[-1]] * SAMPLES)
    return _motion(last, zero, zero)


def _levers(motion: ToolMotion, name: str, places: Mapping[str, list[float]]) -> np.ndarray:
    if name == "pivot":
        return PIVOT - motion.position
    return motion.rotation.apply(np.array(places[name]) - CENTRE)


def _balance(
    motion: ToolMotion,
    forces: Forces,
    prescribed: tuple[str, ...] = (),
    places: Mapping[str, list[float]] = PLACES,
) -> Forces:
    """Least change of the forces not prescribed such that Newton-Euler (3) holds exactly."""
    inertia = motion.rotation.as_matrix() @ INERTIA @ motion.rotation.inv().as_matrix()
    spin = np.einsum("nij,nj->ni", inertia, motion.angular_velocity)
    missing = np.hstack(
        (
            MASS * (motion.linear_acceleration - GRAVITY),
            np.einsum("nij,nj->ni", inertia, motion.angular_acceleration)
            + np.cross(motion.angular_velocity, spin),
        )
    )
    levers = {name: _levers(motion, name, places) for name in forces}
    for name, force in forces.items():
        missing -= np.hstack((force, np.cross(levers[name], force)))
    free = [name for name in forces if name not in prescribed]
    result = {name: np.array(force) for name, force in forces.items()}
    for k in range(len(missing)):
        blocks = [np.vstack((np.eye(3), np.cross(levers[n][k], np.eye(3)).T)) for n in free]
        grasp = np.hstack(blocks)
        extra = np.linalg.lstsq(grasp, missing[k], rcond=1e-12)[0].reshape(-1, 3)
        for name, change in zip(free, extra, strict=True):
            result[name][k] += change
    return result


def _turned(motion: ToolMotion, in_tool: Mapping[str, list[float]]) -> Forces:
    """Forces given in the tool frame (the pivot's: in the world), at the first sample."""
    first = motion.rotation[0]
    return {k: np.array(v) if k == "pivot" else first.apply(v) for k, v in in_tool.items()}


def _ramped(
    before: Phase,
    rest: ToolMotion,
    finger: str,
    wanted: list[float],
    places: Mapping[str, list[float]] = PLACES,
) -> Forces:
    share = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    forces = {finger: share * rest.rotation[0].apply(wanted)}
    forces |= _last_forces(before, without=finger)
    return _balance(rest, forces, (finger,), places)


def _unloaded(
    before: Phase, swing: ToolMotion, finger: str, goal: Mapping[str, list[float]]
) -> Forces:
    share = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    forces = {}
    for name, contact in before.contacts.items():
        local = contact.force[-1].copy()  # SciPy cannot turn a single read-only vector
        if name != "pivot":
            local = swing.rotation[0].inv().apply(local)
        blend = (1.0 - share) * local + share * np.array(goal.get(name, [0.0, 0.0, 0.0]))
        forces[name] = blend if name == "pivot" else swing.rotation.apply(blend)
    forces[finger][-1] = 0.0
    return _balance(swing, forces, (finger,))


def _last_forces(before: Phase, *, without: str) -> Forces:
    return {
        name: np.tile(contact.force[-1], (SAMPLES, 1))
        for name, contact in before.contacts.items()
        if name != without
    }


def _phase(
    place: int,
    kind: str,
    finger: str,
    motion: ToolMotion,
    forces: Forces,
    places: Mapping[str, list[float]] = PLACES,
) -> Phase:
    contacts = {}
    for name, force in forces.items():
        if name == "pivot":
            contacts[name] = ContactTrack(
                name, PIVOT, np.array([0.0, 0.0, 1.0]), force, 1.5, 0.02, 20.0
            )
        else:
            point = np.array(places[name]) - CENTRE
            contacts[name] = ContactTrack(
                name, point, np.array(NORMALS[name]), force, 1.5, 0.2, 25.0
            )
    time = np.linspace(0.0, 1.0, SAMPLES)
    return Phase(f"{place:02d}_{kind}", kind, finger, time, motion, contacts)
