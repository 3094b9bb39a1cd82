"""Robot, tool and table as one collision world, posed and measured by Pinocchio and Coal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from pivotgait.certification.rigid_robot import RigidRobot
from pivotgait.certification.solid import RigidTool
from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array
from pivotgait.plans import GaitPlan, PlannedRobot

_TOOL, _TABLE = "tool", "table"
_LARGEST_M = 1e6


class Surroundings:
    """Everything that may collide, and the distances that count.

    The tool hangs on a free joint behind the robot's joints, so that one call of Pinocchio poses
    both; the table is the half space below its height.

    Args:
        plan: whose table counts.
        planned: its robot.
        rigid: the robot of its URDF.
        tool: the tool of its URDF.

    Raises:
        PlanFileError: if a length in a URDF is so large that distances would overflow.
    """

    def __init__(
        self, plan: GaitPlan, planned: PlannedRobot, rigid: RigidRobot, tool: RigidTool
    ) -> None:
        self._model = pin.Model(rigid.model)
        # Names in a checked URDF never begin with a blank.
        free = pin.JointModelFreeFlyer()
        joint = self._model.addJoint(0, free, pin.SE3.Identity(), f" {_TOOL}")
        self._shapes = pin.GeometryModel(rigid.shapes)
        self._names = [
            rigid.model.frames[each.parentFrame].name for each in rigid.shapes.geometryObjects
        ]
        robot = range(len(self._names))
        tool_shapes = [self._add_tool(joint, solid) for solid in tool.solids]
        self._refuse_huge()
        table = self._add_table(plan.table_height)
        tips = set(rigid.tip_shapes.values())
        self._add_pairs(self._robot_pairs(robot, planned.never_touch))
        # What stands fixed in the world stands on the table or beside it.
        self._add_pairs((shape, table) for shape in robot if self._joint(shape) > 0)
        self._add_pairs((i, k) for i in robot if i not in tips for k in tool_shapes)
        self._tips = {
            name: self._add_pairs((tip, k) for k in tool_shapes)
            for name, tip in rigid.tip_shapes.items()
        }
        self._tip_links = {name: self._names[i] for name, i in rigid.tip_shapes.items()}
        self._data, self._places = self._model.createData(), self._shapes.createData()
        for pairs in self._tips.values():
            for index in pairs:
                self._places.deactivateCollisionPair(index)

    @property
    def tip_links(self) -> Mapping[str, str]:
        """Name of the link with the tip sphere, by the fingers that have one."""
        return self._tip_links

    def measure(self, q: Array, position: Array, orientation: Array) -> tuple[float, str]:
        """Pose everything; smallest distance [m] but of tips and tool, and the links it is between.

        Args:
            q: (n,) joint positions, finite.
            position: (3,) of the tool's centre of mass, world [m].
            orientation: (4,) unit quaternion xyzw, world <- tool.

        Returns:
            NaN if no distance can be told.
        """
        whole = np.concatenate((q, position, orientation))
        nearest = pin.computeDistances(self._model, self._data, self._shapes, self._places, whole)
        if not nearest < len(self._shapes.collisionPairs):
            # Nothing to measure is no reason to pass, and NaN compares below nothing.
            return float("nan"), ""
        pair = self._shapes.collisionPairs[nearest]
        links = f"{self._names[pair.first]} - {self._names[pair.second]}"
        return float(self._places.distanceResults[nearest].min_distance), links

    def tip_to_tool(self, finger: str) -> float:
        """Distance [m] of a finger's tip sphere from the tool in the pose last measured."""
        measured = (
            pin.computeDistance(self._shapes, self._places, index) for index in self._tips[finger]
        )
        return min(float(each.min_distance) for each in measured)

    def _refuse_huge(self) -> None:
        """Numbers that overflow become NaN in Coal, which may read as free."""
        shapes = self._shapes.geometryObjects
        places = [*self._model.jointPlacements, *(shape.placement for shape in shapes)]
        lengths = [np.max(np.abs(place.translation)) for place in places]
        for shape in shapes:
            shape.geometry.computeLocalAABB()
            lengths.append(float(shape.geometry.aabb_radius))
        if not np.max(lengths) <= _LARGEST_M:
            raise PlanFileError(
                f"a URDF has a length of {np.max(lengths):g} m", where="plan", mend="use metres"
            )

    def _joint(self, shape: int) -> int:
        return int(self._shapes.geometryObjects[shape].parentJoint)

    def _add_tool(self, joint: int, solid: Any) -> int:
        place = pin.SE3(solid.rotation, solid.translation)
        self._names.append(_TOOL)
        name = f" {_TOOL} {len(self._names)}"
        shape = pin.GeometryObject(name, joint, place, solid.geometry)
        return int(self._shapes.addGeometryObject(shape))

    def _add_table(self, height: float) -> int:
        half_space = coal.Halfspace(np.array([0.0, 0.0, 1.0]), float(height))
        self._names.append(_TABLE)
        shape = pin.GeometryObject(f" {_TABLE}", 0, pin.SE3.Identity(), half_space)
        return int(self._shapes.addGeometryObject(shape))

    def _add_pairs(self, pairs: Iterable[tuple[int, int]]) -> range:
        """Indices of the pairs in the geometry model."""
        first = len(self._shapes.collisionPairs)
        for pair in pairs:
            self._shapes.addCollisionPair(pin.CollisionPair(*pair))
        return range(first, len(self._shapes.collisionPairs))

    def _robot_pairs(
        self, robot: range, never_touch: Iterable[tuple[str, str]]
    ) -> Iterable[tuple[int, int]]:
        """Shapes of one body or of two that a joint connects meet by design."""
        skip = {frozenset(pair) for pair in never_touch}
        parents = self._model.parents
        for i in robot:
            for k in range(i + 1, len(robot)):
                one, other = self._joint(i), self._joint(k)
                near = one == other or parents[one] == other or parents[other] == one
                if not near and frozenset((self._names[i], self._names[k])) not in skip:
                    yield i, k
