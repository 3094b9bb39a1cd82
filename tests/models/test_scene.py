"""Built-in scenes, their start pose, and how scenes are found."""

import json
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

from pivotgait.models import (
    LiftPhase,
    LiftTarget,
    Scene,
    SceneConfig,
    attitude,
    builtin_scenes,
    export_scene,
    load_scene,
    parse_scene,
    scene_schema,
    urdf_root,
)
from pivotgait.models.coal_shapes import ball_distance

SCENES = {name: load_scene(name) for name in builtin_scenes()}


@pytest.fixture(params=SCENES)
def scene(request: pytest.FixtureRequest) -> Scene:
    return SCENES[request.param]


def test_the_tools_are_built_in() -> None:
    tools = {"knife", "screwdriver", "wrench", "spatula", "table_knife"}
    assert tools <= set(builtin_scenes())


def test_tip_and_one_more_shape_touch_the_table_and_nothing_is_below(scene: Scene) -> None:
    rotation = scene.rest_rotation.as_matrix()
    # In the tool frame the table is a huge ball under the pivot, flat over the tool's length.
    size = 1e7
    centre = scene.tool.pivot_in_tool - (scene.tool.tip_radius + size) * rotation[2]
    heights = {s.name: ball_distance(s, centre, size)[0] for s in scene.tool.shapes}
    assert heights["tip"] == pytest.approx(0.0, abs=1e-6)
    others = [height for name, height in heights.items() if name != "tip"]
    assert min(others) == pytest.approx(0.0, abs=1e-6)
    assert scene.pivot[2] == scene.table.height + scene.tool.tip_radius


def test_the_tool_rests_stably(scene: Scene) -> None:
    """Its weight acts between the tip and the farthest point it lies on, along its axis."""
    turn = scene.rest_rotation.as_matrix()
    points, radii = scene.tool.support_points()
    levers = (points - scene.tool.pivot_in_tool) @ turn.T
    lies_on = levers[:, 2] - radii + scene.tool.tip_radius < 1e-6
    back = -turn[:, 0] * [1.0, 1.0, 0.0]
    back /= np.linalg.norm(back)
    weight = float((scene.rest_position - scene.pivot) @ back)
    assert 0.0 < weight < (levers[lies_on] @ back).max()


def test_rest_keeps_yaw_and_roll_of_the_file(scene: Scene) -> None:
    yaw, pitch, roll = scene.rest_rotation.as_euler("ZYX", degrees=True)
    assert yaw == pytest.approx(scene.config.rest.yaw_deg, abs=1e-9)
    assert roll == pytest.approx(scene.config.rest.roll_deg, abs=1e-9)
    assert pitch == pytest.approx(np.degrees(scene.rest_pitch), abs=1e-9)
    assert scene.rest_orientation[3] >= 0.0


def test_centre_of_mass_keeps_its_distance_to_the_pivot(scene: Scene) -> None:
    turns = attitude(0.3, 0.5, -0.2)
    for position in (scene.rest_position, scene.centre_of_mass(turns)):
        lever = np.linalg.norm(position - scene.pivot)
        assert lever == pytest.approx(np.linalg.norm(scene.tool.pivot_in_tool))
    two = type(turns).concatenate([scene.rest_rotation, turns])
    np.testing.assert_allclose(
        scene.centre_of_mass(two), [scene.rest_position, scene.centre_of_mass(turns)]
    )


def test_a_lift_raises_the_handle_by_its_pitch(scene: Scene) -> None:
    phase = scene.gaits["default"][0]
    assert isinstance(phase, LiftPhase)
    end = scene.lift_rotation(phase.to)
    out = end.as_matrix()[:, 0]
    assert np.degrees(np.arcsin(-out[2])) == pytest.approx(phase.to.pitch_deg)
    assert scene.centre_of_mass(end)[2] > scene.rest_position[2]
    assert scene.height(end) > scene.clearance
    same = scene.lift_rotation(LiftTarget(pitch_deg=float(np.degrees(scene.rest_pitch))))
    assert (same.inv() * scene.rest_rotation).magnitude() < 1e-12


def test_first_two_contacts_face_each_other_across_the_handle(scene: Scene) -> None:
    if scene.yaml.startswith("# Found by"):
        pytest.skip("the search may choose contacts that do not face each other")
    phase = scene.gaits["default"][0]
    assert isinstance(phase, LiftPhase)
    first, second = (scene.contacts[name] for name in phase.contacts)
    np.testing.assert_allclose(first.normal, -second.normal, rtol=0, atol=1e-12)
    # They look straight at each other, but for how far apart the file puts them along the handle.
    between = second.point - first.point
    beside = between - (between @ first.normal) * first.normal
    given = [scene.config.contacts[name].along_m for name in phase.contacts]
    apart = (given[1] - given[0]) * scene.tool.handle.axis
    np.testing.assert_allclose(beside, apart, rtol=0, atol=1e-12)
    # Friction alone lets them squeeze the handle: the line between them is in both cones.
    usable = 1.0 - scene.allocation.friction_reserve
    for contact in (first, second):
        across = abs(between @ contact.normal)
        assert np.linalg.norm(beside) < usable * contact.friction * across
    # Held behind the centre of mass, so that the tip still presses on the table.
    assert first.point[0] < 0.0


def test_contacts_carry_the_files_numbers(scene: Scene) -> None:
    for name, contact in scene.contacts.items():
        given = scene.config.contacts[name]
        assert (contact.name, contact.finger) == (name, given.finger)
        assert contact.friction == given.friction
        bounds = (contact.normal_min, contact.normal_max)
        assert bounds == (given.normal_force_N.min, given.normal_force_N.max)
        assert np.linalg.norm(contact.normal) == pytest.approx(1.0)


def test_arrays_are_read_only(scene: Scene) -> None:
    contact = next(iter(scene.contacts.values()))
    for array in (scene.pivot, scene.gravity, scene.rest_orientation, contact.point):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_an_exported_scene_is_the_same_scene(scene: Scene, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(export_scene(scene.name), encoding="utf-8")
    again = load_scene(path)
    assert again.yaml == scene.yaml == export_scene(scene.name)
    assert again.config == scene.config
    np.testing.assert_array_equal(again.rest_orientation, scene.rest_orientation)
    assert parse_scene(again.yaml).config == scene.config


def test_a_scene_may_bring_its_own_tool(tmp_path: Path) -> None:
    text = (urdf_root() / "wrench" / "wrench.urdf").read_text()
    (tmp_path / "tools").mkdir()
    (tmp_path / "tools" / "mine.urdf").write_text(text.replace('"wrench"', '"mine"'))
    path = tmp_path / "mine.yaml"
    path.write_text(export_scene("wrench").replace("urdf: wrench", "urdf: tools/mine.urdf"))
    scene = load_scene(str(path))
    assert scene.tool.name == "mine"
    assert scene.tool.urdf_path == (tmp_path / "tools" / "mine.urdf").resolve()


def schema_keys(schema: dict[str, object], name: str) -> set[str]:
    definitions = schema["$defs"]
    assert isinstance(definitions, dict)
    return set(definitions[name]["properties"])


def check_against(schema: dict[str, object], node: object, data: object) -> None:
    """The part of JSON Schema that scenes use: references, keys, types and limits."""
    assert isinstance(node, dict)
    if "$ref" in node:
        definitions = schema["$defs"]
        assert isinstance(definitions, dict)
        return check_against(schema, definitions[node["$ref"].split("/")[-1]], data)
    if "anyOf" in node:  # an optional part
        (part,) = (each for each in node["anyOf"] if each != {"type": "null"})
        return None if data is None else check_against(schema, part, data)
    if "discriminator" in node:
        assert isinstance(data, dict)
        reference = node["discriminator"]["mapping"][data["kind"]]
        return check_against(schema, {"$ref": reference}, data)
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int}
    if node.get("type") == "number":
        assert isinstance(data, int | float)
        assert data > node.get("exclusiveMinimum", -np.inf)
        assert data >= node.get("minimum", -np.inf)
        assert data <= node.get("maximum", np.inf)
    elif "type" in node:
        assert isinstance(data, kinds[node["type"]])
    if "const" in node or "enum" in node:
        assert data in node.get("enum", [node.get("const")])
    if isinstance(data, dict):
        assert set(node.get("required", ())) <= set(data)
        known = node.get("properties", {})
        if node.get("additionalProperties") is False:
            assert set(data) <= set(known)
        for key, value in data.items():
            patterns = list(node.get("patternProperties", {}).values())
            free = patterns[0] if patterns else node.get("additionalProperties")
            check_against(schema, known.get(key, free), value)
    if isinstance(data, list):
        places = node.get("prefixItems")
        for index, value in enumerate(data):
            check_against(schema, places[index] if places else node["items"], value)
    return None


def test_the_schema_describes_the_built_in_scenes(scene: Scene) -> None:
    schema = scene_schema()
    json.dumps(schema)
    data = scene.config.model_dump(mode="json", by_alias=True)
    check_against(schema, schema, data)
    with pytest.raises(AssertionError):
        check_against(schema, schema, {**data, "colour": "red"})
    data["table"]["friction"] = -1
    with pytest.raises(AssertionError):
        check_against(schema, schema, data)


def test_every_number_with_a_unit_says_so() -> None:
    # A length, angle, force or time carries its unit in the key or in the table of exceptions.
    plain = {
        "friction",
        "friction_reserve",
        "min",
        "max",
        "steps",
        "reorientation",
        "acceleration",
        "alignment",
    }
    units = ("_m", "_deg", "_s", "_N", "_m_s2", "_N_s", "_share")

    def walk(model: type[BaseModel]) -> None:
        for name, field in model.model_fields.items():
            if field.annotation in (float, int):
                assert name in plain or name.endswith(units), name

    from pivotgait.models import scene_config

    for entry in vars(scene_config).values():
        if isinstance(entry, type) and issubclass(entry, BaseModel):
            walk(entry)
    assert SceneConfig.model_config["extra"] == "forbid"
