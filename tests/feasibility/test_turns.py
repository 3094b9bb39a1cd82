"""The smallest tilt: equal to the planner's own search, and truly the edge."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.feasibility import held_at, smallest_tilt, static_verdicts
from pivotgait.feasibility.turns import DIRECTIONS, STEP_RAD
from pivotgait.models import RemovalPhase, load_scene
from pivotgait.phases.grasp import Setting
from pivotgait.phases.removal import RemovalOptions, removal_problem
from pivotgait.phases.static_grasp import smallest_turn
from tests.feasibility.rehearsed import before_removal


@pytest.mark.parametrize("name", ["knife", "screwdriver", "wrench"])
def test_it_agrees_with_the_nonlinear_program(name):
    scene = load_scene(name)
    grasp, config = before_removal(scene)
    leaving = scene.contacts[config.contact]
    staying = [each for each in grasp.fingers.values() if each is not leaving]
    found = smallest_tilt(scene, staying, grasp.rotation)
    options = RemovalOptions(config.duration_s, config.steps)
    problem = removal_problem(Setting.of(scene), grasp, staying, leaving, options)
    other = smallest_turn(problem)
    assert found.feasible
    assert other.feasible
    assert np.degrees(found.angle) == pytest.approx(np.degrees(other.angle), abs=0.02)
    assert isinstance(config, RemovalPhase)


def test_nearer_orientations_do_not_do():
    scene = load_scene("knife")
    grasp, config = before_removal(scene)
    staying = [each for each in grasp.fingers.values() if each.name != config.contact]
    found = smallest_tilt(scene, staying, grasp.rotation)
    rng = np.random.default_rng(0)
    way = rng.normal(size=(3000, 3))
    way *= (0.99 * found.angle * rng.uniform(0, 1, 3000) / np.linalg.norm(way, axis=1))[:, None]
    turned = Rotation.from_rotvec(way) * grasp.rotation
    assert not static_verdicts(held_at(scene, staying, turned)).feasible.any()
    assert static_verdicts(held_at(scene, staying, found.rotation)).feasible[0]
    assert scene.height(found.rotation) >= scene.clearance


def test_a_strip_between_the_nodes_of_the_scan_is_found():
    """The wrench is held in a strip that no node of the scan below 16 degrees lies in."""
    scene = load_scene("wrench")
    grasp, config = before_removal(scene)
    staying = [each for each in grasp.fingers.values() if each.name != config.contact]
    found = smallest_tilt(scene, staying, grasp.rotation)
    assert 14.0 < np.degrees(found.angle) < 14.1
    assert static_verdicts(held_at(scene, staying, found.rotation)).feasible[0]
    assert scene.height(found.rotation) >= scene.clearance
    ways = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    axes = np.stack((np.cos(ways), np.sin(ways), np.zeros(DIRECTIONS)), axis=1)
    for size in np.arange(0.0, np.radians(16.0), STEP_RAD):
        turned = Rotation.from_rotvec(size * axes) * grasp.rotation
        clear = scene.height(turned) >= scene.clearance
        assert not static_verdicts(held_at(scene, staying, turned[clear])).feasible.any()


def test_without_room_to_turn_there_is_none():
    scene = load_scene("knife")
    grasp, config = before_removal(scene)
    staying = [each for each in grasp.fingers.values() if each.name != config.contact]
    found = smallest_tilt(scene, staying, grasp.rotation, turn_max_rad=np.radians(15.0))
    assert not found.feasible
    assert found.depth < 0.0
    assert smallest_tilt(scene, staying, grasp.rotation, coarse=True).feasible
