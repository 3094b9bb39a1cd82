"""Mesh files of a URDF: found only inside the allowed folders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from pivotgait.models.paths import is_file
from pivotgait.models.urdf.nodes import Node
from pivotgait.models.urdf.numbers import fail

MAX_MESH_BYTES = 64_000_000


def resolve_mesh(node: Node, filename: str, roots: Sequence[Path], at: str) -> Path:
    """The file a ``<mesh>`` names, with symbolic links resolved.

    ``package://name/path`` is looked up as ``name/path`` in each root, or as ``path`` in a root
    called ``name``; relative paths in each root.

    Raises:
        UrdfError: if it leaves every root, does not exist, or is too large.
    """
    allowed = [root.resolve() for root in roots]
    candidates = list(_candidates(filename, allowed))
    candidates = [path for path in candidates if is_file(path)] or candidates
    inside = [
        path
        for candidate in candidates
        if any((path := candidate.resolve()).is_relative_to(root) for root in allowed)
    ]
    if not inside:
        listed = ", ".join(root.name for root in allowed) or "none"
        mend = f"keep meshes inside the allowed folders ({listed})"
        fail(node, at, f"mesh {filename!r} lies outside the allowed folders", mend)
    found = inside[0]
    if not is_file(found):
        fail(node, at, f"mesh {filename!r} does not exist", "correct its path or add the file")
    if found.stat().st_size > MAX_MESH_BYTES:
        fail(node, at, f"mesh {filename!r} is larger than {MAX_MESH_BYTES} bytes", "simplify it")
    return found


def _candidates(filename: str, roots: Sequence[Path]) -> Iterator[Path]:
    if "\0" in filename:
        return
    if filename.startswith("package://"):
        package, _, rest = filename.removeprefix("package://").partition("/")
        for root in roots:
            yield root / package / rest
            if root.name == package:
                yield root / rest
        return
    path = Path(filename.removeprefix("file://"))
    yield from ([path] if path.is_absolute() else [root / path for root in roots])
