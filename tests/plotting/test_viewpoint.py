"""The eye goes where the fingertips are seen."""

import numpy as np
import pytest

from pivotgait.plotting import mesh
from pivotgait.plotting.viewpoint import (
    Direction,
    Sight,
    clearest_direction,
    usual_direction,
    visible,
)

BALL = np.zeros((1, 3)), np.array([0.01])


def wall(azimuth):
    """A sphere at the origin with a wall before it that looks along ``azimuth``."""
    turn = np.array(
        [
            [np.cos(azimuth), -np.sin(azimuth), 0.0],
            [np.sin(azimuth), np.cos(azimuth), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    faces = (mesh.box((0.005, 0.15, 0.3)) + np.array([0.05, 0.0, 0.0])) @ turn.T
    return Sight(np.concatenate((faces, mesh.sphere(0.01))), *BALL)


@pytest.mark.parametrize("azimuth", np.radians([0.0, 50.0, 170.0, 265.0]))
def test_a_wall_hides_and_the_eye_goes_round_it(azimuth):
    before, behind = Direction(azimuth, 0.3), Direction(azimuth + np.pi, 0.3)
    sight = wall(azimuth)
    assert visible(sight, before.camera) == 0
    assert visible(sight, behind.camera) == 1
    chosen = clearest_direction([sight], before)
    assert visible(sight, chosen.camera) == 1


def test_a_free_sight_keeps_the_usual_direction():
    usual = usual_direction(np.array([1.0, 0.2, -0.1]))
    sight = Sight(mesh.sphere(0.01), *BALL)
    assert clearest_direction([sight], usual) == usual


def test_the_usual_direction_turns_with_the_tool():
    one, other = (usual_direction(np.array([np.cos(a), np.sin(a), -0.3])) for a in (0.1, 0.8))
    assert other.azimuth - one.azimuth == pytest.approx(0.7)
    assert other.elevation == one.elevation


def test_no_contacts_no_preference():
    sight = Sight(mesh.sphere(0.01), np.zeros((0, 3)), np.zeros(0))
    usual = Direction(0.3, 0.5)
    assert clearest_direction([sight], usual) == usual
