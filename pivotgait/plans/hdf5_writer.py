"""A plan as the bytes of an HDF5 file: the same plan always gives the same bytes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array
from pivotgait.plans.layout import JOINT_MOTION, MOTION, SCHEMA
from pivotgait.plans.plan import ContactTrack, GaitPlan, Phase, PlannedRobot

# One fixed format version: the same bytes from every HDF5 release, checksummed metadata (damage
# is found instead of followed), and attributes above 64 kB, which a URDF may need.
LIBVER = ("v110", "v110")


def plan_to_bytes(plan: GaitPlan) -> bytes:
    """Image of the plan file.

    Args:
        plan: a plan that passes :func:`pivotgait.plans.check.check_plan`.

    Raises:
        PlanFileError: if the certificate or the versions are not plain JSON data, or a text is
            not Unicode.
    """
    # Built in memory: nothing half-made can be left on disk.
    with h5py.File("plan", "w", driver="core", backing_store=False, libver=LIBVER) as file:
        _text(file, "schema", SCHEMA)
        _text(file, "scene", plan.scene)
        file.attrs["seed"] = np.int64(plan.seed)
        _text(file, "versions", _json(plan.versions, "versions"))
        _text(file, "certificate", _json(plan.certificate, "certificate"))
        file.attrs["gravity"] = plan.gravity
        tool = file.create_group("tool")
        _text(tool, "name", plan.tool.name)
        _text(tool, "urdf", plan.tool.urdf)
        tool.attrs["mass"] = float(plan.tool.mass)
        for name in ("inertia", "pivot_in_tool", "centre_of_mass_in_root"):
            _array(tool, name, getattr(plan.tool, name))
        file.create_group("table").attrs["height"] = float(plan.table_height)
        if plan.robot is not None:
            _robot(file.create_group("robot"), plan.robot)
        phases = file.create_group("phases")
        for phase in plan.phases:
            _phase(phases.create_group(phase.name), phase)
        file.flush()
        return bytes(file.id.get_file_image())


def _phase(group: Any, phase: Phase) -> None:
    _text(group, "kind", phase.kind)
    _text(group, "finger", phase.finger)
    _array(group, "time", phase.time)
    tool = group.create_group("tool")
    for name in MOTION:
        _array(tool, name, getattr(phase.tool, name))
    # A reader gets the contacts in the order of the plan, not of the alphabet.
    contacts = group.create_group("contacts", track_order=True)
    for name, contact in phase.contacts.items():
        _contact(contacts.create_group(name), contact)
    if phase.robot is not None:
        robot = group.create_group("robot")
        for name in JOINT_MOTION:
            _array(robot, name, getattr(phase.robot, name))


def _robot(group: Any, robot: PlannedRobot) -> None:
    _text(group, "urdf", robot.urdf)
    _texts(group, "joint_names", robot.joint_names)
    _text(group, "couplings", _json(robot.couplings, "couplings"))
    _text(group, "never_touch", _json(robot.never_touch, "never_touch"))
    fingers = group.create_group("fingers", track_order=True)
    for name, finger in robot.fingers.items():
        each = fingers.create_group(name)
        _text(each, "tip_frame", finger.tip_frame)
        each.attrs["tip_radius"] = float(finger.tip_radius)


def _contact(group: Any, contact: ContactTrack) -> None:
    for name in ("point", "normal", "force"):
        _array(group, name, getattr(contact, name))
    for name in ("friction", "normal_min", "normal_max"):
        group.attrs[name] = float(getattr(contact, name))
    if contact.torsion > 0.0:
        group.attrs["torsion"] = float(contact.torsion)
    if contact.moment is not None:
        _array(group, "moment", contact.moment)


def _array(group: Any, name: str, array: Array) -> None:
    group.create_dataset(name, data=np.ascontiguousarray(array, dtype="<f8"), track_times=False)


def _text(group: Any, name: str, text: str) -> None:
    _strings(group, name, _encoded(text, name))


def _texts(group: Any, name: str, texts: tuple[str, ...]) -> None:
    _strings(group, name, [_encoded(text, name) for text in texts])


def _strings(group: Any, name: str, data: bytes | list[bytes]) -> None:
    # Fixed length: bytes stand in the attribute itself, covered by its checksum. HDF5 knows no
    # string of length 0; one padding NUL stands for it.
    longest = len(data) if isinstance(data, bytes) else max(map(len, data), default=0)
    dtype = h5py.string_dtype("utf-8", max(longest, 1))
    group.attrs.create(name, np.array(data, dtype=dtype))


def _encoded(text: str, name: str) -> bytes:
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError as error:
        raise PlanFileError(
            f"{name} is not Unicode text", where="plan", mend="correct it"
        ) from error
    if b"\0" in data:
        raise PlanFileError(f"{name} holds a NUL character", where="plan", mend="remove it")
    return data


def _json(value: Mapping[str, Any] | tuple[Any, ...] | None, name: str) -> str:
    plain = dict(value) if isinstance(value, Mapping) else value
    try:
        return json.dumps(plain, allow_nan=False, sort_keys=True, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise PlanFileError(
            f"{name} is not plain JSON data: {error}", where="plan", mend="use finite numbers, text"
        ) from error
