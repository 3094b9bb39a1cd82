"""Scene text to plain data: YAML read safely, with limits."""

from __future__ import annotations

from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    MappingEndEvent,
    MappingStartEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from pivotgait.exceptions import SceneError

MAX_BYTES = 200_000
MAX_DEPTH = 12
MAX_ALIASES = 16  # nested aliases can grow a small text without bound


def read_yaml(
    text: str, *, where: str, example: str = "pivotgait scenes --export knife"
) -> dict[str, Any]:
    """The mapping a YAML 1.2 text holds.

    Args:
        text: the whole document.
        where: name of the document in messages.
        example: command that shows one to start from.

    Raises:
        SceneError: for text that is too large, empty, not YAML, nested too deep, uses many
            aliases, gives a key twice, or holds no mapping.
    """
    size = len(text.encode(errors="replace"))
    if size > MAX_BYTES:
        what = f"has {size} bytes, the limit is {MAX_BYTES}"
        raise SceneError(what, where=where, mend="a few kilobytes are enough")
    if not text.strip():
        mend = f"start from `{example}`"
        raise SceneError("is empty", where=where, mend=mend)
    try:
        _check_events(text, where)
        data = YAML(typ="safe", pure=True).load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark
        at = f"{where}: line {mark.line + 1}" if mark is not None else where
        problem = str(error.problem or error.context).split("\n")[0]
        raise SceneError(problem, where=at, mend="correct the YAML there") from error
    except (YAMLError, ValueError, RecursionError) as error:
        problem = str(error).split("\n")[0]
        raise SceneError(f"is not YAML: {problem}", where=where, mend="correct it") from error
    if not isinstance(data, dict):
        mend = f"start from `{example}`"
        raise SceneError(f"holds a {type(data).__name__}, not a mapping", where=where, mend=mend)
    return data


def _check_events(text: str, where: str) -> None:
    depth = aliases = 0
    for event in YAML(typ="safe", pure=True).parse(text):
        if isinstance(event, MappingStartEvent | SequenceStartEvent):
            depth += 1
        elif isinstance(event, MappingEndEvent | SequenceEndEvent):
            depth -= 1
        elif isinstance(event, AliasEvent):
            aliases += 1
        if depth > MAX_DEPTH or aliases > MAX_ALIASES:
            raise SceneError(
                f"is nested deeper than {MAX_DEPTH} or uses more than {MAX_ALIASES} aliases",
                where=where,
                mend="write the values out",
            )
