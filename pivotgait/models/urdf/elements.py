"""URDF elements read and checked one by one: origin, inertial, geometry, link, joint."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import cast

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.models.shape import Shape, ShapeKind
from pivotgait.models.urdf.meshes import resolve_mesh
from pivotgait.models.urdf.nodes import Node
from pivotgait.models.urdf.numbers import attribute, fail, label, number, positive, vector
from pivotgait.models.urdf.record import JointKind, UrdfInertial, UrdfJoint, UrdfLink

_ZERO = (0.0, 0.0, 0.0)
_JOINT_PARTS = ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic")
_ROUNDING = 1e-3  # printed inertias are rounded; a flat plate sits exactly on the triangle's limit
_SIZES = {"sphere": ("radius",), "capsule": ("radius", "length"), "cylinder": ("radius", "length")}


def only(node: Node, tag: str, at: str) -> Node | None:
    """The single child called ``tag``, or None; two of them are an error."""
    found = list(node.all(tag))
    if len(found) > 1:
        fail(found[1], at, f"has {len(found)} <{tag}> elements", "keep one")
    return found[0] if found else None


def required(node: Node, tag: str, at: str) -> Node:
    """The single child called ``tag``."""
    found = only(node, tag, at)
    if found is None:
        fail(node, at, f"has no <{tag}>", f"add a <{tag}> element")
    return found


def refuse_misspelt(node: Node, known: Sequence[str], at: str) -> None:
    """Refuse children that look like a known element: parsers would skip them silently."""
    for child in node.children:
        if child.tag in known:
            continue
        if child.tag.startswith("xacro:"):
            fail(child, at, f"holds <{child.tag}>", "expand the file with xacro first")
        near = get_close_matches(child.tag, known, n=1, cutoff=0.8)
        if near:
            fail(child, at, f"unknown element <{child.tag}>", f"did you mean <{near[0]}>?")


def read_origin(node: Node, at: str) -> tuple[Array, Array]:
    """Rotation (3, 3) and translation (3,) [m] of the ``<origin>`` child; identity if absent."""
    origin = only(node, "origin", at)
    if origin is None:
        return np.eye(3), np.zeros(3)
    rpy = vector(origin, "rpy", at, _ZERO)
    return Rotation.from_euler("xyz", rpy).as_matrix(), vector(origin, "xyz", at, _ZERO)


def read_inertial(node: Node, at: str) -> UrdfInertial | None:
    """Mass properties; refuses what no rigid body can have.

    None for mass and inertia of exactly zero: the usual way to write a frame that weighs nothing.
    """
    at = f"{at}, inertial"
    weight, element = required(node, "mass", at), required(node, "inertia", at)
    mass = number(weight, "value", f"{at}, mass")
    xx, yy, zz = (number(element, name, at) for name in ("ixx", "iyy", "izz"))
    # Without these three Pinocchio would drop the whole inertial.
    xy, xz, yz = (number(element, name, at) for name in ("ixy", "ixz", "iyz"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    rotation, centre = read_origin(node, at)
    if mass == 0.0 and not inertia.any():
        return None
    if not mass > 0.0:
        what = f"value must be greater than 0, got {mass:g}"
        fail(weight, f"{at}, mass", what, "give a positive number")
    low, middle, high = np.linalg.eigvalsh(inertia)
    moments = f"principal moments {low:.4g}, {middle:.4g}, {high:.4g} kg m^2"
    if not low > 0.0:
        fail(element, at, f"inertia is not positive definite: {moments}", "all must exceed 0")
    if low + middle < high * (1.0 - _ROUNDING):
        mend = "the two smaller ones must add up to at least the largest"
        fail(element, at, f"inertia breaks the triangle inequality: {moments}", mend)
    return UrdfInertial(mass, centre, rotation @ inertia @ rotation.T)


def read_shape(node: Node, name: str, roots: Sequence[Path], at: str) -> Shape:
    """The shape of a ``<collision>`` or ``<visual>`` element, in the link frame."""
    geometry = required(node, "geometry", at)
    if len(geometry.children) != 1:
        mend = "one of box, sphere, capsule, cylinder, mesh"
        fail(geometry, at, f"<geometry> holds {len(geometry.children)} elements, needs 1", mend)
    element = geometry.children[0]
    mesh = None
    size: tuple[float, ...]
    if element.tag == "box":
        size = _sides(element, at)
    elif element.tag in _SIZES:
        size = tuple(positive(element, entry, at) for entry in _SIZES[element.tag])
    elif element.tag == "mesh":
        size = _scale(element, at)
        mesh = resolve_mesh(element, attribute(element, "filename", at), roots, at)
    else:
        mend = "use box, sphere, capsule, cylinder or mesh"
        fail(element, at, f"unknown geometry <{element.tag}>", mend)
    rotation, translation = read_origin(node, at)
    return Shape(name, cast(ShapeKind, element.tag), size, rotation, translation, mesh)


def _sides(node: Node, at: str) -> tuple[float, ...]:
    sides = vector(node, "size", at, None)
    if not np.all(sides > 0.0):
        what = f"size must be greater than 0, got {node.attributes['size']!r}"
        fail(node, at, what, "give three positive numbers")
    return tuple(sides.tolist())


def _scale(node: Node, at: str) -> tuple[float, ...]:
    scale = vector(node, "scale", at, (1.0, 1.0, 1.0))
    if not np.all(scale):  # a negative factor mirrors the mesh
        fail(node, at, "a scale factor is 0", "give three numbers other than 0")
    return tuple(scale.tolist())


def read_link(node: Node, roots: Sequence[Path], at: str) -> UrdfLink:
    """A link with its inertial, collision and visual elements."""
    name = label(node, "name", at)
    at = f"{at}: link {name!r}"
    refuse_misspelt(node, ("inertial", "collision", "visual"), at)
    inertial = only(node, "inertial", at)
    shapes: dict[str, tuple[Shape, ...]] = {}
    for tag in ("collision", "visual"):
        named = [
            (c.attributes.get("name") or f"{name}_{i}", c) for i, c in enumerate(node.all(tag))
        ]
        shapes[tag] = tuple(read_shape(c, n, roots, f"{at}, {tag} {n!r}") for n, c in named)
    return UrdfLink(
        name,
        None if inertial is None else read_inertial(inertial, at),
        shapes["collision"],
        shapes["visual"],
    )


def read_joint(node: Node, at: str) -> UrdfJoint:
    """A revolute, prismatic or fixed joint with its limits."""
    name = label(node, "name", at)
    at = f"{at}: joint {name!r}"
    kind = _joint_kind(node, at)
    parent, child = (label(required(node, tag, at), "link", at) for tag in ("parent", "child"))
    rotation, translation = read_origin(node, at)
    if kind == "fixed":
        return UrdfJoint(name, kind, parent, child, rotation, translation, np.array([1.0, 0, 0]))
    element = only(node, "axis", at)
    axis = np.array([1.0, 0.0, 0.0]) if element is None else vector(element, "xyz", at, None)
    if abs(np.linalg.norm(axis) - 1.0) > 1e-3:
        fail(element or node, at, f"axis {axis.tolist()} is not of unit length", "normalise it")
    limit = required(node, "limit", at)
    lower, upper = number(limit, "lower", at, 0.0), number(limit, "upper", at, 0.0)
    if not lower < upper:
        mend = "lower must be less than upper"
        fail(limit, at, f"limits are out of order: [{lower:g}, {upper:g}]", mend)
    effort, velocity = positive(limit, "effort", at), positive(limit, "velocity", at)
    axis = axis / np.linalg.norm(axis)
    return UrdfJoint(
        name, kind, parent, child, rotation, translation, axis, lower, upper, effort, velocity
    )


def _joint_kind(node: Node, at: str) -> JointKind:
    kind = attribute(node, "type", at)
    refuse_misspelt(node, _JOINT_PARTS, at)
    if kind == "continuous":
        # Pinocchio gives it two configuration entries, Bullet and MuJoCo one.
        mend = "make it revolute with limits such as -6.2832 and 6.2832"
        fail(node, at, "continuous joints are not supported", mend)
    if kind not in ("revolute", "prismatic", "fixed"):
        fail(node, at, f"unknown joint type {kind!r}", "use revolute, prismatic or fixed")
    mimic = only(node, "mimic", at)
    if mimic is not None:
        mend = "remove <mimic> and couple the joints in the controller"
        fail(mimic, at, "mimic joints are not supported: the engines disagree on them", mend)
    for child in node.children:
        _check_extras(child, at)
    return cast(JointKind, kind)


def _check_extras(node: Node, at: str) -> None:
    """Elements of a joint that carry no kinematics, but end the native parser when broken."""
    if node.tag == "dynamics":
        if not {"damping", "friction"} & set(node.attributes):
            fail(node, at, "<dynamics> has neither damping nor friction", "remove it")
        for name in ("damping", "friction"):
            if number(node, name, at, 0.0) < 0.0:
                fail(node, at, f"{name} must not be negative", "give 0 or more")
    elif node.tag == "safety_controller":
        number(node, "k_velocity", at)
        for name in ("soft_lower_limit", "soft_upper_limit", "k_position"):
            number(node, name, at, 0.0)
    elif node.tag == "calibration":
        for name in ("rising", "falling", "reference_position"):
            number(node, name, at, 0.0)
