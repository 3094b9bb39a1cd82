"""The tool as it really is in a trial: heavier, wider, and not quite where it is thought to be."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import Scene, Shape, Tool, attitude, load_tool, rest_pitch
from pivotgait.models.robot_parts import write
from pivotgait.models.urdf.nodes import Node, read_nodes
from pivotgait.plans import GaitPlan
from pivotgait.validation.perturbation import Perturbation

_NUMBERS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass(frozen=True, eq=False)
class RealTool(FrozenArrays):
    """A tool and where it lies before anything touches it.

    Attributes:
        tool: with its true mass and shapes.
        position: (3,) of the centre of mass, world [m].
        rotation: (3, 3) world <- tool.
    """

    tool: Tool
    position: Array
    rotation: Array


def real_tool(plan: GaitPlan, scene: Scene, perturbation: Perturbation) -> RealTool:
    """The tool of a trial, lying on the table.

    Args:
        plan: for whose first tool pose the planner takes it.
        scene: of the plan, for the names of the handle's shapes.
        perturbation: mass, width and offset; where the tool lies elsewhere is the plan's.

    Raises:
        SceneError: if the changed tool cannot lie on its tip.
    """
    tool = _changed(scene, perturbation)
    rest = scene.config.rest
    planned = plan.phases[0].tool
    pitch = rest_pitch(tool, np.radians(rest.roll_deg), where="changed tool")
    yaw, roll = np.radians([rest.yaw_deg, rest.roll_deg])
    turn = Rotation.from_rotvec([0.0, 0.0, perturbation.offset[2]])
    rotation = (turn * attitude(yaw, pitch, roll)).as_matrix()
    position = planned.position[0] + [*perturbation.offset[:2], 0.0]
    # The tip stands on the table whatever the rest of the tool has become.
    pivot_height = plan.table_height + tool.tip_radius
    position[2] = pivot_height - (rotation @ tool.pivot_in_tool)[2]
    return RealTool(tool, position, rotation)


def _changed(scene: Scene, perturbation: Perturbation) -> Tool:
    config = scene.config.tool
    root = read_nodes(scene.tool.urdf, where="tool")
    for link in root.all("link"):
        # Visuals may name files that are not beside the changed text.
        link.children = [child for child in link.children if child.tag != "visual"]
    if perturbation.mass_scale != 1.0:
        _scale_mass(root, perturbation.mass_scale)
    if perturbation.handle_growth != 0.0:
        _grow(root, scene.tool, perturbation.handle_growth)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tool.urdf"
        path.write_text(write(root), encoding="utf-8")
        return load_tool(
            path,
            tip=config.tip,
            handle=config.handle.shapes,
            origin=np.array(config.handle.origin_m),
            axis=np.array(config.handle.axis),
            zero=np.array(config.handle.zero),
        )


def _scale_mass(root: Node, scale: float) -> None:
    for link in root.all("link"):
        for inertial in link.all("inertial"):
            for mass in inertial.all("mass"):
                _scale(mass, ("value",), scale)
            for inertia in inertial.all("inertia"):
                _scale(inertia, _NUMBERS, scale)


def _scale(node: Node, names: tuple[str, ...], scale: float) -> None:
    for name in names:
        node.attributes[name] = repr(scale * float(node.attributes.get(name, "0")))


def _grow(root: Node, tool: Tool, growth: float) -> None:
    """Move the handle's surface out by half of ``growth`` [m], all around its axis."""
    for shape, node in _handle_nodes(root, tool):
        if shape.kind == "box":
            along = int(np.argmax(np.abs(shape.rotation.T @ tool.handle.axis)))
            sizes = [s + growth * (k != along) for k, s in enumerate(shape.size)]
            node.attributes["size"] = " ".join(repr(float(size)) for size in sizes)
        else:
            node.attributes["radius"] = repr(shape.size[0] + 0.5 * growth)


def _handle_nodes(root: Node, tool: Tool) -> Iterator[tuple[Shape, Node]]:
    """Each shape of the handle and the element that states its size."""
    handle = {shape.name for shape in tool.handle.shapes}
    collisions = [each for link in root.all("link") for each in link.all("collision")]
    for shape, collision in zip(tool.shapes, collisions, strict=True):
        if shape.name in handle:
            yield from ((shape, geometry.children[0]) for geometry in collision.all("geometry"))
