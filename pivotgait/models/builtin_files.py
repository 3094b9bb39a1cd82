"""YAML files that come with the package, found by name."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable

from pivotgait.exceptions import UnknownNameError


@dataclass(frozen=True)
class BuiltinFiles:
    """The YAML files of one kind.

    Attributes:
        kind: of thing that a file describes, as messages call it.
        package: that holds the folder.
        folder: of the files.
    """

    kind: str
    package: str
    folder: str

    def names(self) -> tuple[str, ...]:
        """Of the files, without their ending, sorted."""
        found = [each.name for each in self._folder.iterdir()]
        return tuple(sorted(n.removesuffix(".yaml") for n in found if n.endswith(".yaml")))

    def text(self, name: str) -> str:
        """Of one file.

        Raises:
            UnknownNameError: listing those there are.
        """
        if name not in self.names():
            raise UnknownNameError(self.kind, name, self.names())
        return (self._folder / f"{name}.yaml").read_text(encoding="utf-8")

    @property
    def _folder(self) -> Traversable:
        return files(self.package) / self.folder
