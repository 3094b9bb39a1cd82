"""Names of parameters, and the fields of a scene that each of them sets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pivotgait.exceptions import UnknownNameError
from pivotgait.sweeps.errors import StudyError

Value = float | str
Fields = dict[str, Any]
Place = tuple[str | int, ...]

MASS_SCALE = "tool.mass_scale"
"""The one parameter that is no field of the scene: factor of the tool's mass and inertia."""
_PHASES = ("lift", "addition", "removal", "relocation")
_LIFT_TARGET = {f"tool.{each}": f"lift.to.{each}" for each in ("pitch_deg", "roll_deg", "yaw_deg")}
_HIDDEN = ("schema", "name", "description", "gaits", "tool")
"""Fields of a scene that no parameter sets."""


def places_of(parameter: str, fields: Fields, *, where: str) -> tuple[Place, ...]:
    """Where in a scene's fields a parameter sets its value.

    A parameter is a dotted path such as ``table.friction``, ``contacts.thumb_spine.along_m`` or
    ``gravity_m_s2.2``; ``*`` stands for every key (``contacts.*.friction``). ``lift``,
    ``addition``, ``removal`` and ``relocation`` stand for all phases of that kind in the gait
    (``removal.duration_s``), and ``tool.pitch_deg``, ``tool.roll_deg`` and ``tool.yaw_deg`` for
    the lift's target.

    Args:
        parameter: the path.
        fields: of a scene with a single gait, ``default``.
        where: the study's field, in messages.

    Returns:
        Keys and indices from the root to each number or text; none for ``tool.mass_scale``.

    Raises:
        UnknownNameError: a key the scene does not have; lists those it has there.
        StudyError: a path that ends in no single value.
    """
    if parameter == MASS_SCALE:
        return ()
    keys = _LIFT_TARGET.get(parameter, parameter).split(".")
    starts: list[tuple[Place, Any]] = [((), _roots(fields))]
    if keys[0] in _PHASES:
        phases = enumerate(fields["gaits"]["default"])
        found = [(k, phase) for k, phase in phases if phase["kind"] == keys[0]]
        if not found:
            mend = "choose another gait or leave the axis out"
            raise StudyError(f"the gait has no {keys[0]}", where=where, mend=mend)
        starts = [(("gaits", "default", k), phase) for k, phase in found]
        keys = keys[1:]
    for depth, key in enumerate(keys):
        known: set[str] = set()
        starts = [step for start in starts for step in _enter(start, key, known)]
        if not starts:
            path = ".".join(keys[: depth + 1])
            more = _extra(depth)
            raise UnknownNameError("parameter", path, [*sorted(known), *more], where=where)
    return tuple(place for place, value in starts if _is_leaf(value, parameter, where))


def set_values(fields: Fields, places: tuple[Place, ...], value: Value) -> None:
    """Set a value at places of a scene's fields; whole numbers where one was."""
    for place in places:
        node = fields
        for key in place[:-1]:
            node = node[key]  # type: ignore[index]
        counts = isinstance(node[place[-1]], int)  # type: ignore[index]
        whole = counts and isinstance(value, float) and value.is_integer()
        node[place[-1]] = int(value) if whole else value  # type: ignore[index]


def _extra(depth: int) -> tuple[str, ...]:
    if depth:
        return ()
    return (*_PHASES, *_LIFT_TARGET, MASS_SCALE)


def _roots(fields: Fields) -> Fields:
    return {key: value for key, value in fields.items() if key not in _HIDDEN}


def _enter(start: tuple[Place, Any], key: str, known: set[str]) -> list[tuple[Place, Any]]:
    """The values one key below a place; ``known`` gathers the keys there are."""
    place, node = start
    if isinstance(node, Mapping):
        children: dict[str | int, Any] = dict(node)
    elif isinstance(node, list):
        children = dict(enumerate(node))
    else:
        children = {}
    known.update(map(str, children))
    return [((*place, each), child) for each, child in children.items() if key in ("*", str(each))]


def _is_leaf(value: Any, parameter: str, where: str) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        what = f"{parameter!r} is not a single number or name"
        keys = ", ".join(map(str, value)) if isinstance(value, Mapping) else "its parts"
        raise StudyError(what, where=where, mend=f"go on to one of: {keys}")
    return True
