"""Every damaged, foreign or crafted file is answered by one PlanFileError."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from pivotgait.exceptions import PlanFileError
from pivotgait.plans import GaitPlan, check_plan, read_plan, write_plan
from pivotgait.plans.hdf5_reader import plan_from_bytes
from pivotgait.plans.hdf5_writer import plan_to_bytes

Edit = Callable[[h5py.File], object]
FORCE = "phases/01_removal/contacts/index/force"


@pytest.fixture
def path(robot_plan: GaitPlan, tmp_path: Path) -> Path:
    write_plan(robot_plan, tmp_path / "plan.h5")
    return tmp_path / "plan.h5"


def put(name: str, value: object, **options: object) -> Edit:
    def edit(file: h5py.File) -> None:
        if name in file:
            del file[name]
        file.create_dataset(name, data=value, **options)

    return edit


def put_attribute(group: str, name: str, value: object) -> Edit:
    return lambda file: file[group].attrs.__setitem__(name, value)


def drop(name: str) -> Edit:
    return lambda file: file.__delitem__(name)


def drop_attribute(group: str, name: str) -> Edit:
    return lambda file: file[group].attrs.__delitem__(name)


def relink(name: str, link: object) -> Edit:
    def edit(file: h5py.File) -> None:
        del file[name]
        file[name] = link

    return edit


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((4, 3), "f8")
    layout[:] = h5py.VirtualSource("/other.h5", "x", (4, 3))
    del file[FORCE]
    file.create_virtual_dataset(FORCE, layout)


def external(file: h5py.File) -> None:
    del file[FORCE]
    file.create_dataset(FORCE, (4, 3), "f8", external=[("/etc/hostname", 0, 96)])


def bomb(file: h5py.File) -> None:
    """A small file that would unpack into gigabytes."""
    del file["phases/01_removal/time"]
    file.create_dataset("phases/01_removal/time", (10**9,), "f8", chunks=(10**6,), fillvalue=1.0)


def unallocated(file: h5py.File) -> None:
    del file["phases/01_removal/time"]
    file.create_dataset("phases/01_removal/time", (10**9,), "f8")


def rename(old: str, new: str) -> Edit:
    return lambda file: file.move(old, new)


PHASE, INDEX = "phases/01_removal", "phases/01_removal/contacts/index"
EDITS: dict[str, tuple[Edit, str]] = {
    "schema": (put_attribute("/", "schema", "pivotgait-plan/2"), "schema"),
    "no schema": (drop_attribute("/", "schema"), "schema"),
    "no gravity": (drop_attribute("/", "gravity"), "gravity"),
    "gravity of two": (put_attribute("/", "gravity", [0.0, 1.0]), "gravity"),
    "gravity NaN": (put_attribute("/", "gravity", [0.0, 1.0, np.nan]), "gravity"),
    "gravity text": (put_attribute("/", "gravity", "down"), "gravity"),
    "seed fraction": (put_attribute("/", "seed", 1.5), "seed"),
    "seed negative": (put_attribute("/", "seed", -1), "seed"),
    "versions not JSON": (put_attribute("/", "versions", "{"), "versions"),
    "versions deep": (put_attribute("/", "versions", "[" * 100_000), "versions"),
    "versions list": (put_attribute("/", "versions", "[1]"), "versions"),
    "versions numbers": (put_attribute("/", "versions", '{"a": 1}'), "versions"),
    "certificate NaN": (put_attribute("/", "certificate", '{"a": NaN}'), "certificate"),
    "scene not UTF-8": (put_attribute("/", "scene", np.bytes_(b"\xff\xfe")), "UTF-8"),
    "scene number": (put_attribute("/", "scene", 3), "scene"),
    "no tool": (drop("tool"), "tool"),
    "tool a dataset": (put("tool", 1.0), "tool"),
    "no table": (drop("table"), "table"),
    "mass negative": (put_attribute("tool", "mass", -0.1), "mass"),
    "mass infinite": (put_attribute("tool", "mass", np.inf), "mass"),
    "inertia flat": (put("tool/inertia", np.zeros(9)), "inertia"),
    "inertia missing": (drop("tool/inertia"), "inertia"),
    "no phases": (lambda file: [file.__delitem__(f"phases/{n}") for n in file["phases"]], "phases"),
    "phase left out": (drop(PHASE), "01"),
    "phase name": (rename(PHASE, "phases/removal"), "NN_kind"),
    "phase place": (rename(PHASE, "phases/07_removal"), "place"),
    "phase kind": (put_attribute(PHASE, "kind", "juggling"), "juggling"),
    "kind against name": (put_attribute(PHASE, "kind", "addition"), "01_addition"),
    "finger unknown": (put_attribute(PHASE, "finger", "toe"), "toe"),
    "finger is pivot": (put_attribute(PHASE, "finger", "pivot"), "pivot"),
    "no pivot": (drop(f"{PHASE}/contacts/pivot"), "pivot"),
    "time backwards": (put(f"{PHASE}/time", np.array([0.0, 2.0, 1.0, 3.0])), "time"),
    "time starts late": (put(f"{PHASE}/time", np.array([1.0, 2.0, 3.0, 4.0])), "time"),
    "time of one": (put(f"{PHASE}/time", np.zeros(1)), "01_removal"),
    "time too short": (put(f"{PHASE}/time", np.arange(3.0)), "position"),
    "orientation not unit": (put(f"{PHASE}/tool/orientation", np.ones((4, 4))), "unit"),
    "orientation of three": (put(f"{PHASE}/tool/orientation", np.ones((4, 3))), "orientation"),
    "force NaN": (put(FORCE, np.full((4, 3), np.nan)), "index"),
    "force integers": (put(FORCE, np.zeros((4, 3), int)), "int64"),
    "force single": (put(FORCE, np.zeros((4, 3), "f4")), "float32"),
    "force complex": (put(FORCE, np.zeros((4, 3), complex)), "complex"),
    "force texts": (put(FORCE, np.full((4, 3), b"x", object), dtype=h5py.string_dtype()), "force"),
    "force references": (lambda f: put(FORCE, np.full((4, 3), f.ref, h5py.ref_dtype))(f), "force"),
    "force empty": (put(FORCE, h5py.Empty("f8")), "force"),
    "force compressed": (put(FORCE, np.zeros((4, 3)), compression="gzip"), "contiguous"),
    "force virtual": (virtual, "contiguous"),
    "force external": (external, "contiguous"),
    "force linked": (relink(FORCE, h5py.SoftLink(f"/{INDEX}/point")), "link"),
    "force in another file": (relink(FORCE, h5py.ExternalLink("/other.h5", "/x")), "link"),
    "group linked": (relink(INDEX, h5py.SoftLink(f"/{PHASE}/contacts/thumb")), "link"),
    "time bomb": (bomb, "contiguous"),
    "time unallocated": (unallocated, "wholly"),
    "friction zero": (put_attribute(INDEX, "friction", 0.0), "friction"),
    "friction NaN": (put_attribute(INDEX, "friction", np.nan), "friction"),
    "bounds crossed": (put_attribute(INDEX, "normal_min", 10.0), "bounds"),
    "bound negative": (put_attribute(INDEX, "normal_min", -1.0), "bounds"),
    "contact's name": (rename(INDEX, f"{PHASE}/contacts/a b"), "removal"),
    "too many contacts": (
        lambda file: [file.copy(INDEX, f"{PHASE}/contacts/f{n}") for n in range(20)],
        "contacts",
    ),
}  # fmt: skip
MOVES, FINGER = f"{PHASE}/robot", "robot/fingers/index"
FIXED = h5py.string_dtype("utf-8", 4)
EDITS |= {
    "no robot": (drop("robot"), "00_lift"),
    "robot a dataset": (put("robot", 1.0), "robot"),
    "one phase without motion": (drop(MOVES), "01_removal"),
    "no phase with motion": (
        lambda file: [file.__delitem__(f"phases/{name}/robot") for name in file["phases"]],
        "00_lift",
    ),
    "no q": (drop(f"{MOVES}/q"), "q"),
    "q of five": (put(f"{MOVES}/q", np.zeros((4, 5))), "q"),
    "q of one sample": (put(f"{MOVES}/q", np.zeros((1, 4))), "q"),
    "v NaN": (put(f"{MOVES}/v", np.full((4, 4), np.nan)), "robot/v"),
    "a infinite": (put(f"{MOVES}/a", np.full((4, 4), np.inf)), "robot/a"),
    "tau single": (put(f"{MOVES}/tau", np.zeros((4, 4), "f4")), "float32"),
    "tau linked": (relink(f"{MOVES}/tau", h5py.SoftLink(f"/{MOVES}/q")), "link"),
    "robot's urdf missing": (drop_attribute("robot", "urdf"), "urdf"),
    "robot's urdf a number": (put_attribute("robot", "urdf", 1.0), "urdf"),
    "no joint names": (drop_attribute("robot", "joint_names"), "joint_names"),
    "joint names one text": (put_attribute("robot", "joint_names", "J1"), "joint_names"),
    "joint names of variable length": (put_attribute("robot", "joint_names", ["a"]), "fixed"),
    "joint names numbers": (put_attribute("robot", "joint_names", [1.0, 2.0]), "joint_names"),
    "joint names in a table": (
        put_attribute("robot", "joint_names", np.full((2, 2), b"J1", FIXED)), "joint_names",
    ),
    "joint names not UTF-8": (
        put_attribute("robot", "joint_names", np.array([b"\xff"] * 4, FIXED)), "UTF-8",
    ),
    "joint names twice": (
        put_attribute("robot", "joint_names", np.array([b"J1"] * 4, FIXED)), "one name",
    ),
    "joint name empty": (
        put_attribute("robot", "joint_names", np.array([b"J1", b"", b"J2", b"J3"], FIXED)), "name",
    ),
    "too many joint names": (
        put_attribute("robot", "joint_names", np.full(1000, b"J1", FIXED)), "more than 200",
    ),
    "couplings not JSON": (put_attribute("robot", "couplings", "["), "couplings"),
    "couplings an object": (put_attribute("robot", "couplings", "{}"), "couplings"),
    "couplings null": (put_attribute("robot", "couplings", "null"), "couplings"),
    "couplings of three": (put_attribute("robot", "couplings", '[["a", "b", "c"]]'), "couplings"),
    "couplings of numbers": (put_attribute("robot", "couplings", "[[1, 2]]"), "couplings"),
    "coupling of a stranger": (put_attribute("robot", "couplings", '[["FFJ1", "X"]]'), "'X'"),
    "coupling with itself": (put_attribute("robot", "couplings", '[["J1", "J1"]]'), "different"),
    "never_touch missing": (drop_attribute("robot", "never_touch"), "never_touch"),
    "never_touch deep": (put_attribute("robot", "never_touch", "[" * 100_000), "never_touch"),
    "never_touch long": (
        put_attribute("robot", "never_touch", "[" + '["a","b"],' * 30_000 + '["a","b"]]'),
        "30001 pairs",
    ),
    "no fingers": (drop("robot/fingers"), "fingers"),
    "fingers empty": (lambda f: [f.__delitem__(f"robot/fingers/{n}") for n in ("thumb", "index")],
                      "fingers"),
    "finger left out": (drop(FINGER), "index"),
    "finger a dataset": (put(FINGER, 1.0), "index"),
    "finger called pivot": (rename(FINGER, "robot/fingers/pivot"), "pivot"),
    "finger's name": (rename(FINGER, "robot/fingers/a b"), "a b"),
    "too many fingers": (
        lambda file: [file.copy(FINGER, f"robot/fingers/f{n}") for n in range(20)], "fingers",
    ),
    "tip frame missing": (drop_attribute(FINGER, "tip_frame"), "tip_frame"),
    "tip frame empty": (put_attribute(FINGER, "tip_frame", ""), "tip_frame"),
    "tip frame long": (put_attribute(FINGER, "tip_frame", "x" * 1000), "tip_frame"),
    "tip frame of another finger": (put_attribute(FINGER, "tip_frame", "thtip"), "tip_frame"),
    "tip radius zero": (put_attribute(FINGER, "tip_radius", 0.0), "tip_radius"),
    "tip radius NaN": (put_attribute(FINGER, "tip_radius", np.nan), "tip_radius"),
    "relocation of nobody": (put_attribute("phases/02_relocation", "finger", ""), "moves"),
}  # fmt: skip


@pytest.mark.parametrize("name", EDITS)
def test_edited_file_is_refused_with_the_place(path: Path, name: str) -> None:
    edit, says = EDITS[name]
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        edit(file)
    with pytest.raises(PlanFileError, match=says) as caught:
        read_plan(path)
    text = str(caught.value)
    assert text.startswith("plan.h5")
    assert "\n" not in text
    assert caught.value.mend
    assert caught.value.exit_code == 2


def test_honest_edits_by_other_programs_are_read(path: Path) -> None:
    """Values changed in place, text of variable length, extra groups: still a plan."""
    with h5py.File(path, "r+") as file:
        file[FORCE][...] = 1.5
        file.attrs["scene"] = "tool: other\n"
        file.attrs["comment"] = "mine"
        file.create_group("notes/anything")
        file.create_group("robot/notes")
    plan = read_plan(path)
    assert np.all(plan.phases[1].contacts["index"].force == 1.5)
    assert plan.scene == "tool: other\n"


def test_one_block_linked_many_times_does_not_fill_the_memory(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        motion = file["phases/02_relocation/tool"]
        del file["phases"]
        count = 100_001
        block = file.create_dataset("block", data=np.ones((count, 3)))
        turn = file.create_dataset("turn", data=np.ones((count, 4)))
        time = file.create_dataset("time", data=np.arange(float(count)))
        for place in range(500):
            group = file.create_group(f"phases/{place:02d}_relocation")
            group.attrs["kind"], group.attrs["finger"] = "relocation", "index"
            group["time"] = time
            group.create_group("contacts")
            for name in motion:
                group[f"tool/{name}"] = turn if name == "orientation" else block
    with pytest.raises(PlanFileError, match="more than 256 MB"):
        read_plan(path)


@pytest.mark.parametrize(
    "content", [b"", b"\x89HDF\r\n\x1a\n", b"\x89HDF", b"PK\x03\x04", b"\0" * 999]
)
def test_foreign_bytes(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "plan.h5").write_bytes(content)
    with pytest.raises(PlanFileError):
        read_plan(tmp_path / "plan.h5")


def test_missing_file_and_folder(tmp_path: Path) -> None:
    for target in (tmp_path / "none.h5", tmp_path, Path("a\0b"), Path("x" * 5000)):
        with pytest.raises(PlanFileError):
            read_plan(target)


def test_too_large_file_is_not_parsed(tmp_path: Path) -> None:
    with (tmp_path / "plan.h5").open("wb") as file:
        file.write(b"\x89HDF\r\n\x1a\n")
        file.truncate(2**28 + 1)
    with pytest.raises(PlanFileError, match="larger than 256 MB"):
        read_plan(tmp_path / "plan.h5")


@pytest.fixture
def image(robot_plan: GaitPlan) -> bytes:
    """A small file with everything that a plan may have."""
    return plan_to_bytes(replace(robot_plan, phases=robot_plan.phases[:2]))


def survives(image: bytes) -> bool:
    """Whether the image is read as a plan; anything but PlanFileError escapes."""
    try:
        check_plan(plan_from_bytes(image, where="plan.h5"))
    except PlanFileError:
        return False
    return True


def test_truncated_at_any_length(image: bytes) -> None:
    lengths = np.unique(np.linspace(0, len(image) - 1, 300).astype(int))
    assert not any(survives(image[:length]) for length in lengths)
    assert survives(image)


def test_flipped_bits_anywhere(image: bytes) -> None:
    """Metadata is checksummed, so that a flip is found or lies in a number."""
    rng = np.random.default_rng(4)
    read = 0
    for _ in range(400):
        damaged = bytearray(image)
        for place in rng.integers(len(image), size=rng.integers(1, 4)):
            damaged[place] ^= 1 << int(rng.integers(8))
        read += survives(bytes(damaged))
    assert 0 < read < 400


def test_overwritten_stretches(image: bytes) -> None:
    rng = np.random.default_rng(5)
    for _ in range(150):
        start, length = int(rng.integers(len(image))), int(rng.integers(1, 512))
        noise = rng.bytes(min(length, len(image) - start))
        survives(image[:start] + noise + image[start + len(noise) :])
