"""Collisions of hand, arm, tool and table by Coal, with a clearance and wanted contacts."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from functools import cached_property
from math import isfinite
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.models.robot import Robot
from pivotgait.models.tool import Tool
from pivotgait.planning.bodies import Bodies, build_bodies, without_pairs
from pivotgait.planning.reach import joint_reach, motion_bounds, tool_radius

ROTATION_TOLERANCE = 1e-6
"""Largest entry of R^T R - I of a tool's orientation."""

Near = tuple[float, Array]
"""A distance [m] and its gradient (nv,) with respect to q."""


class CollisionWorld:
    """Where the arm-hand may be: nothing nearer than ``clearance`` to anything it must not touch.

    The table is everything below its plane. Tips of the fingers that hold (see :meth:`holding`)
    may touch the tool; nothing else may touch anything. Answers come from Coal through
    Pinocchio; poses that are not finite are refused, because Coal may call them free.

    Args:
        robot: the arm-hand.
        tool: the tool.
        table_height: z of the table's plane, world [m].
        clearance: smallest distance allowed [m]; kept as ``clearance_min``.

    A world owns buffers: use one per thread.

    Raises:
        InputError: for a clearance that is negative or not finite.
    """

    def __init__(self, robot: Robot, tool: Tool, table_height: float, clearance: float) -> None:
        self.robot, self.tool = robot, tool
        self.table_height, self.clearance_min = float(table_height), float(clearance)
        if not (isfinite(clearance) and clearance >= 0.0):
            raise InputError(f"clearance {clearance} m", mend="give a length of 0 or more")
        self._made: dict[tuple[frozenset[str], float], CollisionWorld] = {}
        self._prepare(build_bodies(robot, tool, self.table_height), frozenset(), 0.0)
        self._everything = self._geometry, self._shapes

    def _prepare(self, bodies: Bodies, exempt: frozenset[str], padding: float) -> None:
        self.bodies, self.exempt, self.padding = bodies, exempt, padding
        self._tip_pairs = {
            finger: [(tip, shape) for tip in tips for shape in bodies.tool_shapes]
            for finger, tips in bodies.tips.items()
        }
        exempted = [pair for finger in exempt for pair in self._tip_pairs[finger]]
        self._geometry = without_pairs(bodies.geometry, exempted)
        pairs = [(pair.first, pair.second) for pair in self._geometry.collisionPairs]
        self._pairs = tuple(pairs)
        self._data = bodies.model.createData()
        self._shapes = _shape_data(self._geometry, self.clearance_min + padding)
        self._manager = _broad_phase(bodies.model, self._geometry, self._shapes)
        # Distances are asked about less often, with a margin of their own.
        self._near: tuple[float, Any, Any, Any] | None = None
        joint = np.array([each.parentJoint for each in self._geometry.geometryObjects])
        self._joint_pairs = joint[np.array(pairs)]
        self._moved_by = _moved_by(bodies.model, self.robot.nv)
        self._full = pin.neutral(bodies.model)
        self._pose = (b"", b"")

    def holding(self, fingers: AbstractSet[str], padding: float = 0.0) -> CollisionWorld:
        """This world while the tips of ``fingers`` hold the tool; made once for each set.

        Ask the world that exempts none. It keeps those it made, and they do not keep it: a cycle
        would hold megabytes of shapes until Python looks for cycles.

        Args:
            fingers: names; their tip's shapes may touch the tool's.
            padding: added to the clearance [m]; covers what happens between two checks.

        Raises:
            UnknownNameError: for a finger the robot does not have.
            InputError: for a padding that is negative or not finite, or a world with exemptions.
        """
        key = (frozenset(fingers), float(padding))
        if self.exempt or self.padding:
            raise InputError("has exemptions already", where="world", mend="ask the one without")
        if key == (frozenset(), 0.0):
            return self
        if key not in self._made:
            for finger in fingers:
                if finger not in self.bodies.tips:
                    raise UnknownNameError("finger", finger, self.bodies.tips)
            if not (isfinite(padding) and padding >= 0.0):
                raise InputError(f"padding {padding} m", mend="give a length of 0 or more")
            world = object.__new__(CollisionWorld)
            world.robot, world.tool = self.robot, self.tool
            world.table_height, world.clearance_min = self.table_height, self.clearance_min
            world._everything = self._everything
            world._prepare(self.bodies, *key)
            self._made[key] = world
        return self._made[key]

    @cached_property
    def reach(self) -> Array:
        """(nv,) :func:`~pivotgait.planning.reach.joint_reach` [m]."""
        return joint_reach(self.robot, self.bodies)

    @cached_property
    def bounds(self) -> Array:
        """(B, nv) :func:`~pivotgait.planning.reach.motion_bounds` [m]."""
        return motion_bounds(self.robot, self.bodies)

    @cached_property
    def tool_radius(self) -> float:
        """Distance of the tool's farthest point from its centre of mass [m]."""
        return tool_radius(self.bodies)

    def free(self, q: Array, oRtool: Array, position: Array) -> bool:
        """Whether every distance is above clearance and padding.

        Args:
            q: (nv,) joint positions [rad] or [m].
            oRtool: (3, 3) orientation of the tool, world <- tool.
            position: (3,) of the tool's centre of mass, world [m].

        Raises:
            InputError: for a pose that is not finite, or no rotation.
        """
        full = self._place(q, oRtool, position)
        model, data = self.bodies.model, self._data
        return not pin.computeCollisions(model, data, self._manager, full, True)

    def clearance(self, q: Array, oRtool: Array, position: Array) -> tuple[float, tuple[str, str]]:
        """Smallest distance [m], negative in a collision, and the links or shapes it is between.

        Arguments and errors as :meth:`free`.
        """
        full = self._place(q, oRtool, position)
        model, data = self.bodies.model, self._data
        place = pin.computeDistances(model, data, self._geometry, self._shapes, full)
        first, second = self._pairs[place]
        distance = float(self._shapes.distanceResults[place].min_distance)
        if not isfinite(distance):
            raise InputError(f"Coal's distance is {distance}", mend="check q and the tool's pose")
        return distance, (self.bodies.names[first], self.bodies.names[second])

    def tip_gap(self, finger: str, q: Array, oRtool: Array, position: Array) -> float:
        """Distance [m] of a finger's tip from the tool, negative when inside it.

        Arguments and errors as :meth:`free`, and UnknownNameError for the finger.
        """
        if finger not in self._tip_pairs:
            raise UnknownNameError("finger", finger, self._tip_pairs)
        full = self._place(q, oRtool, position)
        geometry, shapes = self._everything
        pin.updateGeometryPlacements(self.bodies.model, self._data, geometry, shapes, full)
        places = [
            geometry.findCollisionPair(pin.CollisionPair(*p)) for p in self._tip_pairs[finger]
        ]
        gaps = [pin.computeDistance(geometry, shapes, place).min_distance for place in places]
        return float(min(gaps, default=np.inf))

    def near(self, q: Array, oRtool: Array, position: Array, below: float = 0.01) -> list[Near]:
        """The pairs that are nearer than ``below`` [m]: distance and gradient (nv,) by q.

        The gradient is that of the distance between the nearest points as they move with their
        links: n^T (J_b - J_a) with the normal n from a to b. Exempt pairs are not among them.
        Arguments and errors as :meth:`free`.
        """
        full = self._place(q, oRtool, position)
        model, data = self.bodies.model, self._data
        shapes, manager, collect = self._near_data(below)
        pin.computeJointJacobians(model, data, full)
        pin.computeCollisions(model, data, manager, collect, full)
        places, results = sorted(collect.pair_indexes), []
        for place in places:
            result = pin.computeDistance(self._geometry, shapes, place)
            results.append((result.min_distance, place, result))
        if not isfinite(sum(entry[0] for entry in results)):
            raise InputError("Coal's distance is not finite", mend="check q and the tool's pose")
        results = [entry for entry in results if entry[0] < below]
        if not results:
            return []
        distances = [float(entry[0]) for entry in results]
        normals = np.array([entry[2].normal for entry in results])
        change = np.zeros((len(results), self.robot.nv))
        jacobian = data.J[:, : self.robot.nv]
        pairs = self._joint_pairs[[entry[1] for entry in results]]
        for side, sign in ((0, -1.0), (1, 1.0)):
            nearest = "getNearestPoint1" if side == 0 else "getNearestPoint2"
            points = np.array([getattr(entry[2], nearest)() for entry in results])
            push = np.concatenate((normals, np.cross(points, normals)), axis=1)
            change += sign * (push @ jacobian) * self._moved_by[pairs[:, side]]
        return list(zip(distances, change, strict=True))

    def _near_data(self, below: float) -> tuple[Any, Any, Any]:
        if self._near is None or self._near[0] != below:
            shapes = _shape_data(self._geometry, below)
            manager = _broad_phase(self.bodies.model, self._geometry, shapes)
            self._near = (
                below,
                shapes,
                manager,
                pin.CollisionCallBackCollect(self._geometry, shapes),
            )
        return self._near[1:]

    def _place(self, q: Array, oRtool: Array, position: Array) -> Array:
        """Configuration of the joined model."""
        full: Array = self._full
        n = self.robot.nv
        if q.shape != (n,):
            raise InputError(f"q has shape {q.shape}", mend=f"give ({n},)")
        full[:n] = q
        pose = (oRtool.tobytes(), position.tobytes())
        if pose != self._pose:
            self._set_tool(oRtool, position)
            self._pose = pose
        if not isfinite(full.sum()):
            raise InputError("joint positions or tool pose not finite", mend="look for NaN")
        return full

    def _set_tool(self, oRtool: Array, position: Array) -> None:
        n = self.robot.nv
        self._pose = (b"", b"")
        turn = np.array(oRtool, dtype=float)
        error = np.abs(turn.T @ turn - np.eye(3)).max() if turn.shape == (3, 3) else np.inf
        if not (error <= ROTATION_TOLERANCE and np.linalg.det(turn) > 0.0):
            raise InputError("the tool's orientation is no rotation", mend="give a finite (3, 3)")
        self._full[n : n + 3] = position
        self._full[n + 3 :] = pin.Quaternion(turn).normalized().coeffs()


def _shape_data(geometry: Any, margin: float) -> Any:
    """``pinocchio.GeometryData`` whose collisions begin at a distance of ``margin`` [m]."""
    shapes = geometry.createData()
    for request in shapes.collisionRequests:
        request.security_margin = margin
    return shapes


def _broad_phase(model: Any, geometry: Any, shapes: Any) -> Any:
    """Tree of bounding boxes, inflated by the margins: about four times as fast as all pairs."""
    return pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(model, geometry, shapes)


def _moved_by(model: Any, nv: int) -> Array:
    """(joints + 1, nv) whether a body's joint or an ancestor of it owns a column of q."""
    moved = np.zeros((model.njoints, nv), dtype=bool)
    for joint in range(1, model.njoints):
        moved[joint] = moved[model.parents[joint]]
        column = model.joints[joint].idx_v
        if column < nv:
            moved[joint, column] = True
    return moved
