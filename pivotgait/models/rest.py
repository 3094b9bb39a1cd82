"""How a tool lies on the table: on its tip and one more point."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import SceneError
from pivotgait.models.tool import Tool


def attitude(yaw: float, pitch: float, roll: float) -> Rotation:
    """Orientation Rz(yaw) Ry(pitch) Rx(roll), world <- tool, angles in [rad].

    A tool's +x points out of its tip, so a positive pitch points the tip down and raises the
    handle.
    """
    return Rotation.from_euler("ZYX", [yaw, pitch, roll])


def rest_pitch(tool: Tool, roll: float, *, where: str = "rest") -> float:
    """Smallest pitch [rad] at which no shape but the tip is below the table the tip rests on.

    A covering ball of radius a at the tool-frame point p has the height
    ``tip_radius - a + A sin(pitch + b)`` with ``A cos b = -q_x``, ``A sin b = q_z`` and q the
    rolled ``p - pivot``; it is on the table at ``pitch = asin((a - tip_radius) / A) - b``. The
    largest of these is the answer: exact but for cylinders, whose rims are rounded up.

    Args:
        tool: the tool.
        roll: about its x axis [rad].
        where: the field in messages.

    Raises:
        SceneError: if the tool cannot rest on its tip in this way.
    """
    points, radii = tool.support_points()
    lever = Rotation.from_euler("x", roll).apply(points - tool.pivot_in_tool)
    amplitude = np.hypot(lever[:, 0], lever[:, 2])
    drop = radii - tool.tip_radius
    mend = "make the tip sphere the tool's lowest point there, or change roll_deg"
    if len(points) == 0 or np.any(drop > amplitude):
        raise SceneError("a shape surrounds the tip sphere", where=where, mend=mend)
    ratio = np.divide(drop, amplitude, out=np.full_like(drop, -1.0), where=amplitude > 0.0)
    shift = np.arctan2(lever[:, 2], -lever[:, 0])
    pitch = float(np.max(np.arcsin(np.clip(ratio, -1.0, 1.0)) - shift))
    height = float(tool.height(attitude(0.0, pitch, roll).as_matrix()))
    if not (abs(pitch) < np.pi / 2 and height > -1e-9):
        raise SceneError("the tool cannot rest on its tip", where=where, mend=mend)
    return pitch
