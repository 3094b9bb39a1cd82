"""Colours of visuals: harmless, but a broken one makes the native parser drop shapes."""

from __future__ import annotations

from pivotgait.models.urdf.nodes import Node
from pivotgait.models.urdf.numbers import fail, numbers


def check_materials(robot: Node, where: str) -> None:
    """Check the robot's named materials and every use of one in a visual.

    Raises:
        UrdfError: for a material without name, defined twice, or with a colour out of range.
    """
    defined: set[str] = set()
    for node in robot.all("material"):
        name = _check(node, where)
        if name in defined:
            fail(node, where, f"two materials are called {name!r}", "rename one")
        defined.add(name)
    for link in robot.all("link"):
        for visual in link.all("visual"):
            for node in visual.all("material"):
                _check(node, where)


def _check(node: Node, where: str) -> str:
    name = node.attributes.get("name")
    if name is None:
        # Pinocchio would drop every shape of the link, collision shapes included.
        fail(node, where, "<material> has no 'name'", 'write name="..."')
    at = f"{where}: material {name!r}"
    for colour in node.all("color"):
        rgba = numbers(colour, "rgba", 4, at)
        if rgba.min() < 0.0 or rgba.max() > 1.0:
            fail(colour, at, f"rgba {rgba.tolist()} leaves 0 to 1", "give four numbers in 0 to 1")
    return name
