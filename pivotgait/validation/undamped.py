"""A robot's URDF without joint damping."""

from __future__ import annotations

from pivotgait.models.robot_parts import write
from pivotgait.models.urdf.nodes import read_nodes


def undamped(urdf: str) -> str:
    """URDF text without joint damping.

    Bullet integrates it explicitly, which is unstable beyond about 1e-3 N m s/rad for a hand, and
    its ``changeDynamics(jointDamping=...)`` has no effect on a loaded multibody.
    """
    root = read_nodes(urdf, where="robot of the plan")
    for joint in root.all("joint"):
        for dynamics in joint.all("dynamics"):
            dynamics.attributes["damping"] = "0"
    return write(root)
