"""Scene files that are not scenes, and the files they name."""

from pathlib import Path

import pytest

from pivotgait.exceptions import SceneError, UnknownNameError, UrdfError
from pivotgait.models import export_scene, load_scene, parse_scene

KNIFE = export_scene("knife")
BOMB = "a: &a [x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join(['*' + old] * 9)}]\n"
    for old, new in zip("abcde", "bcdef", strict=True)
)


@pytest.mark.parametrize(
    ("content", "fragment"),
    [
        (b"", "is empty - start from"),
        (b"\n \n", "is empty"),
        (b"# only a remark\n", "holds a NoneType, not a mapping"),
        (b"- 1\n- 2\n", "holds a list, not a mapping"),
        (b"knife", "holds a str, not a mapping"),
        (b"\xff\xfe", "is not UTF-8"),
        (b"a: \x00", "scene.yaml"),
        (b"{" * 50_000, "nested deeper"),
        (b"a: " + b"[" * 50_000, "nested deeper"),
        (BOMB.encode(), "more than 16 aliases"),
        (b"#" * 200_001, "the limit is 200000"),
        (b"? [a, b]\n: 1\n", "scene.yaml"),
        (b"<<: 1\n", "scene.yaml"),
        (b"1: 2\n", "unknown key '1'"),
        (b'name: "\\ud800"\n', "scene.yaml"),
    ],
)
def test_bad_files(content: bytes, fragment: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert fragment in str(caught.value)
    assert str(caught.value).startswith("scene.yaml")


def test_what_is_no_scene(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'knife'"):
        load_scene("knive")
    with pytest.raises(UnknownNameError, match="known: knife, "):
        export_scene("fork")
    for path in (tmp_path, tmp_path / "none.yaml", tmp_path / ("n" * 400), "none.yaml"):
        with pytest.raises(SceneError, match="is not a file"):
            load_scene(path)


def test_a_broken_urdf_beside_the_scene_is_named(tmp_path: Path) -> None:
    (tmp_path / "t.urdf").write_text('<robot name="t">\n<link name="a">\n</robot>')
    text = KNIFE.replace("urdf: chef_knife", "urdf: t.urdf")
    with pytest.raises(UrdfError, match=r"t\.urdf: line 3: is not well-formed"):
        parse_scene(text, folder=tmp_path)


def test_a_urdf_behind_a_link_out_of_the_folder(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    (tmp_path / "t.urdf").write_text("<robot/>")
    (home / "t.urdf").symlink_to(tmp_path / "t.urdf")
    with pytest.raises(SceneError, match="outside the scene's folder"):
        parse_scene(KNIFE.replace("urdf: chef_knife", "urdf: t.urdf"), folder=home)
