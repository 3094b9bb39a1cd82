"""Parameters are set where their paths say, and nonsense is refused with the known ones."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.exceptions import InputError, SceneError, UnknownNameError
from pivotgait.feasibility import Variants
from pivotgait.models import load_scene

SCENE = load_scene("knife")
VARIANTS = Variants(SCENE)


def test_each_path_changes_what_it_names_and_nothing_else():
    other = VARIANTS.scene_with({"contacts.thumb_spine.friction": 0.3, "table.friction": 0.9})
    assert other.contacts["thumb_spine"].friction == 0.3
    assert other.contacts["index_edge"].friction == 0.8
    assert other.table.friction == 0.9
    every = VARIANTS.scene_with({"contacts.*.normal_force_N.max": 7.0})
    assert {each.normal_max for each in every.contacts.values()} == {7.0}
    assert SCENE.contacts["thumb_spine"].friction == 0.8


def test_phases_and_the_lifts_target_have_short_names():
    other = VARIANTS.scene_with({"tool.pitch_deg": 30.0, "addition.duration_s": 2.0})
    gait = other.gaits["default"]
    assert gait[0].to.pitch_deg == 30.0
    assert [each.duration_s for each in gait if each.kind == "addition"] == [2.0, 2.0]
    assert VARIANTS.scene_with({"lift.steps": 30.0}).gaits["default"][0].steps == 30


def test_a_contact_moves_on_the_handle():
    other = VARIANTS.scene_with({"contacts.thumb_spine.along_m": 0.05})
    given = SCENE.config.contacts["thumb_spine"].along_m
    moved = other.contacts["thumb_spine"].point - SCENE.contacts["thumb_spine"].point
    assert np.linalg.norm(moved) == pytest.approx(0.05 - given, abs=1e-6)


def test_mass_and_inertia_scale_together():
    other = VARIANTS.scene_with({"tool.mass_scale": 2.0, "table.friction": 0.3})
    assert other.tool.mass == pytest.approx(2.0 * SCENE.tool.mass)
    assert np.allclose(other.tool.inertia, 2.0 * SCENE.tool.inertia)
    assert other.table.friction == 0.3
    assert VARIANTS.scene_with({}) is SCENE


@pytest.mark.parametrize(
    ("path", "value", "error", "words"),
    [
        ("contacts.thumb.friction", 0.3, UnknownNameError, "thumb_spine"),
        ("tabel.friction", 0.3, UnknownNameError, "table"),
        ("contacts.thumb_spine", 0.3, InputError, "not a single number"),
        ("contacts.thumb_spine.friction", -0.3, SceneError, "greater than 0"),
        ("contacts.thumb_spine.friction", "high", SceneError, "must be a number"),
        ("contacts.thumb_spine.along_m", 5.0, SceneError, "off the handle"),
        ("tool.pitch_deg", 1.0, SceneError, "over the table"),
        ("tool.mass_scale", 0.0, InputError, "> 0"),
        ("tool.mass_scale", float("nan"), InputError, "> 0"),
        ("tool.mass_scale", "heavy", InputError, "> 0"),
    ],
)
def test_nonsense_is_refused(path, value, error, words):
    with pytest.raises(error) as caught:
        VARIANTS.scene_with({path: value})
    assert words in str(caught.value)
