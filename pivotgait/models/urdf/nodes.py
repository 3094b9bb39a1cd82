"""Well-formed XML without DTD or entities, as a small tree that knows its line numbers.

Expat from the standard library is the parser; it fetches nothing and its handlers refuse a
document type declaration before any entity could be expanded.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from pivotgait.exceptions import UrdfError

MAX_BYTES = 2_000_000
MAX_LINE = 1000
MAX_DEPTH = 32
MAX_ELEMENTS = 20_000
_CONTROL_IN_VALUE = re.compile(r"""=\s*("[^"<]*[\t\r\n][^"<]*"|'[^'<]*[\t\r\n][^'<]*')""")


@dataclass(eq=False)
class Node:
    """One XML element.

    Attributes:
        tag: its name, prefix included.
        attributes: name -> text as written.
        line: where it starts, from 1.
        children: in document order.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Node] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[Node]:
        """The direct children called ``tag``."""
        return (child for child in self.children if child.tag == tag)


def read_nodes(text: str, *, where: str) -> Node:
    """Parse XML text into its root :class:`Node`.

    Args:
        text: the whole document.
        where: name of the document in messages.

    Raises:
        UrdfError: for text that is too large, has lines Bullet would cut, is not well formed,
            or holds a document type declaration.
    """
    try:
        raw = text.encode()
    except UnicodeEncodeError as error:
        raise UrdfError("is not valid Unicode", where=where, mend="save it as UTF-8") from error
    _check_size(text, raw, where)
    control = _CONTROL_IN_VALUE.search(text)
    if control is not None:
        # XML reads these as blanks, Pinocchio's parser does not and drops the element.
        line = text.count("\n", 0, control.start()) + 1
        raise UrdfError(
            "an attribute holds a tab or a line break",
            where=f"{where}: line {line}",
            mend="separate values by blanks",
        )
    return _Builder(where).build(raw)


def _check_size(text: str, raw: bytes, where: str) -> None:
    if not text.strip():
        raise UrdfError("is empty", where=where, mend="it must hold a <robot> element")
    if len(raw) > MAX_BYTES:
        raise UrdfError(
            f"has {len(raw)} bytes, the limit is {MAX_BYTES}",
            where=where,
            mend="put the geometry into mesh files",
        )
    for number, line in enumerate(raw.splitlines(), start=1):
        if len(line) >= MAX_LINE:
            # Bullet reads URDF text in chunks of about 1 kB and breaks lines there.
            raise UrdfError(
                f"has {len(line)} characters, the limit is {MAX_LINE - 1}",
                where=f"{where}: line {number}",
                mend="write one element per line",
            )


class _Builder:
    """Collects expat's events into nodes."""

    def __init__(self, where: str) -> None:
        self.where, self.count = where, 0
        self.open: list[Node] = []
        self.root: Node | None = None
        self.parser = expat.ParserCreate("utf-8")
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._refuse_doctype

    def build(self, raw: bytes) -> Node:
        try:
            self.parser.Parse(raw, True)
        except expat.ExpatError as error:
            raise UrdfError(
                f"is not well-formed XML: {expat.ErrorString(error.code)}",
                where=f"{self.where}: line {error.lineno}",
                mend="close every element and quote every attribute",
            ) from error
        assert self.root is not None  # expat reports a document without elements
        return self.root

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        self.count += 1
        if len(self.open) >= MAX_DEPTH or self.count > MAX_ELEMENTS:
            raise UrdfError(
                f"has more than {MAX_DEPTH} levels or {MAX_ELEMENTS} elements",
                where=f"{self.where}: line {line}",
                mend="a URDF needs a handful of levels",
            )
        node = Node(tag, attributes, line)
        if self.open:
            self.open[-1].children.append(node)
        else:
            self.root = node
        self.open.append(node)

    def _end(self, _tag: str) -> None:
        self.open.pop()

    def _refuse_doctype(self, *_declaration: object) -> None:
        raise UrdfError(
            "has a <!DOCTYPE> declaration, which could define entities",
            where=f"{self.where}: line {self.parser.CurrentLineNumber}",
            mend="remove it; URDF needs none",
        )
