"""Cross-simulator checks: five robots agree, known traps are found, and each change is seen."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pivotgait.exceptions import InputError, UnknownNameError, UrdfError
from pivotgait.models.urdf_files import example_robots
from pivotgait.validation.crosscheck import ENGINES, CrossCheck, Tolerances, cross_check
from pivotgait.validation.crosscheck import reading as module

pytest.importorskip("mujoco")

ROBOTS = example_robots()
AGREEING = {
    "panda_description/urdf/panda.urdf": 9,
    "ur_description/urdf/ur5_robot.urdf": 6,
    "solo_description/robots/solo12.urdf": 12,
    "go2_description/urdf/go2.urdf": 12,
    "talos_data/robots/talos_reduced.urdf": 32,
}
"""Files and the number of joints that move; shapes are left out, inertias are those written."""
KNIFE_HAND = Path(__file__).parents[2] / "urdf/cobra_s800_shadow/cobra_s800_shadow.urdf"
SMALL = """<?xml version="1.0"?>
<robot name="small" version="1.1">
<link name="world"/>
<link name="upper"><inertial><origin xyz="0 0 0.2" rpy="0.1 0.2 0.3"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
<link name="lower"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hip" type="revolute"><origin xyz="0 0 1" rpy="0 0.5 0"/>
<parent link="world"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="2" effort="30" velocity="3"/></joint>
<joint name="knee" type="prismatic"><origin xyz="0 0 0.4"/>
<parent link="upper"/><child link="lower"/><axis xyz="0 0 1"/>
<limit lower="0" upper="0.1" effort="10" velocity="1"/><dynamics damping="0.3" friction="0.2"/>
</joint>
</robot>
"""


def failing(found: CrossCheck) -> set[tuple[str, str]]:
    return {(row.engine, row.quantity) for row in found.rows if not row.holds}


def robot(name: str) -> Path:
    if ROBOTS is None:
        pytest.skip("example-robot-data is not installed")
    return ROBOTS / name


@pytest.mark.parametrize(("name", "joints"), AGREEING.items())
def test_five_robots_are_the_same_in_all_engines(name: str, joints: int) -> None:
    found = cross_check(robot(name), friction=None)
    assert found.agrees, found.table()
    assert len(found.rows) == 16
    with ENGINES["mujoco"](_bare(robot(name))) as reading:
        assert len(reading.joints) == joints


def _bare(path: Path) -> str:
    from pivotgait.validation.crosscheck.checks import without_shapes

    return without_shapes(path.read_text(encoding="utf-8"), where=path.name)


@pytest.mark.parametrize("urdf", [SMALL, KNIFE_HAND], ids=["small", "cobra_s800_shadow"])
def test_damping_friction_and_tilted_inertias_do_not_matter(urdf: str | Path) -> None:
    found = cross_check(urdf, friction=None)
    assert found.agrees, found.table()


def test_a_link_without_inertia_weighs_a_kilogram_in_bullet() -> None:
    found = cross_check(robot("xarm_description/urdf/xarm7.urdf"), friction=None)
    assert failing(found) == {("pybullet", "mass matrix"), ("pybullet", "inverse dynamics")}


def test_mujoco_leaves_no_log_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    cross_check(robot("panda_description/urdf/panda.urdf"), friction=None)  # it has a mimic joint
    assert not list(tmp_path.iterdir())


def test_bullet_gives_continuous_joints_the_limits_they_should_not_have() -> None:
    found = cross_check(robot("kinova_description/robots/kinova.urdf"), friction=None)
    assert failing(found) == {("pybullet", "position limits")}


def test_inertias_that_no_body_has_are_refused_by_mujoco_and_zeroed_by_bullet() -> None:
    path = robot("allegro_hand_description/urdf/allegro_right_hand.urdf")
    found = cross_check(path, friction=None)
    assert ("mujoco", "loads") in failing(found)
    assert ("pybullet", "mass matrix") in failing(found)
    assert "A + B >= C" in found.table()


@pytest.mark.parametrize(
    ("old", "new", "quantities"),
    [
        ('<mass value="2"/>', '<mass value="2.001"/>', {"mass matrix", "inverse dynamics"}),
        ('xyz="0 0 0.4"', 'xyz="0 0 0.401"', {"link positions", "mass matrix"}),
        ('rpy="0 0.5 0"', 'rpy="0 0.501 0"', {"link orientations", "inverse dynamics"}),
        ('upper="2"', 'upper="2.001"', {"position limits"}),
        ('effort="30"', 'effort="31"', {"effort limits"}),
        ('name="knee"', 'name="ankle"', {"joints"}),
        ('"lower"', '"shin"', {"links"}),
    ],
)
def test_each_change_is_seen(
    monkeypatch: pytest.MonkeyPatch, old: str, new: str, quantities: set[str]
) -> None:
    """One engine is given another text."""
    assert old in SMALL

    def other(urdf: str) -> module.Reading:
        return ENGINES["mujoco"](urdf.replace(old, new))

    patched = {"pinocchio": ENGINES["pinocchio"], "mujoco": other}
    monkeypatch.setattr("pivotgait.validation.crosscheck.checks.ENGINES", patched)
    found = cross_check(SMALL, engines=("pinocchio", "mujoco"), friction=None)
    seen = {quantity for _, quantity in failing(found)}
    assert quantities <= seen
    lines = [line for line in found.table().splitlines() if line.startswith("!!")]
    assert len(lines) == len(seen)


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_contacts_keep_coulombs_law(engine: str) -> None:
    from pivotgait.validation.crosscheck.friction import friction_deviation

    deviation, where = friction_deviation(engine, 0.5)
    assert deviation <= Tolerances().friction
    assert where.endswith("deg")


def test_friction_is_a_row_of_each_simulator() -> None:
    found = cross_check(SMALL, postures=1)
    assert found.agrees, found.table()
    rows = [row.engine for row in found.rows if row.quantity == "contact friction"]
    assert rows == ["pybullet", "mujoco"]


def test_the_same_seed_gives_the_same_table() -> None:
    one, two = (
        cross_check(SMALL, friction=None, rng=np.random.default_rng(4)).table() for _ in range(2)
    )
    assert one == two


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: cross_check("nothing.urdf"), InputError),
        (lambda: cross_check("<robot"), UrdfError),
        (lambda: cross_check(SMALL, engines=("pinocchio",)), InputError),
        (lambda: cross_check(SMALL, engines=("pinocchio", "bullet")), UnknownNameError),
        (lambda: cross_check(SMALL, postures=0), InputError),
        (lambda: cross_check("<robot name='x'><link name='y'/></robot>"), InputError),
        (lambda: Tolerances(limit=0.0), InputError),
    ],
)
def test_bad_input_is_refused(call: Callable[[], object], error: type[Exception]) -> None:
    with pytest.raises(error):
        call()


def test_a_missing_engine_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "pivotgait.validation.engine_check.find_spec",
        lambda name: None if name == "mujoco" else name,
    )
    with pytest.raises(InputError, match=r"pip install 'pivotgait\[mujoco\]'"):
        cross_check(SMALL)
