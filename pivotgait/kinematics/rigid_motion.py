"""Velocities and accelerations of the points of a moving rigid body."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from pivotgait.frozen import Array

AT_REST = np.zeros(3)
AT_REST.setflags(write=False)


class RigidMotion:
    """The tool's motion, with the matrices that every finger's coordinates need of it."""

    def __init__(
        self,
        linear_velocity: Array,
        angular_velocity: Array,
        linear_acceleration: Array = AT_REST,
        angular_acceleration: Array = AT_REST,
    ) -> None:
        """A body's motion, all in world axes.

        Args:
            linear_velocity: (3,) of the body's origin [m/s].
            angular_velocity: (3,) omega [rad/s].
            linear_acceleration: (3,) of the body's origin [m/s^2].
            angular_acceleration: (3,) [rad/s^2].
        """
        self.linear_velocity, self.angular_velocity = linear_velocity, angular_velocity
        self.linear_acceleration = linear_acceleration
        self.angular_acceleration = angular_acceleration

    @cached_property
    def turning(self) -> Array:
        """(3, 3) [omega]x, which also is the gradient of velocity in space."""
        return cross_matrix(self.angular_velocity)

    @cached_property
    def gradient(self) -> Array:
        """(3, 3) gradient of acceleration in space: Euler's and the centripetal part."""
        gradient: Array = self.turning.dot(self.turning)
        return gradient + cross_matrix(self.angular_acceleration)

    def velocity_at(self, lever: Array) -> Array:
        """(3,) velocity [m/s] of the body's point at ``lever`` (3,) from its origin, world."""
        velocity: Array = self.linear_velocity + self.turning.dot(lever)
        return velocity

    def acceleration_at(self, lever: Array) -> Array:
        """(3,) acceleration [m/s^2] of the body's point at ``lever`` (3,), world."""
        acceleration: Array = self.linear_acceleration + self.gradient.dot(lever)
        return acceleration


def cross_matrix(vector: Array) -> Array:
    """(3, 3) [v]x of one vector (3,); several times leaner than the vectorised form."""
    x, y, z = vector.tolist()
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
