"""URDF and mesh files: where they may lie and what they may hold."""

from pathlib import Path

import pytest

from pivotgait.exceptions import UrdfError
from pivotgait.models.urdf import check_urdf, read_urdf

ROBOT = """<robot name="r">
  <link name="a">
    <collision>
      <geometry>
        <mesh filename="{}" scale="1 -1 1"/>
      </geometry>
    </collision>
  </link>
</robot>
"""


@pytest.mark.parametrize(
    "filename", ["a.stl", "package://model/a.stl", "{}/a.stl", "file://{}/a.stl"]
)
def test_mesh_inside_a_root(filename: str, tmp_path: Path) -> None:
    folder = tmp_path / "model"
    folder.mkdir()
    (folder / "a.stl").write_text("solid a\nendsolid a\n")
    text = ROBOT.format(filename.format(folder))
    summary = check_urdf(text, where="r.urdf", roots=[folder])
    assert summary.collisions[0].mesh == (folder / "a.stl").resolve()
    assert summary.collisions[0].size == (1.0, -1.0, 1.0)


def test_mesh_behind_a_link_out_of_the_root(tmp_path: Path) -> None:
    inside, outside = tmp_path / "in", tmp_path / "out"
    inside.mkdir()
    outside.mkdir()
    (outside / "a.stl").write_text("solid a\n")
    (inside / "a.stl").symlink_to(outside / "a.stl")
    with pytest.raises(UrdfError, match="outside the allowed folders"):
        check_urdf(ROBOT.format("a.stl"), where="r.urdf", roots=[inside])


@pytest.mark.parametrize(
    ("content", "fragment"),
    [
        (None, "is not a file"),
        (b"", "is empty"),
        (b"  \n", "is empty"),
        (b"\xff\xfe\x00", "is not UTF-8"),
        (b"<robot name='r'>\x00</robot>", "not well-formed"),
        (ROBOT.encode("utf-16"), "is not UTF-8"),
    ],
)
def test_bad_files(content: bytes | None, fragment: str, tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UrdfError, match=fragment) as caught:
        read_urdf(path)
    assert str(caught.value).startswith("r.urdf: ")


def test_a_folder_or_an_endless_name_is_no_urdf(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / ("n" * 400)):
        with pytest.raises(UrdfError, match="is not a file"):
            read_urdf(path)
