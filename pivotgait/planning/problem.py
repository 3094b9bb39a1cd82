"""What a relocation is asked to do, with its options."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.kinematics import Hold
from pivotgait.models.robot import Robot
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.tool_path import ToolPath


@dataclass(frozen=True)
class RelocationOptions:
    """How a relocation is searched, smoothed and timed.

    Attributes:
        time_limit_s: of the search, shortcuts and smoothing apart [s].
        max_nodes: of both trees together.
        max_iterations: of the search.
        goal_bias: share of samples at the other end's fingertip pose.
        pose_share: share of samples that are fingertip poses, the others are configurations.
        sample_margin: the box of samples around start and goal reaches so much farther [m].
        turn_limit: samples are turned from the ends' orientations by up to this angle [rad].
        stride: longest step between two projections, as a bound on any shape's motion [m].
        check_step: the same between two collision checks [m]; half of it is padded.
        null_gain: share of the way of palm and finger to the goal that a step's free joints take.
        touch_zone: within it of its place at start or goal the moving tip may be nearer to the
            tool than the clearance [m].
        retreat: length of the way along the normal at a contact [m].
        shortcuts: number of attempts.
        speed_share: share of the joints' speed limits to use.
        acceleration_share: share of the joints' acceleration limits to use.
        sample_s: time between samples [s].
    """

    time_limit_s: float = 5.0
    max_nodes: int = 20_000
    max_iterations: int = 100_000
    goal_bias: float = 0.2
    pose_share: float = 0.6
    sample_margin: float = 0.05
    turn_limit: float = 0.8
    stride: float = 0.015
    check_step: float = 0.0015
    null_gain: float = 0.1
    touch_zone: float = 0.005
    retreat: float = 0.008
    shortcuts: int = 60
    speed_share: float = 0.9
    acceleration_share: float = 0.9
    sample_s: float = 0.01

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"is {value}", where=name, mend="give a number of 0 or more")
        for name in ("time_limit_s", "stride", "check_step", "sample_s", "speed_share"):
            if not getattr(self, name) > 0:
                raise InputError("is 0", where=name, mend="give a positive number")
        if not 0 < self.acceleration_share <= 1 or self.speed_share > 1 or self.goal_bias > 1:
            raise InputError("a share is above 1 or 0", mend="give shares in (0, 1]")


@dataclass(frozen=True, eq=False)
class RelocationProblem(FrozenArrays):
    """Move one fingertip from q_start to q_goal while the others hold the tool.

    Attributes:
        robot: the arm-hand.
        world: what may not be touched; without exemptions.
        holds: of the fingers that hold the tool (eq. 9), at start and goal alike.
        finger: name of the one that moves.
        start: (nv,) joint positions at s = 0 of the tool's path.
        goal: (nv,) joint positions at s = 1 (anywhere if the tool rests).
        tool: the tool's path, at rest or moving.
        start_normal: (3,) inward normal of the contact the finger leaves, tool frame; None if it
            starts in the air.
        goal_normal: (3,) inward normal of the contact it comes to, tool frame; None for the air.
        options: of the search.

    Raises:
        UnknownNameError: for a finger the robot does not have.
        InputError: for positions that are not finite or of a wrong shape, a normal that is no
            unit vector, or a moving finger that holds.
    """

    robot: Robot
    world: CollisionWorld
    holds: tuple[Hold, ...]
    finger: str
    start: Array
    goal: Array
    tool: ToolPath
    start_normal: Array | None = None
    goal_normal: Array | None = None
    options: RelocationOptions = field(default_factory=RelocationOptions)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.finger not in self.robot.fingers:
            raise UnknownNameError("finger", self.finger, self.robot.fingers)
        if self.finger in self.holding:
            raise InputError(f"{self.finger} moves and holds", mend="leave its hold out")
        for name in ("start", "goal"):
            q = getattr(self, name)
            if q.shape != (self.robot.nv,) or not np.all(np.isfinite(q)):
                mend = f"give {self.robot.nv} finite joint positions"
                raise InputError(f"cannot be used: {q}", where=name, mend=mend)
        for name in ("start_normal", "goal_normal"):
            normal = getattr(self, name)
            if normal is not None and not abs(np.linalg.norm(normal) - 1.0) <= 1e-6:
                raise InputError(f"{normal} is not a unit vector", where=name, mend="normalise it")

    @property
    def s_goal(self) -> float:
        """Parameter of the tool's path at the goal: 1, or 0 all the time if the tool rests."""
        return 1.0 if self.tool.moves else 0.0

    @property
    def holding(self) -> frozenset[str]:
        """Names of the fingers that hold."""
        return frozenset(hold.finger.name for hold in self.holds)
