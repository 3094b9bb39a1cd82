"""The square task Jacobian H and the palm coordinates that keep it far from singular.

Task coordinates (Xue et al., Section VI): five rows per holding finger, the joints of every
other finger, and as many coordinates of the palm as make H square. Chosen blindly, the palm's
share makes H singular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import InfeasibleError, InputError
from pivotgait.frozen import Array
from pivotgait.kinematics.closed_chain import ROWS_PER_HOLD, ClosedChain
from pivotgait.kinematics.frame_coordinates import FrameCoordinates
from pivotgait.kinematics.hold import Hold
from pivotgait.models import Robot

COORDINATE_NAMES = ("theta", "psi", "phi", "x", "y", "z")
ANGLE_LENGTH = 0.03
"""Length that stands for one radian [m]: about that of a phalanx."""


@dataclass(frozen=True)
class PalmRows:
    """Rows of H that are left to the palm.

    Attributes:
        coordinates: places in the palm's xi = (theta, psi, phi, x, y, z).
        joints: columns of joints that are held by themselves, where six do not suffice.
    """

    coordinates: tuple[int, ...]
    joints: tuple[int, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return tuple(COORDINATE_NAMES[place] for place in self.coordinates)


@dataclass(frozen=True)
class PalmChoice:
    """The palm rows chosen for a motion.

    Attributes:
        rows: that were chosen.
        smallest_singular_value: of the scaled H, the smallest over the motion [m]. It grows
            with ``angle_length``, somewhat less than in proportion; a guide rather than a limit:
            closed-loop trials went well above about 3 mm and failed at 0.02 mm.
    """

    rows: PalmRows
    smallest_singular_value: float


class TaskJacobian:
    """H at one configuration after another, for every admissible choice of palm rows.

    The palm is described by the local coordinates of its frame relative to the tool frame
    turned by ``palm_target``. H is judged **scaled to lengths**: a row that is an angle counts
    as ``angle_length`` times it, and so does a joint that turns; a sliding joint counts as a
    turning one of that arm. All of H is then in metres per unit, and its smallest singular
    value is the distance [m] to the nearest singular matrix.

    Attributes:
        robot: the arm-hand.
        chain: rows of the holding fingers.
        palm: the palm's six local coordinates.
        candidates: every admissible choice of palm rows.
        idle_columns: joints of the fingers that do not hold, in the order of their rows.
        column_scale: (nv,) factors of the columns of H: one, or ``angle_length`` where a joint
            slides.
    """

    def __init__(
        self,
        robot: Robot,
        holds: Sequence[Hold],
        *,
        palm_target: Array | None = None,
        angle_length: float = ANGLE_LENGTH,
    ) -> None:
        """H of a robot that holds the tool by ``holds``; all its other fingers are idle.

        Args:
            robot: the arm-hand.
            holds: the holding fingers, each once.
            palm_target: (3, 3) axes, in the tool frame, from which the palm's angles count; the
                tool's own if not given. Choose them within 90 degrees of the palm's.
            angle_length: length of one radian [m], usually 0.02 to 0.05.

        Raises:
            InputError: for a finger that holds twice or an ``angle_length`` that is not positive.
            InfeasibleError: if fingers alone take more rows than the robot has joints.
        """
        if not 0.0 < angle_length < np.inf:
            raise InputError(f"angle_length {angle_length} m", mend="give a positive length")
        self.robot = robot
        self.chain = ClosedChain(robot, holds)
        self.palm = FrameCoordinates(
            robot.model,
            self.chain.data,
            robot.palm_frame_id,
            frameRcontact=np.eye(3),
            toolRtarget=np.eye(3) if palm_target is None else palm_target,
            centre=np.zeros(3),
        )
        self.idle_columns = _idle_columns(robot, holds)
        self.candidates = _candidates(robot, self.chain, self.idle_columns)
        self._length = angle_length
        sliding = [joint.shortname().startswith("JointModelP") for joint in robot.model.joints[1:]]
        self.column_scale = np.where(sliding, angle_length, 1.0)

    def update(self, q: Array, oRtool: Array, tool_position: Array) -> None:
        """Compute the rows at a configuration.

        Args:
            q: (nv,) configuration.
            oRtool: (3, 3) orientation of the tool, world <- tool.
            tool_position: (3,) origin of the tool frame, world [m].

        Raises:
            SingularCoordinatesError: for a tip or the palm turned 90 degrees from its target.
        """
        self.chain.update(q, oRtool, tool_position)
        self.palm.refresh(oRtool, tool_position)

    def matrix(self, rows: PalmRows) -> Array:
        """(nv, nv) H: fingers, idle joints, palm coordinates, joints of ``rows``, unscaled."""
        unit = np.eye(self.robot.nv)
        palm = self.palm.jacobian[list(rows.coordinates)]
        parts = (self.chain.jacobian, unit[list(self.idle_columns)], palm, unit[list(rows.joints)])
        return np.concatenate(parts)

    def row_scale(self, rows: PalmRows) -> Array:
        """(nv,) factors of the rows of :meth:`matrix` that turn them into lengths."""
        turning = [self._length if place < 3 else 1.0 for place in rows.coordinates]
        # A joint's own row becomes length x unit, whether it turns or slides.
        joint = [self._length / self.column_scale[k] for k in (*self.idle_columns, *rows.joints)]
        idle = len(self.idle_columns)
        return np.concatenate(
            (self.chain.row_lengths(self._length), joint[:idle], turning, joint[idle:])
        )

    def scaled_matrix(self, rows: PalmRows) -> Array:
        """(nv, nv) H with rows and columns scaled to lengths [m]."""
        return np.asarray(self.row_scale(rows)[:, None] * self.matrix(rows) * self.column_scale)

    def smallest_singular_values(self) -> Array:
        """(number of candidates,) smallest singular value of each scaled H [m]."""
        stack = np.stack([self.scaled_matrix(rows) for rows in self.candidates])
        return np.asarray(np.linalg.svd(stack, compute_uv=False)[:, -1])


def palm_axes(robot: Robot, q: Array, oRtool: Array) -> Array:
    """(3, 3) the palm's axes in the tool frame at q: from there its angles are regular.

    Args:
        robot: the arm-hand.
        q: (nv,) configuration.
        oRtool: (3, 3) orientation of the tool, world <- tool.
    """
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    palm = pin.updateFramePlacement(robot.model, data, robot.palm_frame_id)
    return np.asarray(oRtool.T @ palm.rotation)


def smallest_singular_value(task: TaskJacobian, rows: PalmRows) -> float:
    """Distance of the scaled H from singularity at the last ``task.update`` [m]."""
    return float(np.linalg.svd(task.scaled_matrix(rows), compute_uv=False)[-1])


def choose_palm_rows(
    task: TaskJacobian, q: Array, oRtool: Array, tool_position: Array
) -> PalmChoice:
    """The palm rows whose worst conditioning over a motion is best.

    Args:
        task: the holds.
        q: (N, nv) configurations of the motion; or one, (nv,).
        oRtool: (N, 3, 3) orientations of the tool, world <- tool; or one.
        tool_position: (N, 3) origins of the tool frame, world [m]; or one.

    Raises:
        SingularCoordinatesError: for a tip or the palm turned 90 degrees from its target.
    """
    worst = np.full(len(task.candidates), np.inf)
    for each in zip(
        q.reshape(-1, task.robot.nv),
        oRtool.reshape(-1, 3, 3),
        tool_position.reshape(-1, 3),
        strict=True,
    ):
        task.update(*each)
        worst = np.minimum(worst, task.smallest_singular_values())
    best = int(np.argmax(worst))
    return PalmChoice(task.candidates[best], float(worst[best]))


def _idle_columns(robot: Robot, holds: Sequence[Hold]) -> tuple[int, ...]:
    names = [hold.finger.name for hold in holds]
    if len(set(names)) != len(names):
        raise InputError(f"a finger holds twice: {', '.join(names)}", mend="give each hold once")
    return tuple(
        column
        for name, finger in robot.fingers.items()
        if name not in names
        for column in finger.columns
    )


def _candidates(robot: Robot, chain: ClosedChain, idle: Sequence[int]) -> tuple[PalmRows, ...]:
    left = robot.nv - chain.rows - len(idle)
    if left < 0:
        raise InfeasibleError(
            f"the holds take {chain.rows} rows and the idle fingers {len(idle)}, "
            f"but {robot.name} has only {robot.nv} joints",
            mend="hold with fewer fingers",
        )
    places = range(len(COORDINATE_NAMES))
    if left <= len(places):
        return tuple(PalmRows(chosen) for chosen in combinations(places, left))
    spare = _redundant_columns(robot, chain)
    return tuple(
        PalmRows(tuple(places), chosen) for chosen in combinations(spare, left - len(places))
    )


def _redundant_columns(robot: Robot, chain: ClosedChain) -> tuple[int, ...]:
    """Joints of an arm with more than six, and of holding fingers with more than five.

    Only there can a joint move while the palm and the tips stay, so only their rows can
    complete H.
    """
    arm = robot.palm_columns if len(robot.palm_columns) > len(COORDINATE_NAMES) else ()
    fingers = (hold.finger.columns for hold in chain.holds)
    return arm + tuple(c for columns in fingers if len(columns) > ROWS_PER_HOLD for c in columns)
