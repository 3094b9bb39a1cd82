"""The tree of a search: whole configurations in preallocated arrays."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pivotgait.frozen import Array

TURN_LENGTH = 0.03
"""What one radian of the fingertip counts in the metric of its poses [m]."""


class Tree:
    """Nodes (q, s) with the pose of the moving fingertip in the tool frame.

    Attributes:
        size: number of nodes; node 0 is the root.
        q: (capacity, nv) configurations.
        s: (capacity,) parameters of the tool's path.
        direction: +1 if s grows away from the root, -1 if it falls.
    """

    def __init__(self, capacity: int, nv: int, direction: int) -> None:
        self.size, self.direction = 0, direction
        self.q, self.s = np.zeros((capacity, nv)), np.zeros(capacity)
        self._parent = np.full(capacity, -1)
        self._position, self._quaternion = np.zeros((capacity, 3)), np.zeros((capacity, 4))

    @property
    def full(self) -> bool:
        """Whether no node can be added."""
        return self.size == len(self.s)

    def add(self, q: Array, s: float, tip: pin.SE3, parent: int) -> int:
        """Add a node and return its place."""
        place = self.size
        self.q[place], self.s[place], self._parent[place] = q, s, parent
        self._position[place] = tip.translation
        self._quaternion[place] = pin.Quaternion(tip.rotation).coeffs()
        self.size += 1
        return place

    def nearest_tip(self, tip: pin.SE3, s: float) -> int:
        """Node whose fingertip is nearest to a pose, among those from which s can be reached."""
        n = self.size
        away = self._position[:n] - tip.translation
        same = self._quaternion[:n] @ pin.Quaternion(tip.rotation).coeffs()
        # 4 (1 - |cos(angle / 2)|) * 2 is the squared angle to second order.
        square = np.einsum("ij,ij->i", away, away) + TURN_LENGTH**2 * 8.0 * (1.0 - np.abs(same))
        return self._least(square, s)

    def nearest(self, q: Array, s: float, metric: Array) -> int:
        """Node nearest in the joints, weighted, among those from which s can be reached."""
        away = self.q[: self.size] - q
        return self._least(np.einsum("ij,ij,j->i", away, away, metric), s)

    def _least(self, square: Array, s: float) -> int:
        ahead = self.direction * (self.s[: self.size] - s)
        return int(np.argmin(np.where(ahead > 1e-12, np.inf, square)))

    def branch(self, place: int) -> tuple[Array, Array]:
        """q (N, nv) and s (N,) from the root to a node."""
        places = []
        while place >= 0:
            places.append(place)
            place = int(self._parent[place])
        places.reverse()
        return self.q[places], self.s[places]
