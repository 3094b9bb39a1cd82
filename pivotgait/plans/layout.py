"""Names and sizes of the plan file's contents: the schema ``pivotgait-plan/1`` as data."""

from __future__ import annotations

import re

from pivotgait.exceptions import PlanFileError

SCHEMA = "pivotgait-plan/1"
MOTION = (
    "position",
    "orientation",
    "linear_velocity",
    "angular_velocity",
    "linear_acceleration",
    "angular_acceleration",
)
"""Datasets of ``/phases/NN_kind/tool``; each also names a field of ``ToolMotion``."""
JOINT_MOTION = ("q", "v", "a", "tau")
"""Datasets of ``/phases/NN_kind/robot``; each also names a field of ``RobotMotion``."""

MAX_FILE_BYTES = 256 * 2**20
MAX_TEXT_BYTES = 8 * 2**20
MAX_SAMPLES = 100_001
MAX_PHASES = 1000
MAX_CONTACTS = 16
MAX_JOINTS = 200
MAX_FINGERS = MAX_CONTACTS - 1
MAX_PAIRS = 20_000
MAX_NAME_BYTES = 200

_PHASE_NAME = re.compile(r"(\d{2,4})_([a-z]+)", re.ASCII)
_CONTACT_NAME = re.compile(r"[^\W\d][\w-]{0,63}")


def phase_name(place: int, kind: str) -> str:
    """Name of the phase at ``place``: ``NN_kind``."""
    return f"{place:02d}_{kind}"


def place_of(name: str, where: str) -> int:
    """Place in the order that a phase's name tells.

    Raises:
        PlanFileError: if the name is not of the form ``NN_kind``.
    """
    match = _PHASE_NAME.fullmatch(name)
    if match is None:
        raise PlanFileError(
            f"phase group {name!r} is not named NN_kind", where=where, mend="e.g. 00_lift"
        )
    return int(match[1])


def is_contact_name(name: str) -> bool:
    """Whether ``name`` may name a contact and hence an HDF5 group."""
    return _CONTACT_NAME.fullmatch(name) is not None
