"""Studies: what is refused, and how it is told."""

from __future__ import annotations

from pathlib import Path

import pytest

from pivotgait.exceptions import InputError
from pivotgait.models import export_scene
from pivotgait.sweeps import Study, builtin_studies, load_study, parse_study
from pivotgait.sweeps.scene_family import SceneFamily
from tests.sweeps.cases import DRAWN, GRID

BAD: dict[str, tuple[str, list[str]]] = {
    "empty": ("", ["is empty", "sweep --export"]),
    "list": ("- knife\n", ["not a mapping"]),
    "unknown key": (GRID + "colour: red\n", ["unknown key 'colour'"]),
    "schema": (GRID.replace("study/1", "study/9"), ["schema", "pivotgait-study/1"]),
    "scene": (GRID.replace("scene: knife", "scene: knif"), ["scene", "did you mean 'knife'"]),
    "scene file": (GRID.replace("scene: knife", "scene: a.yaml"), ["scene", "a.yaml"]),
    "compute": (GRID.replace("static", "guess"), ["compute", "'static'"]),
    "gait": (GRID + "gait: slow\n", ["gait", "'slow'", "known: default"]),
    "no axes": (GRID[: GRID.index("axes:")] + "axes: {}\n", ["axes", "at least 1"]),
    "unknown parameter": (
        GRID.replace("table.friction", "table.fricton"),
        ["axes.table.fricton", "did you mean 'friction'"],
    ),
    "unknown root": (GRID.replace("table.friction", "tabel.friction"), ["did you mean 'table'"]),
    "unknown contact": (
        GRID.replace("contacts.*.friction", "contacts.thumb.friction"),
        ["axes.contacts.thumb.friction", "thumb_spine"],
    ),
    "no single value": (GRID.replace("table.friction", "table"), ["'table'", "friction"]),
    "beyond a value": (GRID.replace("table.friction", "table.friction.x"), ["friction.x"]),
    "no such phase": (
        GRID.replace("tool.pitch_deg", "transfer.steps"),
        ["axes.transfer.steps", "removal"],
    ),
    "NaN": (GRID.replace("[20, 40]", "[20, .nan]"), ["axes.tool.pitch_deg.values[1]", "finite"]),
    "infinite": (GRID.replace("to: 0.9", "to: .inf"), ["linspace.to", "finite"]),
    "text": (GRID.replace("[20, 40]", "[20, steep]"), ["values[1]", "a number", "'steep'"]),
    "no values": (GRID.replace("[20, 40]", "[]"), ["axes.tool.pitch_deg.values", "at least 1"]),
    "no kind": (GRID.replace("{values: [20, 40]}", "{}"), ["gives no values", "linspace"]),
    "two kinds": (
        GRID.replace("{values: [20, 40]}", "{values: [20], uniform: {from: 1, to: 2}}"),
        ["axes.tool.pitch_deg", "values and uniform"],
    ),
    "twice": (GRID + "  tool.pitch_deg: {values: [1]}\n", ["duplicate key"]),
    "overlap": (
        GRID + "  contacts.thumb_spine.friction: {values: [1]}\n",
        ["axes.contacts.thumb_spine.friction", "axes.contacts.*.friction"],
    ),
    "set and swept": (GRID + "set: {table.friction: 0.4}\n", ["set.table.friction", "too"]),
    "a value twice": (GRID.replace("[20, 40]", "[20, 20]"), ["20.0 twice"]),
    "one point": (GRID.replace("from: 0.1, to: 0.9", "from: 1, to: 1"), ["starts where it ends"]),
    "empty range": (GRID.replace("from: 0.2, to: 1.0", "from: 1, to: 0"), ["is empty", "swap"]),
    "no step": (GRID.replace("step: 0.2", "step: 0"), ["range.step", "greater than 0"]),
    "fine step": (GRID.replace("step: 0.2", "step: 1.0e-9"), ["longer step"]),
    "names for numbers": (GRID.replace("values: [20, 40]", "names: [a]"), ["use values"]),
    "numbers for names": (
        GRID.replace("tool.pitch_deg", "allocation.objective"),
        ["allocation.objective", "use names"],
    ),
    "no draws": (DRAWN.replace("draws: 10\n", ""), ["draws", "is a distribution"]),
    "draws of nothing": (GRID + "draws: 4\n", ["draws", "leave it out"]),
    "no interval": (DRAWN.replace("from: 0.8, to: 1.2", "from: 2, to: 1"), ["lower bound"]),
    "no logarithm": (DRAWN.replace("from: 0.03", "from: -0.03"), ["positive"]),
    "no spread": (DRAWN.replace("sd: 0.1", "sd: 0"), ["normal.sd", "greater than 0"]),
    "negative seed": (DRAWN.replace("seed: 4", "seed: -4"), ["seed", "at least 0"]),
    "foreign options": (GRID + "trials: {count: 3}\n", ["trials", "computes static"]),
    "static contact": (
        GRID + "static: {contacts: [thumb_spine, index]}\n",
        ["static.contacts", "'index'"],
    ),
    "a finger twice": (
        GRID + "static: {contacts: [index_edge, index_edge_near]}\n",
        ["static.contacts", "'index'", "twice"],
    ),
    "unknown simulator": (
        GRID.replace("static", "trials") + "trials: {simulator: chalk}\n",
        ["simulator", "chalk", "pybullet"],
    ),
    "mass in trials": (
        GRID.replace("static", "trials") + "  tool.mass_scale: {values: [1, 2]}\n",
        ["tool.mass_scale", "validation.mass_share"],
    ),
    "no time": (GRID + "time_limit_s: 0\n", ["time_limit_s", "greater than 0"]),
    "too many": (
        GRID.replace("count: 3", "count: 1000000").replace("step: 0.2", "step: 1.0e-6")
        + "  lift.duration_s: {range: {from: 1, to: 2, step: 1.0e-5}}\n",
        ["cells", "stay below"],
    ),
}
"""Name -> text and what the one line about it says."""


@pytest.mark.parametrize(("text", "words"), BAD.values(), ids=BAD.keys())
def test_bad_studies_are_told(text: str, words: list[str]) -> None:
    assert text not in (GRID, DRAWN)
    with pytest.raises(InputError) as caught:
        parse_study(text, where="bad.yaml")
    line = str(caught.value)
    assert [word for word in words if word not in line] == []
    assert "\n" not in line
    assert caught.value.mend


@pytest.mark.parametrize("name", builtin_studies())
def test_builtin_studies_load(name: str) -> None:
    study = load_study(name)
    assert study.config.name == name
    assert study.config.description


def test_scene_beside_the_study(tmp_path: Path) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "mine.yaml").write_text(export_scene("wrench"), encoding="utf-8")
    text = GRID.replace("scene: knife", "scene: scenes/mine.yaml")
    (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
    study = load_study(tmp_path / "study.yaml")
    assert study.folder == folder
    assert study.scene.name == "wrench"


def test_a_study_survives_the_way_to_a_worker(grid: Study) -> None:
    there = Study.from_json(grid.to_json())
    there.check_digest()
    assert there.to_json() == grid.to_json()
    assert there.cells == grid.cells


def test_a_worker_notices_another_scene(grid: Study) -> None:
    other = grid.to_json().replace("friction: 0.4", "friction: 0.5")
    with pytest.raises(InputError, match="another one for the worker"):
        Study.from_json(other).check_digest()


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("name: small", "name: other", True),
        ("[20, 40]", "[20, 30]", True),  # the axes name the cells, not the digest
        ("compute: static", "compute: removal", False),
        ("scene: knife", "scene: wrench", False),
        ("compute: static", "compute: static\nseed: 1", False),
        ("compute: static", "compute: static\ntime_limit_s: 1", False),
        ("compute: static", "compute: static\nset: {clearance_m: 0.002}", False),
    ],
)
def test_digest_is_of_what_results_depend_on(old: str, new: str, same: bool) -> None:
    assert (parse_study(GRID.replace(old, new)).digest == parse_study(GRID).digest) is same


def test_only_what_varies_differs_in_a_cells_scene() -> None:
    text = """\
schema: pivotgait-study/1
name: all
scene: knife
compute: plan
set: {clearance_m: 0.002}
axes:
  removal.steps: {linspace: {from: 16, to: 32, count: 2}}
  contacts.*.friction: {values: [0.6]}
  gravity_m_s2.2: {values: [-1.62]}
  tool.mass_scale: {values: [2]}
  tool.pitch_deg: {values: [30]}
  allocation.objective: {names: [margin]}
  contacts.index_edge.along_m: {values: [0.04]}
"""
    study = parse_study(text)
    scene, base = (
        SceneFamily(study.config, study.scene, None).scene(study.cells.cell(1).values),
        study.scene,
    )
    (removal,) = [p for p in scene.gaits["default"] if p.kind == "removal"]
    assert (removal.steps, type(removal.steps)) == (32, int)
    assert {c.friction for c in scene.contacts.values()} == {0.6}
    assert scene.gravity[2] == -1.62
    assert scene.robot is not None
    assert scene.robot.model.gravity.linear[2] == -1.62
    assert scene.tool.mass == 2 * base.tool.mass
    assert (scene.tool.inertia == 2 * base.tool.inertia).all()
    assert scene.gaits["default"][0].to.pitch_deg == 30.0
    assert scene.allocation.objective == "margin"
    place = base.tool.place(0.04, 3.141592653589793)
    assert scene.contacts["index_edge"].point == pytest.approx(place.point, abs=1e-12)
    assert (scene.contacts["thumb_spine"].point == base.contacts["thumb_spine"].point).all()
    assert scene.clearance == 0.002
    assert (scene.pivot == base.pivot).all()
