"""Pydantic's findings as one line: file, field, what is wrong, how to mend it."""

from __future__ import annotations

import types
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pivotgait.exceptions import SceneError

_LIMITS = {"greater_than": "gt", "greater_than_equal": "ge", "less_than": "lt"}
_LIMITS["less_than_equal"] = "le"
_WORDS = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}
_NOUNS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "bool_type": "true or false",
    "tuple_type": "a list like [0, 1]",
    "dict_type": "a mapping with keys",
    "model_type": "a mapping with keys",
    "model_attributes_type": "a mapping with keys",
}


def as_scene_error(error: ValidationError, model: type[BaseModel], where: str) -> SceneError:
    """The first finding of ``error`` as a :class:`SceneError`; counts the others."""
    found = error.errors(include_url=False)
    # A misspelt key explains the key that is missing, so it is told first.
    first = next((entry for entry in found if entry["type"] == "extra_forbidden"), found[0])
    what, mend = _explain(first, model)
    if len(found) > 1:
        mend += f" (and {len(found) - 1} more)"
    field = _dotted(first["loc"], model)
    return SceneError(what, where=f"{where}: {field}" if field else where, mend=mend)


def _explain(finding: ErrorDetails, model: type[BaseModel]) -> tuple[str, str]:
    kind, context = finding["type"], finding.get("ctx", {})
    given = _short(finding["input"])
    if kind in _LIMITS:
        limit = f"{_WORDS[_LIMITS[kind]]} {context[_LIMITS[kind]]:g}"
        return f"must be {limit}, got {given}", f"give a value {limit}"
    if kind == "extra_forbidden":
        key = str(finding["loc"][-1])
        known = _keys(_model_at(finding["loc"][:-1], model))
        near = get_close_matches(key, known, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        return f"unknown key {key!r}", f"{hint}known: {', '.join(known)}"
    if kind == "too_short":
        least, most = context["min_length"], context["actual_length"]
        return f"has {most} entries, needs at least {least}", "add some"
    if kind == "missing":
        return "is missing", "add it"
    if kind == "finite_number":
        return f"must be finite, got {given}", "give a finite number"
    if kind == "float_type" and isinstance(finding["input"], str) and "," in given:
        point = finding["input"].replace(",", ".")
        return f"must be a number, got {given}", f"write a decimal point: {_short(point)[1:-1]}"
    if kind == "literal_error":
        return f"unknown value {given}", f"use {context['expected']}"
    if kind == "union_tag_invalid":
        return f"unknown kind {context['tag']!r}", f"use {context['expected_tags']}"
    if kind == "union_tag_not_found":
        return "has no 'kind'", "add kind: lift, relocation, addition or removal"
    if kind == "string_pattern_mismatch":
        return f"{given} is not a name", "use letters, digits, _ and -, a letter first"
    if kind in _NOUNS:
        return f"must be {_NOUNS[kind]}, got {given}", f"give {_NOUNS[kind]}"
    message = finding["msg"].removeprefix("Input should ")
    return f"should {message[:1].lower()}{message[1:]}, got {given}", "correct it"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _dotted(location: Sequence[int | str], model: type[BaseModel]) -> str:
    """``contacts.thumb.friction`` or ``gaits.default[0].steps``, without pydantic's union tags."""
    text, here = "", _Place(model)
    for part in location:
        here = here.enter(part)
        if part == "[key]" or here.is_tag:
            continue
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def _keys(annotation: Any) -> list[str]:
    if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
        return []
    return [field.alias or name for name, field in annotation.model_fields.items()]


def _model_at(location: Sequence[int | str], model: type[BaseModel]) -> Any:
    here = _Place(model)
    for part in location:
        here = here.enter(part)
    return here.annotation


class _Place:
    """A place in the tree of models, followed along a pydantic location."""

    def __init__(self, annotation: Any, *, is_tag: bool = False) -> None:
        self.annotation, self.is_tag = _bare(annotation), is_tag

    def enter(self, part: int | str) -> _Place:
        origin, arguments = get_origin(self.annotation), get_args(self.annotation)
        if origin in (Union, types.UnionType):
            chosen = next((m for m in arguments if part in _tags(m)), None)
            return _Place(chosen, is_tag=True)
        if origin is dict:
            return _Place(arguments[1])
        if origin is tuple:
            return _Place(arguments[0])
        if isinstance(self.annotation, type) and issubclass(self.annotation, BaseModel):
            for name, field in self.annotation.model_fields.items():
                if part in (name, field.alias):
                    return _Place(field.annotation)
        return _Place(None)


def _bare(annotation: Any) -> Any:
    """Without ``Annotated`` and without the ``None`` of an optional part."""
    while True:
        arguments = get_args(annotation)
        if get_origin(annotation) in (Union, types.UnionType):
            arguments = tuple(each for each in arguments if each is not types.NoneType)
            if len(arguments) > 1:
                return annotation
        elif get_origin(annotation) is not Annotated:
            return annotation
        annotation = arguments[0]


def _tags(model: type[BaseModel]) -> Iterator[Any]:
    yield from get_args(model.model_fields["kind"].annotation)
