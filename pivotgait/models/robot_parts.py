"""A checked URDF reduced to what a plan carries: links, joints and primitives, no files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.sax.saxutils import quoteattr

import pinocchio as pin

from pivotgait.frozen import Array
from pivotgait.models.enclosing import enclosing_primitive
from pivotgait.models.shape import Shape
from pivotgait.models.urdf import UrdfSummary
from pivotgait.models.urdf.nodes import Node, read_nodes

_JOINT_PARTS = ("parent", "child", "origin", "axis", "limit", "dynamics")
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def reduced(summary: UrdfSummary, *, where: str) -> Node:
    """The ``<robot>`` of a checked URDF: every mesh enclosed by a primitive, visuals as collisions.

    Numbers of kept elements stay as written, so the dynamics are those of the file to the last
    digit. Transmissions, simulators' settings and materials are left out.

    Raises:
        UrdfError: for a mesh without readable vertices.
    """
    read = read_nodes(summary.text, where=where)
    robot = element("robot", name=summary.name, version="1.1")
    for link in read.all("link"):
        shapes = summary.links[link.attributes["name"]].collisions
        robot.children.append(_link(link, shapes, where))
    for joint in read.all("joint"):
        kept = [child for child in joint.children if child.tag in _JOINT_PARTS]
        names = {name: joint.attributes[name] for name in ("name", "type")}
        robot.children.append(element("joint", *kept, **names))
    return robot


def element(tag: str, *children: Node, **attributes: str) -> Node:
    """A new element."""
    return Node(tag, attributes, 0, list(children))


def origin(rotation: Array, translation: Array) -> Node:
    """The ``<origin>`` of a pose: (3, 3) and (3,) [m], parent <- child."""
    return element("origin", xyz=_numbers(translation), rpy=_numbers(pin.rpy.matrixToRpy(rotation)))


def massless() -> Node:
    """The ``<inertial>`` of a frame that weighs nothing; without one Bullet assumes 1 kg."""
    inertia = element("inertia", **dict.fromkeys(_INERTIA, "0"))
    return element("inertial", element("mass", value="0"), inertia)


def write(robot: Node) -> str:
    """XML text, one element per line."""
    return '<?xml version="1.0"?>\n' + "\n".join(_lines(robot, "")) + "\n"


def _lines(node: Node, indent: str) -> Iterator[str]:
    attributes = "".join(f" {name}={quoteattr(text)}" for name, text in node.attributes.items())
    if not node.children:
        yield f"{indent}<{node.tag}{attributes}/>"
        return
    yield f"{indent}<{node.tag}{attributes}>"
    for child in node.children:
        yield from _lines(child, indent + "  ")
    yield f"{indent}</{node.tag}>"


def _link(link: Node, shapes: Iterable[Shape], where: str) -> Node:
    kept = list(link.all("inertial"))
    for node, shape in zip(link.all("collision"), shapes, strict=True):
        parts = [child for child in node.children if child.tag in ("origin", "geometry")]
        if shape.kind == "mesh":
            at = f"{where}: link {link.attributes['name']!r}, collision {shape.name!r}"
            parts = _shape(enclosing_primitive(shape, where=at))
        kept.append(element("collision", *parts, name=shape.name))
        kept.append(element("visual", *parts))
    return element("link", *kept, name=link.attributes["name"])


def _shape(shape: Shape) -> list[Node]:
    if shape.kind == "box":
        solid = element("box", size=_numbers(shape.size))
    else:
        names = ("radius", "length")[: len(shape.size)]
        sizes = dict(zip(names, map(repr, shape.size), strict=True))
        solid = element(shape.kind, **sizes)
    return [origin(shape.rotation, shape.translation), element("geometry", solid)]


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)  # + 0.0 unsigns a zero
