"""The arm-hand in two grips, with a tool placed anywhere and contacts at the fingers' pads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from pivotgait.kinematics import Hold, rotation_from_angles
from pivotgait.models import Robot, urdf_root
from pivotgait.models.robot_config import FingerConfig, RobotConfig
from pivotgait.models.robot_loading import build_robot

Array = NDArray[np.float64]
ARM = (0.3, -0.7, 0.1, 0.4)
POSTURES = {  # wrist, index, middle, thumb [rad]
    "open": (-0.1, 0.2, -0.1, 0.6, 0.8, 0.5, 0.05, 0.7, 0.9, 0.6, 0.3, 0.9, 0.1, 0.25, 0.35),
    "pinch": (
        *(0.0188, -0.2686),
        *(-0.3013, 0.9774, 1.045, 0.1665),
        *(0.1255, 0.165, 0.3459, 0.0005741),
        *(0.03082, 1.08, 0.1604, 0.5839, 0.3069),
    ),
}
STENCIL = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
SECOND_STENCIL = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 12.0


@dataclass(frozen=True)
class Motion:
    """Velocities and accelerations of joints and tool at one instant."""

    v: Array
    a: Array
    linear_velocity: Array
    angular_velocity: Array
    linear_acceleration: Array
    angular_acceleration: Array

    @property
    def tool(self) -> tuple[Array, Array, Array, Array]:
        return (
            self.linear_velocity,
            self.angular_velocity,
            self.linear_acceleration,
            self.angular_acceleration,
        )


@dataclass(frozen=True)
class Grip:
    """A configuration in which every tip is exactly at its hold.

    ``holds`` are in the order thumb, index, middle.
    """

    robot: Robot
    q: Array
    oRtool: Array
    position: Array
    holds: tuple[Hold, ...]
    rng: np.random.Generator

    def near(self, distance: float = 0.05) -> Array:
        """A configuration about the grip."""
        return self.q + distance * self.rng.normal(size=self.robot.nv)

    def turned(self, psi: float, theta: float) -> tuple[Hold, ...]:
        """Holds relative to which the tips stand at these angles in the grip (phi = 0)."""
        data = self.robot.model.createData()
        pin.framesForwardKinematics(self.robot.model, data, self.q)
        wanted = rotation_from_angles(np.array([theta, psi, 0.0]))
        return tuple(
            replace(
                hold,
                tipRcontact=data.oMf[hold.finger.tip_frame_id].rotation.T
                @ self.oRtool
                @ hold.toolRtarget
                @ wanted,
            )
            for hold in self.holds
        )

    def motion(self) -> Motion:
        """Random rates of the order of 1 in SI units."""
        nv = self.robot.nv
        return Motion(*(self.rng.normal(size=n) for n in (nv, nv, 3, 3, 3, 3)))

    def moved(self, q: Array, motion: Motion, time: float) -> tuple[Array, Array, Array]:
        """q, oRtool and position a short time later; the accelerations hold at time 0."""
        half = 0.5 * time**2
        turn = pin.exp3(time * motion.angular_velocity + half * motion.angular_acceleration)
        return (
            q + time * motion.v + half * motion.a,
            turn @ self.oRtool,
            self.position + time * motion.linear_velocity + half * motion.linear_acceleration,
        )


def derivatives(function: Callable[[float], Array], step: float = 2e-4) -> tuple[Array, Array]:
    """First and second derivative at 0 by central differences of fourth order."""
    samples = np.stack([function(k * step) for k in range(-2, 3)])
    return (
        np.tensordot(STENCIL, samples, axes=1) / step,
        np.tensordot(SECOND_STENCIL, samples, axes=1) / step**2,
    )


@pytest.fixture(scope="session")
def differences() -> Callable[[Callable[[float], Array]], tuple[Array, Array]]:
    return derivatives


@pytest.fixture(scope="session")
def robot() -> Robot:
    def finger(prefix: str, count: int, tip: str, radius: float) -> FingerConfig:
        joints = tuple(f"{prefix}J{k}" for k in range(count, 0, -1))
        return FingerConfig(tip_frame=tip, tip_radius_m=radius, pad=(0.0, -1.0, 0.0), joints=joints)

    config = RobotConfig(
        urdf="cobra_s800_shadow",
        palm="palm",
        fingers={
            "thumb": finger("TH", 5, "thtip", 0.0075),
            "index": finger("FF", 4, "fftip", 0.006),
            "middle": finger("MF", 4, "mftip", 0.006),
        },
    )
    path = urdf_root() / "cobra_s800_shadow" / "cobra_s800_shadow.urdf"
    return build_robot(path.read_text(encoding="utf-8"), config, where="robot")


def make_grip(robot: Robot, posture: str, seed: int) -> Grip:
    rng = np.random.default_rng(seed)
    q = np.array([*ARM, *POSTURES[posture]])
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    tips = {name: data.oMf[f.tip_frame_id] for name, f in robot.fingers.items()}
    oRtool = pin.exp3(rng.normal(size=3))
    position = tips["thumb"].translation + 0.05 * rng.normal(size=3)
    holds = []
    for name, tip in tips.items():
        finger = robot.fingers[name]
        axis = finger.pad + 0.3 * rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        normal = oRtool.T @ tip.rotation @ axis
        point = oRtool.T @ (tip.translation - position) + finger.tip_radius * normal
        holds.append(Hold.of(finger, point, normal, axis))
    return Grip(robot, q, oRtool, position, tuple(holds), rng)


@pytest.fixture(params=[("open", 0), ("open", 1), ("pinch", 2), ("pinch", 3)], ids=str)
def grip(robot: Robot, request: pytest.FixtureRequest) -> Grip:
    return make_grip(robot, *request.param)
