"""From the bytes of an HDF5 file to a plan, trusting none of them."""

from __future__ import annotations

import json
from typing import Any, cast

import h5py

from pivotgait.exceptions import PlanFileError
from pivotgait.plans.hdf5_nodes import Node
from pivotgait.plans.layout import (
    JOINT_MOTION,
    MAX_CONTACTS,
    MAX_FINGERS,
    MAX_JOINTS,
    MAX_PAIRS,
    MAX_PHASES,
    MAX_SAMPLES,
    MOTION,
    SCHEMA,
    place_of,
)
from pivotgait.plans.plan import (
    ContactTrack,
    GaitPlan,
    Phase,
    PhaseKind,
    PlannedFinger,
    PlannedRobot,
    PlannedTool,
    RobotMotion,
    ToolMotion,
)

_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def plan_from_bytes(image: bytes, *, where: str) -> GaitPlan:
    """Plan held by the image of a plan file; its values are yet to be checked.

    Args:
        image: content of the file.
        where: name of the file in messages.

    Raises:
        PlanFileError: if it is not a plan file of this schema, or damaged.
    """
    if not image.startswith(_SIGNATURE):
        raise PlanFileError("is not an HDF5 file", where=where, mend="give a file that plan wrote")
    try:
        with h5py.File(h5py.h5f.open_file_image(image)) as file:
            return _plan(Node(file, where))
    except PlanFileError:
        raise
    except Exception as error:
        # h5py answers damage with whatever its C library or NumPy met first (OSError, RuntimeError,
        # KeyError, ValueError, MemoryError ...); for the reader all of them say the same.
        reason = str(error).split("\n")[0][:160]
        raise PlanFileError(
            f"is damaged: {reason}", where=where, mend="copy the file again or plan again"
        ) from error


def _plan(root: Node) -> GaitPlan:
    schema = root.text("schema")
    if schema != SCHEMA:
        root.fail(f"has schema {schema[:60]!r}, not {SCHEMA!r}", "use the version that wrote it")
    tool, phases = root.child("tool"), root.child("phases")
    if len(phases.group) > MAX_PHASES:
        root.fail(f"has {len(phases.group)} phases, more than {MAX_PHASES}")
    robot = _robot(root.child("robot")) if "robot" in root.names else None
    joints = None if robot is None else len(robot.joint_names)
    ordered = sorted(phases.names, key=lambda name: place_of(name, phases.where))
    return GaitPlan(
        scene=root.text("scene"),
        seed=root.integer("seed"),
        versions=_json_object(root, "versions") or {},
        gravity=root.vector("gravity", (3,)),
        table_height=root.child("table").number("height"),
        tool=PlannedTool(
            name=tool.text("name"),
            mass=tool.number("mass"),
            inertia=tool.array("inertia", (3, 3)),
            pivot_in_tool=tool.array("pivot_in_tool", (3,)),
            urdf=tool.text("urdf"),
            centre_of_mass_in_root=tool.array("centre_of_mass_in_root", (3,)),
        ),
        phases=tuple(_phase(phases.child(name), name, joints) for name in ordered),
        robot=robot,
        certificate=_json_object(root, "certificate"),
    )


def _phase(node: Node, name: str, joints: int | None) -> Phase:
    time = node.array("time", (None,))
    count = len(time)
    if count > MAX_SAMPLES:
        node.fail(f"has {count} samples, more than {MAX_SAMPLES}")
    tool, contacts = node.child("tool"), node.child("contacts")
    if len(contacts.group) > MAX_CONTACTS:
        node.fail(f"has {len(contacts.group)} contacts, more than {MAX_CONTACTS}")
    widths = {field: 4 if field == "orientation" else 3 for field in MOTION}
    return Phase(
        name=name,
        kind=cast(PhaseKind, node.text("kind")),  # check_plan compares it with the known kinds
        finger=node.text("finger"),
        time=time,
        tool=ToolMotion(**{field: tool.array(field, (count, widths[field])) for field in MOTION}),
        contacts={each: _contact(contacts.child(each), each, count) for each in contacts.names},
        robot=_robot_motion(node, count, joints) if "robot" in node.names else None,
    )


def _robot_motion(node: Node, count: int, joints: int | None) -> RobotMotion:
    robot = node.child("robot")
    return RobotMotion(**{field: robot.array(field, (count, joints)) for field in JOINT_MOTION})


def _robot(node: Node) -> PlannedRobot:
    fingers = node.child("fingers")
    if len(fingers.group) > MAX_FINGERS:
        fingers.fail(f"has {len(fingers.group)} fingers, more than {MAX_FINGERS}")
    each = {name: fingers.child(name) for name in fingers.names}
    return PlannedRobot(
        urdf=node.text("urdf"),
        joint_names=node.texts("joint_names", MAX_JOINTS),
        fingers={
            name: PlannedFinger(finger.text("tip_frame"), finger.number("tip_radius"))
            for name, finger in each.items()
        },
        couplings=_pairs(node, "couplings"),
        never_touch=_pairs(node, "never_touch"),
    )


def _contact(node: Node, name: str, count: int) -> ContactTrack:
    return ContactTrack(
        name=name,
        point=node.array("point", (3,)),
        normal=node.array("normal", (3,)),
        force=node.array("force", (count, 3)),
        friction=node.number("friction"),
        normal_min=node.number("normal_min"),
        normal_max=node.number("normal_max"),
        torsion=node.number("torsion") if "torsion" in node.group.attrs else 0.0,
        moment=node.array("moment", (count,)) if "moment" in node.names else None,
    )


def _json_object(node: Node, name: str) -> dict[str, Any] | None:
    """JSON object of an attribute; None for ``null``."""
    value = _json(node, name)
    if value is not None and not isinstance(value, dict):
        node.fail(f"attribute {name!r} is not a JSON object")
    return value


def _pairs(node: Node, name: str) -> tuple[tuple[str, str], ...]:
    """Pairs of texts from a JSON list of lists."""
    value = _json(node, name)
    if not isinstance(value, list) or not all(_is_pair(each) for each in value):
        node.fail(f"attribute {name!r} is not a JSON list of pairs of texts")
    if len(value) > MAX_PAIRS:
        node.fail(f"attribute {name!r} holds {len(value)} pairs, more than {MAX_PAIRS}")
    return tuple((one, other) for one, other in value)


def _is_pair(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(isinstance(x, str) for x in value)


def _json(node: Node, name: str) -> Any:
    def refuse(constant: str) -> None:
        raise ValueError(f"holds {constant}")

    try:
        return json.loads(node.text(name), parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        node.fail(f"attribute {name!r} is not JSON: {error}")
