"""Strict numbers: what the native parsers would read silently as something else is refused."""

from __future__ import annotations

import math
import re
from typing import NoReturn

import numpy as np

from pivotgait.exceptions import UrdfError
from pivotgait.frozen import Array
from pivotgait.models.urdf.nodes import Node

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?", re.ASCII)


def fail(node: Node, at: str, what: str, mend: str) -> NoReturn:
    """Raise a :class:`UrdfError` about ``node``, found at ``at``."""
    raise UrdfError(what, where=f"{at} (line {node.line})", mend=mend)


def attribute(node: Node, name: str, at: str) -> str:
    """Text of a required attribute, not blank."""
    text = node.attributes.get(name, "")
    if not text.strip():
        fail(node, at, f"<{node.tag}> has no {name!r}", f'write {name}="..."')
    return text


def label(node: Node, name: str, at: str) -> str:
    """A required attribute that names something; blanks around it would be part of the name."""
    text = attribute(node, name, at)
    if text != text.strip():
        fail(node, at, f"{name} {text!r} has blanks around it", f'write {name}="{text.strip()}"')
    return text


def number(node: Node, name: str, at: str, default: float | None = None) -> float:
    """A finite number from attribute ``name``; ``default`` (if any) where it is absent."""
    if default is not None and name not in node.attributes:
        return default
    return _parse(node, name, attribute(node, name, at), at)


def positive(node: Node, name: str, at: str) -> float:
    """A required finite number above zero."""
    value = number(node, name, at)
    if not value > 0.0:
        fail(node, at, f"{name} must be greater than 0, got {value:g}", "give a positive number")
    return value


def numbers(node: Node, name: str, count: int, at: str) -> Array:
    """``count`` finite numbers (count,) separated by blanks."""
    text = attribute(node, name, at)
    values = [_parse(node, name, word, at) for word in text.split()]
    if len(values) != count:
        mend = "separate them by blanks"
        fail(node, at, f"{name} needs {count} numbers, got {text[:80]!r}", mend)
    return np.array(values)


def vector(node: Node, name: str, at: str, default: tuple[float, float, float] | None) -> Array:
    """Three finite numbers (3,) separated by blanks; ``default`` (if any) where absent."""
    if default is not None and name not in node.attributes:
        return np.array(default)
    return numbers(node, name, 3, at)


def _parse(node: Node, name: str, text: str, at: str) -> float:
    if _NOT_FINITE.fullmatch(text):
        fail(node, at, f"{name} is not finite: {text!r}", "give a finite number")
    if _COMMA.fullmatch(text):
        mend = f"write a decimal point: {text.replace(',', '.')}"
        fail(node, at, f"{name} is not a number: {text!r}", mend)
    if not _NUMBER.fullmatch(text):
        fail(node, at, f"{name} is not a number: {text[:40]!r}", "write it like 0.25 or 1e-3")
    value = float(text)
    if not math.isfinite(value):
        fail(node, at, f"{name} is not finite: {text[:40]!r} overflows", "give a finite number")
    return value
