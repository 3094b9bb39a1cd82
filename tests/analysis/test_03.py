"""Laws of study 03: a mounting changes what it says, a posture carried elsewhere stays one."""

from __future__ import annotations

import json
from collections import Counter
from types import ModuleType
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.models import load_scene
from pivotgait.plotting.reach import MountingMap, mounting_maps
from tests.analysis.studies import load_study


@pytest.fixture(scope="module")
def study() -> ModuleType:
    return load_study("03")


@pytest.fixture(scope="module")
def task(study: ModuleType) -> Any:
    return study.Task.of(load_scene("screwdriver"))


def frames(robot: Any, q: np.ndarray, *names: str) -> list[pin.SE3]:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return [pin.SE3(data.oMf[robot.model.getFrameId(name)]) for name in names]


def random_postures(robot: Any, count: int, seed: int) -> np.ndarray:
    """(count, nv) inside the limits, J4 within one turn."""
    rng = np.random.default_rng(seed)
    return rng.uniform(np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0), (count, 19))


@pytest.mark.parametrize(("tilt", "height"), [(0.0, 0.05), (30.0, 0.17), (52.5, 0.31)])
def test_a_mounting_reads_back_and_stands_on_its_pedestal(study, task, tilt, height):
    mounting = study.Mounting(tilt, height)
    assert study.Mounting.of(mounting.apply(task.urdf)) == mounting
    robot = task.robot(mounting)
    flange, forearm, base = frames(robot, pin.neutral(robot.model), "flange", "forearm", "arm_base")
    assert base.translation[2] == pytest.approx(height, abs=1e-12)
    down = (flange.rotation.T @ forearm.rotation)[:, 2]
    assert np.degrees(np.arccos(down[2])) == pytest.approx(tilt, abs=1e-6)
    (box,) = [g for g in robot.collision.geometryObjects if g.name == "pedestal_0"]
    assert 2.0 * box.geometry.halfSide[2] == pytest.approx(height)
    assert box.placement.translation[2] == pytest.approx(height / 2.0)


def test_the_urdfs_own_mounting_changes_nothing(study, task):
    own = study.Mounting.of(task.urdf)
    robot, before = task.robot(own), task.scene.robot
    q = random_postures(robot, 1, 0)[0]
    for one, other in zip(
        frames(robot, q, "palm", "thtip"), frames(before, q, "palm", "thtip"), strict=True
    ):
        np.testing.assert_allclose(one.homogeneous, other.homogeneous, rtol=0, atol=1e-12)


def test_the_rim_of_the_plate_clears_the_adapter(study):
    for tilt in np.linspace(0.0, 60.0, 25).tolist():
        rim = study.Mounting(tilt, 0.2).offset_m - study.PLATE_RADIUS_M * np.sin(np.radians(tilt))
        assert rim >= study.DISC_M - 1e-12


@pytest.mark.parametrize("height", [0.05, 0.17, 0.35])
def test_a_lower_pedestal_is_a_shift_of_j3(study, task, height):
    mounting, longer = study.long_quill(30.0)
    high, low = task.robot(mounting, longer), task.robot(study.Mounting(30.0, height))
    q = random_postures(high, 3, 1)
    shifted = study.shifted(high, q, mounting.height_m - height)
    for one, other in zip(q, shifted, strict=True):
        for a, b in zip(
            frames(high, one, "palm", "fftip"), frames(low, other, "palm", "fftip"), strict=True
        ):
            np.testing.assert_allclose(a.homogeneous, b.homogeneous, rtol=0, atol=1e-12)


@pytest.mark.parametrize("yaw_deg", [-150.0, 0.0, 70.0])
def test_a_carried_hand_moves_with_the_tool(study, task, yaw_deg):
    robot = task.scene.robot
    q = random_postures(robot, 6, 2)
    turn, shift = task.moved(0.4, yaw_deg)
    move = pin.SE3(turn, shift)
    carried = 0
    for k in range(len(q)):
        for moved in study.carried(robot, q[k : k + 1], turn, shift):
            before = frames(robot, q[k], "palm", "mftip")
            after = frames(robot, moved[0], "palm", "mftip")
            for a, b in zip(before, after, strict=True):
                np.testing.assert_allclose((move * a).homogeneous, b.homogeneous, rtol=0, atol=1e-9)
            carried += 1
    assert carried >= 2


def test_the_own_place_moves_nothing_but_about_the_arms_axis(study, task):
    turn, shift = task.moved(*task.place)
    np.testing.assert_allclose(shift, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.degrees(pin.rpy.matrixToRpy(turn))[:2], 0.0, atol=1e-9)
    q = random_postures(task.scene.robot, 1, 3)
    same = min(np.abs(each - q).max() for each in study.carried(task.scene.robot, q, turn, shift))
    assert same < 1e-9 + abs(pin.rpy.matrixToRpy(turn)[2])


def test_nothing_is_carried_beyond_the_arm(study, task):
    q = random_postures(task.scene.robot, 2, 4)
    assert list(study.carried(task.scene.robot, q, np.eye(3), np.array([2.0, 0.0, 0.0]))) == []


def test_limits_and_the_table_are_seen(study, task):
    robot = task.scene.robot
    world, keys = task.world(robot), task.keys
    up = np.tile(pin.neutral(robot.model), (len(keys), 1))
    up[:, :2] = 1.5, 1.0  # the arm turned away from the tool
    assert study.fits(robot, world, up, keys)
    beyond = np.array(up)
    beyond[2, robot.joint_names.index("J3")] = 0.22
    assert not study.fits(robot, world, beyond, keys)
    deep = np.array(up)
    deep[-1, robot.joint_names.index("J3")] = 0.21
    assert not study.fits(robot, world, deep, keys), "straight fingers reach below the table"


def test_more_tilt_swings_more_mass(study, task):
    inertia = [study.j4_inertia(task, tilt) for tilt in (0.0, 15.0, 30.0, 45.0, 60.0)]
    assert np.all(np.diff(inertia) > 0.0)
    limit = study.tilt_max_deg(task)
    assert study.j4_inertia(task, limit) == pytest.approx(study.J4_INERTIA_MAX, rel=1e-3)


@pytest.mark.parametrize(("found", "starts"), [(0, 20), (3, 60), (60, 60)])
def test_the_interval_holds_the_share(study, found, starts):
    search = study.Search(starts, tuple(range(found)), Counter())
    low, high = search.interval
    assert -1e-12 <= low <= found / starts + 1e-12
    assert found / starts - 1e-12 <= high <= 1.0 + 1e-12
    wider = study.Search(4 * starts, tuple(range(4 * found)), Counter()).interval
    assert wider[1] - wider[0] < high - low


@pytest.mark.parametrize("best", [0.0, 0.004, 0.07, 0.99])
def test_the_maps_show_every_share_and_no_cell_without_posture(best):
    share = np.array([[0.0, best, 0.0], [best / 2.0, 0.0, best]])
    worth = np.where(share > 0.0, 20.0 * share + 1.0, np.nan)
    tilts, heights = np.array([0.0, 30.0, 60.0]), np.array([100.0, 200.0])
    maps = [MountingMap(name, tilts, heights, share, worth, worth) for name in ("a", "b")]
    figure = mounting_maps(maps, own=(30.0, 170.0), tilt_max_deg=40.0)
    panels = [each for each in figure.axes if each.get_ylabel() == "pedestal [mm]"]
    assert len(panels) == 3
    for panel in panels:
        (mesh,) = [each for each in panel.collections if each.get_array() is not None]
        shown = mesh.get_array()
        assert shown.count() == np.count_nonzero(share)
        assert not shown.count() or shown.max() <= mesh.get_clim()[1] * (1.0 + 1e-9)


@pytest.mark.slow
def test_the_quick_study_writes_its_files_and_says_the_same(study, tmp_path):
    result = study.main(quick=True, out=tmp_path)
    names = ["mounting.pdf", "mounting.png", "place.pdf", "place.png", "reach.json"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    assert all(path.stat().st_size > 1000 for path in tmp_path.iterdir())
    read = json.loads((tmp_path / "reach.json").read_text())
    assert read["places"] == result["places"]
    for row in result["tilts"]:
        for each in row["scenes"].values():
            assert sum(each["failures"].values()) + each["found"] == each["starts"]
            assert max(each["fitting"]) <= each["found"]
    assert any(each["found"] for row in result["checks"] for each in row["scenes"].values())
