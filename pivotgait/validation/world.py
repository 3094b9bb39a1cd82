"""What a simulator is given: bodies, frictions and gravity as they really are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.urdf import check_urdf
from pivotgait.plans import PIVOT, GaitPlan, PlannedFinger

_SAME_PLACE_M = 1e-6


@dataclass(frozen=True, eq=False)
class World(FrozenArrays):
    """Arm-hand, tool and table of one trial. A perturbed trial has another world than its plan.

    Attributes:
        robot_urdf: whole text; its root is the world frame.
        joint_names: order of q, v and torques.
        fingers: tip frame (a link of the robot) and radius, by the contacts' names.
        never_touch: pairs of the robot's links whose contacts do not count.
        tool_urdf: whole text of one link.
        pivot_in_tool: (3,) centre of the tip sphere in the tool frame, whose origin is the
            centre of mass and whose axes are those of the URDF's root link [m].
        tip_radius: of the tool's tip sphere [m].
        finger_friction: Coulomb coefficient of each fingertip on the tool.
        table_friction: Coulomb coefficient of the tool on the table.
        table_height: z of the table's plane [m].
        gravity: (3,) world [m/s^2].
        joint_friction: (nv,) dry friction of the joints [N m] or [N].
        finger_torsion: coefficient of torsional friction of each soft fingertip on the tool [m];
            those left out are points.
    """

    robot_urdf: str
    joint_names: tuple[str, ...]
    fingers: Mapping[str, PlannedFinger]
    never_touch: tuple[tuple[str, str], ...]
    tool_urdf: str
    pivot_in_tool: Array
    tip_radius: float
    finger_friction: Mapping[str, float]
    table_friction: float
    table_height: float
    gravity: Array
    joint_friction: Array
    finger_torsion: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, plan: GaitPlan) -> World:
        """The world as a plan takes it to be.

        A finger has one coefficient of each friction here: the least of its contacts'.

        Raises:
            PlanFileError: for a plan without a robot, or whose tool has no sphere at the pivot.
        """
        if plan.robot is None:
            raise PlanFileError(
                "holds no motion of a robot",
                where="plan",
                mend="plan a scene with a robot, without --no-hand",
            )
        tracks = [each for phase in plan.phases for each in phase.contacts.values()]
        friction = {
            name: min((each.friction for each in tracks if each.name == name), default=1.0)
            for name in (*plan.robot.fingers, PIVOT)
        }
        torsion = {
            name: min((each.torsion for each in tracks if each.name == name), default=0.0)
            for name in plan.robot.fingers
        }
        return cls(
            robot_urdf=plan.robot.urdf,
            joint_names=plan.robot.joint_names,
            fingers=plan.robot.fingers,
            never_touch=plan.robot.never_touch,
            tool_urdf=plan.tool.urdf,
            pivot_in_tool=plan.tool.pivot_in_tool,
            tip_radius=_tip_radius(plan),
            finger_friction={name: friction[name] for name in plan.robot.fingers},
            finger_torsion=torsion,
            table_friction=friction[PIVOT],
            table_height=plan.table_height,
            gravity=plan.gravity,
            joint_friction=np.zeros(len(plan.robot.joint_names)),
        )


def _tip_radius(plan: GaitPlan) -> float:
    tool = plan.tool
    for shape in check_urdf(tool.urdf, where="tool of the plan").collisions:
        place = shape.translation - tool.centre_of_mass_in_root
        if shape.kind == "sphere" and np.allclose(place, tool.pivot_in_tool, atol=_SAME_PLACE_M):
            return shape.size[0]
    raise PlanFileError(
        "the tool has no collision sphere at its pivot",
        where="plan/tool",
        mend="write the plan again with 'pivotgait plan'",
    )
