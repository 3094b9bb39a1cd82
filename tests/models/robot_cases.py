"""Arms, hands and scene fields from which the robots of these tests are made."""

import json
from pathlib import Path
from typing import Any

from pivotgait.models import urdf_root
from pivotgait.models.robot_config import RobotConfig
from pivotgait.models.robot_urdf import robot_urdf
from pivotgait.models.urdf_files import EXAMPLE_ROBOT_DATA, example_robots

UR5 = f"{EXAMPLE_ROBOT_DATA}ur_description/urdf/ur5_robot.urdf"
ROBOTS = example_robots()
assert ROBOTS is not None, "a dependency of the package"
UR5_PATH = ROBOTS / UR5.removeprefix(EXAMPLE_ROBOT_DATA)
HAND_PATH = urdf_root() / "allegro_right_hand" / "allegro_right_hand.urdf"
POSE = {"position_m": [0.01, -0.02, 0.1], "rpy_deg": [10.0, -20.0, 70.0]}
BASE = {"position_m": [-0.2, 0.1, 0.3], "yaw_deg": 40.0}
RING = {"joint_8.0": 0.1, "joint_9.0": 1.4, "joint_10.0": 1.5, "joint_11.0": 1.0}
THREE = (("index", 0), ("middle", 4), ("thumb", 12))
ARM = """<robot name="arm">
  <link name="world"/>
  <link name="base"/>
  <link name="palm">
    <inertial>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>
    </inertial>
    <collision name="pad_0">
      <geometry>
        <box size="0.1 0.1 0.1"/>
      </geometry>
    </collision>
  </link>
  <joint name="fix" type="fixed">
    <parent link="world"/>
    <child link="base"/>
  </joint>
  <joint name="turn" type="revolute">
    <parent link="base"/>
    <child link="palm"/>
    <origin xyz="0 0 0.5" rpy="0.1 0.2 0.3"/>
    <axis xyz="0 0.6 0.8"/>
    <limit lower="-1" upper="2" effort="10" velocity="2"/>
    <safety_controller k_velocity="1"/>
  </joint>
  <transmission name="t"/>
</robot>
"""
HAND = """<robot name="hand" version="1.1">
  <link name="palm"/>
  <link name="slider">
    <inertial>
      <mass value="0.5"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/>
    </inertial>
    <collision name="pad_0">
      <geometry>
        <sphere radius="0.01"/>
      </geometry>
    </collision>
  </link>
  <joint name="turn" type="prismatic">
    <parent link="palm"/>
    <child link="slider"/>
    <origin xyz="0 0.1 0" rpy="0 0.5 0"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.1" effort="10" velocity="2"/>
  </joint>
</robot>
"""


def fields(**changes: Any) -> dict[str, Any]:
    """Fields of the UR5 with the Allegro hand, a key of value None left out."""
    given: dict[str, Any] = {
        "mount": {"arm": UR5, "hand": "allegro_right_hand", "frame": "tool0", **POSE},
        "base": BASE,
        "fixed": RING,
        "palm": "palm_link",
        "fingers": {
            name: {
                "tip_frame": f"link_{start + 3}.0_tip",
                "tip_radius_m": 0.012,
                "pad": [1, 0, 0],
                "joints": [f"joint_{start + k}.0" for k in range(4)],
            }
            for name, start in THREE
        },
        **changes,
    }
    return {key: value for key, value in given.items() if value is not None}


def config(**changes: Any) -> RobotConfig:
    return RobotConfig.model_validate_json(json.dumps(fields(**changes)))


def text_of(folder: Path | None = None, **changes: Any) -> str:
    return robot_urdf(config(**changes), folder, where="s.yaml: robot")


def small(parts: Path, **changes: Any) -> str:
    """URDF text of the two-joint arm and hand written into the folder ``parts``."""
    (parts / "arm.urdf").write_text(ARM)
    (parts / "hand.urdf").write_text(HAND)
    given = {"mount": {"arm": "arm.urdf", "hand": "hand.urdf", "frame": "palm"}, "base": {}}
    return text_of(parts, **{**given, "fixed": {}, **changes})
