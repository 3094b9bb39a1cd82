"""A revised scene is the scene that its fields, read from a file, would give."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from pivotgait.exceptions import SceneError
from pivotgait.models import Scene, load_scene, parse_scene, revise_scene


def data_of(scene: Scene) -> dict[str, Any]:
    found = scene.config.model_dump(mode="json", by_alias=True)
    assert isinstance(found, dict)
    return found


def put(*path: str | int, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(data: Any) -> None:
        for key in path[:-1]:
            data = data[key]
        data[path[-1]] = value

    return change


@pytest.mark.parametrize(
    "change",
    [
        put("name", value="other"),
        put("table", "friction", value=0.9),
        put("table", "height_m", value=0.1),
        put("rest", "roll_deg", value=-80.0),
        put("rest", "pivot_m", value=[0.5, 0.1]),
        put("contacts", "index_edge", "along_m", value=0.03),
        put("contacts", "index_edge", "friction", value=0.3),
        put("gravity_m_s2", value=[0.0, 0.0, -1.6]),
        put("robot", value=None),
        put("tool", "handle", "origin_m", value=[-0.22, 0.0, -0.0145]),
        put("tool", "urdf", value="chef_knife"),
    ],
)
def test_revised_is_parsed(change: Callable[[dict[str, Any]], None]) -> None:
    scene = load_scene("knife")
    data = data_of(scene)
    change(data)
    revised, parsed = revise_scene(scene, data), parse_scene(json.dumps(data))
    assert revised.config == parsed.config
    for name in ("table", "tool"):
        same(getattr(revised, name), getattr(parsed, name))
    for name in ("gravity", "pivot", "rest_orientation"):
        assert np.array_equal(getattr(revised, name), getattr(parsed, name))
    assert revised.rest_pitch == parsed.rest_pitch
    assert revised.gaits == parsed.gaits
    for name, contact in parsed.contacts.items():
        same(revised.contacts[name], contact)
    assert (revised.robot is None) == (parsed.robot is None)
    if revised.robot and parsed.robot:
        assert revised.robot.urdf == parsed.robot.urdf
        assert np.array_equal(revised.robot.model.gravity.linear, parsed.robot.model.gravity.linear)


def same(one: Any, other: Any) -> None:
    """Arrays and plain numbers of two records are equal."""
    for entry in fields(one):
        left, right = getattr(one, entry.name), getattr(other, entry.name)
        if isinstance(left, np.ndarray | float | str):
            assert np.array_equal(left, right), entry.name


def test_what_does_not_change_is_kept() -> None:
    scene = load_scene("knife")
    data = data_of(scene)
    data["table"]["friction"] = 0.9
    revised = revise_scene(scene, data)
    assert revised.tool is scene.tool
    assert revised.robot is scene.robot


def test_errors_are_those_of_a_file() -> None:
    scene = load_scene("knife")
    data = data_of(scene)
    data["contacts"]["index_edge"]["along_m"] = 9.0
    with pytest.raises(SceneError, match=r"mine: contacts\.index_edge"):
        revise_scene(scene, data, where="mine")
    data["table"]["friction"] = float("nan")
    with pytest.raises(SceneError, match=r"mine: table\.friction"):
        revise_scene(scene, data, where="mine")
