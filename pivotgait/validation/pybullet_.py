"""PyBullet behind :class:`Simulator`: another contact model than the planner's."""

from __future__ import annotations

import tempfile
from math import dist
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.validation.link_pairs import quiet_pairs
from pivotgait.validation.simulator import SimulatorOptions, SimulatorState
from pivotgait.validation.undamped import undamped
from pivotgait.validation.world import World

_BASE = -1
_TIP_SLACK_M = 1e-3
"""A contact of tool and table this near to the tip's sphere is the tip's."""


class PyBulletSimulator:
    """One world in a Bullet client of its own (DIRECT, without a window).

    Friction multiplies in Bullet: the tool has coefficient 1, so that fingertips and table carry
    those of their pairs with it. Torsional friction is bounded apart from it, by e f_n. Contacts
    are in series: fingertips and table carry the stiffness, the tool is rigid.

    Args:
        world: bodies and coefficients.
        options: step and contacts.
    """

    def __init__(self, world: World, options: SimulatorOptions) -> None:
        import pybullet

        self._bullet: Any = pybullet
        self._world, self._options = world, options
        self.client = int(pybullet.connect(pybullet.DIRECT))
        self._steps = 0
        try:
            self._set_engine()
            self.table = self._add_table()
            self.robot = self._load("robot", undamped(world.robot_urdf), fixed=True)
            self.tool = self._load("tool", world.tool_urdf, fixed=False)
            self._map_joints()
            self._set_bodies()
            self._set_contacts()
            self._set_pairs()
        except BaseException:
            pybullet.disconnect(physicsClientId=self.client)
            raise

    @property
    def step_s(self) -> float:
        """Length of a step [s]."""
        return self._options.step_s

    @property
    def joints(self) -> tuple[int, ...]:
        """Bullet's index of each joint in the order of q."""
        return self._joints

    def reset(self, q: Array, v: Array, tool_position: Array, tool_rotation: Array) -> None:
        """See :meth:`Simulator.reset`."""
        for joint, position, speed in zip(self._joints, q, v, strict=True):
            self._bullet.resetJointState(
                self.robot, joint, float(position), float(speed), physicsClientId=self.client
            )
        principal = Rotation.from_matrix(np.array(tool_rotation) @ self._principal_in_tool)
        self._bullet.resetBasePositionAndOrientation(
            self.tool, list(tool_position), list(principal.as_quat()), physicsClientId=self.client
        )
        self._bullet.resetBaseVelocity(self.tool, [0] * 3, [0] * 3, physicsClientId=self.client)
        self._steps = 0

    def step(self, torque: Array) -> None:
        """See :meth:`Simulator.step`."""
        # Bullet holds a torque for a single step.
        self._bullet.setJointMotorControlArray(
            self.robot,
            self._joints,
            self._bullet.TORQUE_CONTROL,
            forces=torque.tolist(),
            physicsClientId=self.client,
        )
        self._bullet.stepSimulation(physicsClientId=self.client)
        self._steps += 1

    def state(self) -> SimulatorState:
        """See :meth:`Simulator.state`."""
        bullet, client = self._bullet, self.client
        joints = bullet.getJointStates(self.robot, self._joints, physicsClientId=client)
        position, turn = bullet.getBasePositionAndOrientation(self.tool, physicsClientId=client)
        linear, angular = bullet.getBaseVelocity(self.tool, physicsClientId=client)
        principal = np.reshape(bullet.getMatrixFromQuaternion(turn), (3, 3))
        centre, rotation = np.array(position), principal @ self._principal_in_tool.T
        forces, points, pivot, unwanted = self._contacts(centre, rotation)
        positions, velocities, *_ = zip(*joints, strict=True)
        return SimulatorState(
            time=self._steps * self._options.step_s,
            q=np.array(positions),
            v=np.array(velocities),
            tool_position=centre,
            tool_rotation=rotation,
            tool_linear_velocity=np.array(linear),
            tool_angular_velocity=np.array(angular),
            finger_force=MappingProxyType(forces),
            finger_point=MappingProxyType(points),
            pivot_force=pivot,
            unwanted=unwanted,
        )

    def _contacts(
        self, centre: Array, rotation: Array
    ) -> tuple[dict[str, Array], dict[str, Array], Array, tuple[str, ...]]:
        """Forces and points of the fingertips, force on the tip, names of what else touches.

        In plain numbers: there are few points, and arrays of three cost more than they save.
        """
        sums = {name: [0.0] * 7 for name in self._world.fingers}
        pivot, unwanted = [0.0] * 7, set()
        tip = (centre + rotation @ self._world.pivot_in_tool).tolist()
        reach = self._world.tip_radius + _TIP_SLACK_M
        tool, table, robot, fingers = self.tool, self.table, self.robot, self._tip_fingers
        # Unfiltered: a filter may flip the normal but not the friction.
        for point in self._bullet.getContactPoints(physicsClientId=self.client):
            if point[9] <= 0.0:
                continue
            if point[1] == tool:
                body, link, place, sign = point[2], point[4], point[5], 1.0
            elif point[2] == tool:
                body, link, place, sign = point[1], point[3], point[6], -1.0
            else:
                unwanted.add(self._pair(point))
                continue
            finger = fingers.get(link) if body == robot else None
            if finger is not None:
                _add(sums[finger], point, place, sign)
            elif body == table and dist(place, tip) <= reach:
                _add(pivot, point, place, sign)
            else:
                unwanted.add(self._pair(point))
        forces = {name: np.array(each[:3]) for name, each in sums.items()}
        points = {
            name: np.array([w / each[6] for w in each[3:6]])
            for name, each in sums.items()
            if each[6] > 0.0
        }
        return forces, points, np.array(pivot[:3]), tuple(sorted(unwanted))

    def _pair(self, point: Any) -> str:
        names = (self._name(point[1], point[3]), self._name(point[2], point[4]))
        return " - ".join(sorted(names))

    def _name(self, body: int, link: int) -> str:
        if body == self.robot:
            return str(self._links[link])
        return "tool" if body == self.tool else "table"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._bullet.disconnect(physicsClientId=self.client)

    def _set_engine(self) -> None:
        bullet, options = self._bullet, self._options
        bullet.setGravity(*map(float, self._world.gravity), physicsClientId=self.client)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=options.step_s,
            numSolverIterations=options.solver_iterations,
            numSubSteps=0,
            enableConeFriction=int(options.friction_cone == "elliptic"),
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )

    def _add_table(self) -> int:
        bullet, client = self._bullet, self.client
        plane = bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=client)
        height = self._world.table_height
        return int(
            bullet.createMultiBody(0, plane, basePosition=[0, 0, height], physicsClientId=client)
        )

    def _load(self, name: str, urdf: str, *, fixed: bool) -> int:
        bullet = self._bullet
        # Inertias as written, not made up from the shapes; fixed links kept, since Bullet merges
        # them wrongly; neighbours are sorted out below.
        flags = bullet.URDF_USE_INERTIA_FROM_FILE
        if fixed:
            flags |= bullet.URDF_USE_SELF_COLLISION
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / f"{name}.urdf"
            file.write_text(urdf, encoding="utf-8")
            return int(
                bullet.loadURDF(
                    str(file), useFixedBase=fixed, flags=flags, physicsClientId=self.client
                )
            )

    def _map_joints(self) -> None:
        """Bullet keeps the file's order, Pinocchio sorts siblings by name."""
        bullet, client = self._bullet, self.client
        count = bullet.getNumJoints(self.robot, physicsClientId=client)
        infos = [bullet.getJointInfo(self.robot, k, physicsClientId=client) for k in range(count)]
        index = {info[1].decode(): info[0] for info in infos}
        self._joints = tuple(index[name] for name in self._world.joint_names)
        base = bullet.getBodyInfo(self.robot, physicsClientId=client)[0].decode()
        self._links = {_BASE: base, **{info[0]: info[12].decode() for info in infos}}
        place = {name: link for link, name in self._links.items()}
        self._tip_fingers = {
            place[finger.tip_frame]: name for name, finger in self._world.fingers.items()
        }

    def _set_bodies(self) -> None:
        bullet, client = self._bullet, self.client
        for body, links in ((self.robot, tuple(self._links)), (self.tool, (_BASE,))):
            for link in links:
                bullet.changeDynamics(
                    body,
                    link,
                    linearDamping=0.0,
                    angularDamping=0.0,
                    maxJointVelocity=1e4,
                    physicsClientId=client,
                )
        # Bullet's default motors hold every joint; without force they are off, and with little
        # they are dry friction, solved implicitly with the contacts.
        bullet.setJointMotorControlArray(
            self.robot,
            self._joints,
            bullet.VELOCITY_CONTROL,
            targetVelocities=[0.0] * len(self._joints),
            forces=self._world.joint_friction.tolist(),
            physicsClientId=client,
        )
        # Bullet poses a body by the principal axes of its inertia.
        info = bullet.getDynamicsInfo(self.tool, _BASE, physicsClientId=client)
        self._principal_in_tool = np.reshape(bullet.getMatrixFromQuaternion(info[4]), (3, 3))

    def _set_contacts(self) -> None:
        world, options = self._world, self._options
        soft = {}
        if options.contact_stiffness is not None:
            soft = {
                "contactStiffness": options.contact_stiffness,
                "contactDamping": options.contact_damping,
            }
        self._change(self.tool, _BASE, lateralFriction=1.0)
        self._change(self.table, _BASE, lateralFriction=world.table_friction, **soft)
        for link in self._links:
            finger = self._tip_fingers.get(link)
            if finger is None:
                self._change(self.robot, link, lateralFriction=1.0)
            else:
                friction, torsion = (
                    world.finger_friction[finger],
                    world.finger_torsion.get(finger, 0.0),
                )
                values = {"lateralFriction": friction, "spinningFriction": torsion, **soft}
                self._change(self.robot, link, **values)

    def _change(self, body: int, link: int, **values: float) -> None:
        self._bullet.changeDynamics(
            body,
            link,
            physicsClientId=self.client,
            **{"rollingFriction": 0.0, "spinningFriction": 0.0, "restitution": 0.0, **values},
        )

    def _set_pairs(self) -> None:
        quiet = quiet_pairs(self._world.robot_urdf, self._world.never_touch)
        place = {name: link for link, name in self._links.items()}
        for one, other in quiet.among:
            self._bullet.setCollisionFilterPair(
                self.robot, self.robot, place[one], place[other], 0, physicsClientId=self.client
            )
        for link in quiet.fixed:
            self._bullet.setCollisionFilterPair(
                self.robot, self.table, place[link], _BASE, 0, physicsClientId=self.client
            )


def _add(total: list[float], point: Any, place: Any, sign: float) -> None:
    """Add a contact point's force on the tool, and its place weighted by its normal force.

    Bullet tells the force on its body A: normal [7] times [9] and two directions of friction.
    """
    x, y, z = place
    along, first, second = point[9], point[10], point[12]
    (nx, ny, nz), (ox, oy, oz), (tx, ty, tz) = point[7], point[11], point[13]
    total[0] += sign * (along * nx + first * ox + second * tx)
    total[1] += sign * (along * ny + first * oy + second * ty)
    total[2] += sign * (along * nz + first * oz + second * tz)
    total[3] += along * x
    total[4] += along * y
    total[5] += along * z
    total[6] += along
