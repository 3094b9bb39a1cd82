"""The check of a whole URDF, before Pinocchio, Coal or Bullet see it.

The native parsers drop shapes, turn unreadable numbers into zeros or end the process; here the
same faults become one line that says what, where and how to mend.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from pivotgait.exceptions import UrdfError
from pivotgait.models.paths import is_file
from pivotgait.models.urdf.elements import read_joint, read_link, refuse_misspelt
from pivotgait.models.urdf.materials import check_materials
from pivotgait.models.urdf.nodes import MAX_BYTES, Node, read_nodes
from pivotgait.models.urdf.numbers import fail, label
from pivotgait.models.urdf.record import UrdfJoint, UrdfLink, UrdfSummary

MAX_LINKS = 200
VERSIONS = ("1.0", "1.1", "1.2")
"""What the URDF parser behind Pinocchio reads."""


def read_urdf(path: Path | str, roots: Sequence[Path] = ()) -> UrdfSummary:
    """Read and check a URDF file.

    Args:
        path: of the file.
        roots: folders in which its meshes may lie, besides the file's own.

    Raises:
        UrdfError: if the file cannot be read or must not reach the native parsers.
    """
    path = Path(path)
    where = path.name
    try:
        if not is_file(path):
            raise UrdfError("is not a file", where=where, mend="give the path of a URDF file")
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
        text = raw.decode("utf-8-sig")
    except OSError as error:
        mend = "check its path and permissions"
        raise UrdfError(f"cannot be read: {error.strerror}", where=where, mend=mend) from error
    except UnicodeDecodeError as error:
        if len(raw) <= MAX_BYTES:
            raise UrdfError("is not UTF-8 text", where=where, mend="save it as UTF-8") from error
        text = raw.decode("utf-8", errors="replace")  # cut in a character; the size is the fault
    return check_urdf(text, where=where, roots=(path.parent, *roots))


def check_urdf(text: str, *, where: str, roots: Sequence[Path] = ()) -> UrdfSummary:
    """Check URDF text and return what it says.

    Args:
        text: the whole document.
        where: name of the document in messages.
        roots: folders in which its meshes may lie.

    Raises:
        UrdfError: naming the element, its line and the way to mend it.
    """
    robot = read_nodes(text, where=where)
    if robot.tag != "robot":
        fail(robot, where, f"the root element is <{robot.tag}>", "it must be <robot>")
    refuse_misspelt(robot, ("link", "joint", "material", "transmission", "gazebo"), where)
    name, version = label(robot, "name", where), _version(robot, where)
    nodes = list(robot.all("link"))
    if not 1 <= len(nodes) <= MAX_LINKS:
        fail(robot, where, f"has {len(nodes)} links", f"1 to {MAX_LINKS} are allowed")
    check_materials(robot, where)
    links = [read_link(node, roots, where) for node in nodes]
    joints = [read_joint(node, where) for node in robot.all("joint")]
    _check_unique("link", [link.name for link in links], where)
    _check_unique("joint", [joint.name for joint in joints], where)
    shapes = [shape for link in links for shape in link.collisions]
    _check_unique("collision", [shape.name for shape in shapes], where)
    root = _check_tree({link.name: link for link in links}, joints, where)
    return UrdfSummary(
        name,
        version,
        text,
        root,
        MappingProxyType({link.name: link for link in links}),
        MappingProxyType({joint.name: joint for joint in joints}),
    )


def _version(robot: Node, where: str) -> str:
    version = robot.attributes.get("version", "1.0")
    if version not in VERSIONS:
        mend = f"use one of {', '.join(VERSIONS)}"
        fail(robot, where, f"unknown URDF version {version!r}", mend)
    capsule = next(_find(robot, "capsule"), None)
    if capsule is not None and version == "1.0":
        # Pinocchio would keep the model and drop every collision shape of the link.
        fail(capsule, where, f"<capsule> needs version 1.1, got {version}", 'write version="1.1"')
    return version


def _find(node: Node, tag: str) -> Iterator[Node]:
    for child in node.children:
        if child.tag == tag:
            yield child
        yield from _find(child, tag)


def _check_unique(kind: str, names: Sequence[str], where: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise UrdfError(f"two {kind}s are called {name!r}", where=where, mend="rename one")
        seen.add(name)


def _check_tree(links: Mapping[str, UrdfLink], joints: Sequence[UrdfJoint], where: str) -> str:
    """Name of the root link of the one tree that the joints must form."""
    parent_of: dict[str, str] = {}
    for joint in joints:
        at = f"{where}: joint {joint.name!r}"
        for role, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                listed = ", ".join(list(links)[:8])
                raise UrdfError(f"unknown {role} link {link!r}", where=at, mend=f"known: {listed}")
        if joint.child in parent_of:
            raise UrdfError(
                f"link {joint.child!r} has two parents", where=at, mend="a URDF is a tree"
            )
        parent_of[joint.child] = joint.parent
        if joint.kind != "fixed" and links[joint.child].inertial is None:
            mend = "add <inertial>; Pinocchio would assume 0 kg and Bullet 1 kg"
            raise UrdfError(f"moves link {joint.child!r} without mass", where=at, mend=mend)
    roots = [name for name in links if name not in parent_of]
    if not roots:
        raise UrdfError("the joints form a loop", where=where, mend="a URDF is a tree")
    if len(roots) > 1:
        listed = ", ".join(repr(name) for name in roots[:4])
        raise UrdfError(f"has {len(roots)} root links: {listed}", where=where, mend="join them")
    reached = {roots[0]}
    for _ in links:
        reached |= {child for child, parent in parent_of.items() if parent in reached}
    if len(reached) != len(links):
        stray = next(name for name in links if name not in reached)
        raise UrdfError(f"link {stray!r} is in a loop", where=where, mend="a URDF is a tree")
    return roots[0]
