"""The plugin in a pytest run of somebody else's."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mujoco")

URDF = """<?xml version="1.0"?>
<robot name="pendulum" version="1.1">
<link name="base"/>
<link name="bob"><inertial><origin xyz="0 0 0.2"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="{kind}"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="2" effort="30" velocity="3"/></joint>
</robot>
"""
TEST = """
def test_mine(cross_simulators):
    found = cross_simulators("robot.urdf", friction=None)
    assert found.agrees
"""


@pytest.mark.parametrize(("kind", "agrees"), [("revolute", True), ("continuous", False)])
def test_the_fixture_passes_or_fails_with_the_table(
    tmp_path: Path, kind: str, agrees: bool
) -> None:
    (tmp_path / "robot.urdf").write_text(URDF.format(kind=kind), encoding="utf-8")
    (tmp_path / "test_mine.py").write_text(TEST, encoding="utf-8")
    plugin = ("-p", "pivotgait.pytest_plugin", "-p", "no:cacheprovider")
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", *plugin, "--rootdir", tmp_path, tmp_path],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (ran.returncode == 0) == agrees, ran.stdout
    assert ("!!  pybullet  position limits" in ran.stdout) == (not agrees)
    assert "Traceback" not in ran.stdout


def test_the_plugin_loads_nothing_heavy() -> None:
    code = "import sys, pivotgait.pytest_plugin; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    loaded = {name.split(".")[0] for name in run.stdout.split()}
    assert not loaded & {"numpy", "scipy", "pinocchio", "mujoco", "pybullet", "h5py"}
