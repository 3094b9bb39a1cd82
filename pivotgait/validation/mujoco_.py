"""MuJoCo behind :class:`Simulator`: a third contact model, convex and with elliptic cones."""

from __future__ import annotations

from math import dist
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.kinematics import cross_matrix
from pivotgait.validation.mujoco_model_ import ROBOT, TABLE, build_model, write_no_log
from pivotgait.validation.simulator import SimulatorOptions, SimulatorState
from pivotgait.validation.world import World

_TIP_SLACK_M = 1e-3
"""A contact of tool and table this near to the tip's sphere is the tip's."""


class MuJoCoSimulator:
    """One world in a ``mujoco.MjData`` of its own.

    Args:
        world: bodies and coefficients.
        options: step and contacts.
    """

    def __init__(self, world: World, options: SimulatorOptions) -> None:
        import mujoco

        write_no_log()
        self._mujoco: Any = mujoco
        self._world, self._options = world, options
        self.model = build_model(world, options)
        self.data: Any = mujoco.MjData(self.model)
        self._steps = 0
        self._elliptic = options.friction_cone == "elliptic"
        self._map_joints()
        self._map_geoms()

    @property
    def step_s(self) -> float:
        """Length of a step [s]."""
        return self._options.step_s

    @property
    def dofs(self) -> Array:
        """(nv,) MuJoCo's coordinate of each joint, in the order of q."""
        return self._dof

    def reset(self, q: Array, v: Array, tool_position: Array, tool_rotation: Array) -> None:
        """See :meth:`Simulator.reset`."""
        data, free = self.data, self._free
        self._mujoco.mj_resetData(self.model, data)
        data.qpos[self._place], data.qvel[self._dof] = q, v
        rotation = np.array(tool_rotation)
        data.qpos[free : free + 3] = tool_position - rotation @ self._centre_in_root
        turn = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
        data.qpos[free + 3 : free + 7] = turn
        self._steps = 0

    def step(self, torque: Array) -> None:
        """See :meth:`Simulator.step`."""
        self.data.qfrc_applied[self._dof] = torque
        self._mujoco.mj_step(self.model, self.data)
        self._steps += 1

    def state(self) -> SimulatorState:
        """See :meth:`Simulator.state`."""
        data, free, dof = self.data, self._free, self._free_dof
        entries = np.empty(9)
        self._mujoco.mju_quat2Mat(entries, data.qpos[free + 3 : free + 7])
        rotation = entries.reshape(3, 3)
        arm = rotation @ self._centre_in_root
        centre = data.qpos[free : free + 3] + arm
        # A free joint's velocity: of the root link's origin in the world, and turning in the link.
        angular = rotation @ data.qvel[dof + 3 : dof + 6]
        forces, points, pivot, unwanted = self._contacts(centre, rotation)
        return SimulatorState(
            time=self._steps * self._options.step_s,
            q=data.qpos[self._place],
            v=data.qvel[self._dof],
            tool_position=centre,
            tool_rotation=rotation,
            tool_linear_velocity=data.qvel[dof : dof + 3] + cross_matrix(angular) @ arm,
            tool_angular_velocity=angular,
            finger_force=MappingProxyType(forces),
            finger_point=MappingProxyType(points),
            pivot_force=pivot,
            unwanted=unwanted,
        )

    def _contacts(
        self, centre: Array, rotation: Array
    ) -> tuple[dict[str, Array], dict[str, Array], Array, tuple[str, ...]]:
        """Forces and points of the fingertips, force on the tip, names of what else touches.

        MuJoCo keeps the contacts of the step just made, at the pose it began with. A contact's
        normal points from its first geom to its second, on which the force acts.
        """
        forces = {name: np.zeros(3) for name in self._world.fingers}
        points = {name: np.zeros(3) for name in self._world.fingers}
        weights = dict.fromkeys(forces, 0.0)
        pivot, unwanted = np.zeros(3), set()
        tip = (centre + rotation @ self._world.pivot_in_tool).tolist()
        reach = self._world.tip_radius + _TIP_SLACK_M
        contacts = self.data.contact
        rows = zip(contacts.geom.tolist(), contacts.efc_address.tolist(), strict=True)
        for k, ((one, other), row) in enumerate(rows):
            solved = self._solved(k, row)
            if solved[0] <= 0.0:
                continue
            sign, partner = (1.0, one) if other in self._tool_geoms else (-1.0, other)
            if sign < 0.0 and one not in self._tool_geoms:
                unwanted.add(self._pair(one, other))
                continue
            frame = contacts.frame[k].reshape(3, 3)
            force = sign * (solved @ frame)
            # from between the surfaces to the tool's
            place = contacts.pos[k] + 0.5 * sign * contacts.dist[k] * frame[0]
            finger = self._tip_fingers.get(partner)
            if finger is not None:
                forces[finger] += force
                points[finger] += solved[0] * place
                weights[finger] += solved[0]
            elif partner == self._table and dist(place.tolist(), tip) <= reach:
                pivot += force
            else:
                unwanted.add(self._pair(one, other))
        touched = {name: points[name] / weight for name, weight in weights.items() if weight > 0.0}
        return forces, touched, pivot, tuple(sorted(unwanted))

    def _solved(self, contact: int, row: int) -> Array:
        """(3,) force of a contact in its frame, the normal first; 0 where it is not active."""
        if row < 0:
            return np.zeros(3)
        if self._elliptic:
            return np.asarray(self.data.efc_force[row : row + 3])
        force = np.zeros(6)
        self._mujoco.mj_contactForce(self.model, self.data, contact, force)
        return force[:3]

    def _pair(self, one: int, other: int) -> str:
        return " - ".join(sorted((self._geom_names[one], self._geom_names[other])))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        del self.data, self.model

    def _map_joints(self) -> None:
        """MuJoCo keeps the tree's order, Pinocchio sorts siblings by name."""
        model = self.model
        joints = [model.joint(f"{ROBOT}{name}").id for name in self._world.joint_names]
        self._place: Array = model.jnt_qposadr[joints]
        self._dof: Array = model.jnt_dofadr[joints]
        free = int(np.flatnonzero(model.jnt_type == self._mujoco.mjtJoint.mjJNT_FREE)[0])
        self._free, self._free_dof = int(model.jnt_qposadr[free]), int(model.jnt_dofadr[free])
        self._tool = int(model.jnt_bodyid[free])
        self._centre_in_root = model.body_ipos[self._tool].copy()

    def _map_geoms(self) -> None:
        model = self.model
        self._table = int(model.geom(TABLE).id)
        bodies = model.geom_bodyid.tolist()
        self._tool_geoms = {geom for geom, body in enumerate(bodies) if body == self._tool}
        names = [model.body(body).name.removeprefix(ROBOT) for body in bodies]
        tips = {each.tip_frame: name for name, each in self._world.fingers.items()}
        self._tip_fingers = {k: tips[name] for k, name in enumerate(names) if name in tips}
        named = {self._table: TABLE, **dict.fromkeys(self._tool_geoms, "tool")}
        self._geom_names = [named.get(geom, name) for geom, name in enumerate(names)]
