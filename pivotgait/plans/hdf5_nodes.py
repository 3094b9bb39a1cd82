"""Reading single groups, datasets and attributes of an HDF5 file that nobody vouches for."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NoReturn

import h5py
import numpy as np

from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array
from pivotgait.plans.layout import MAX_FILE_BYTES, MAX_TEXT_BYTES

_MEND = "write the plan again with 'pivotgait plan'"


class Node:
    """A group of the file, and how to read what lies in it.

    Args:
        group: the h5py group.
        where: name of the file and the group in messages.
        spent: bytes read so far, shared by the nodes of one file. One block of a crafted file
            may be linked thousands of times; what is read is capped, not only the file.
    """

    def __init__(self, group: Any, where: str, spent: list[int] | None = None) -> None:
        self.group, self.where = group, where
        self._spent = [0] if spent is None else spent

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what the group holds."""
        return tuple(self.group)

    def child(self, name: str) -> Node:
        """The group ``name`` in this one."""
        found = self._linked(name)
        if not isinstance(found, h5py.Group):
            self.fail(f"{name!r} is not a group")
        return Node(found, f"{self.where}/{name}", self._spent)

    def array(self, name: str, shape: tuple[int | None, ...]) -> Array:
        """Dataset of float64; None in ``shape`` stands for any length."""
        data = self._linked(name)
        if not isinstance(data, h5py.Dataset):
            self.fail(f"{name!r} is not a dataset")
        self._check_type(name, data.dtype, data.shape, shape)
        # Contiguous and fully allocated: no fill values that unpack a small file into gigabytes,
        # no filter plug-ins, no virtual or external storage that reads other files.
        stored = data.id.get_create_plist()
        if stored.get_layout() != h5py.h5d.CONTIGUOUS or stored.get_external_count():
            self.fail(f"dataset {name!r} is not stored contiguously in this file")
        if data.id.get_storage_size() != data.nbytes:
            self.fail(f"dataset {name!r} is not wholly there")
        self._spend(data.nbytes)
        return np.asarray(data[()], dtype=float)

    def number(self, name: str) -> float:
        """Scalar float64 attribute."""
        return float(self.vector(name, ()))

    def vector(self, name: str, shape: tuple[int, ...]) -> Array:
        """Attribute of float64 numbers."""
        self._check_type(name, *self._attribute(name), shape)
        return np.asarray(self.group.attrs[name], dtype=float)

    def integer(self, name: str) -> int:
        """Scalar integer attribute."""
        dtype, shape = self._attribute(name)
        if dtype.kind not in "iu" or shape != ():
            self.fail(f"attribute {name!r} is not an integer")
        return int(self.group.attrs[name])

    def text(self, name: str) -> str:
        """Scalar UTF-8 string attribute, of fixed or variable length."""
        dtype, shape = self._attribute(name)
        if h5py.check_string_dtype(dtype) is None or shape != ():
            self.fail(f"attribute {name!r} is not a text")
        value = self.group.attrs[name]
        data = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else bytes(value)
        if len(data) > MAX_TEXT_BYTES:
            self.fail(f"attribute {name!r} holds {len(data)} bytes")
        self._spend(len(data))
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            self.fail(f"attribute {name!r} is not UTF-8")

    def texts(self, name: str, most: int) -> tuple[str, ...]:
        """Attribute of at most ``most`` UTF-8 strings of fixed length, in one dimension."""
        dtype, shape = self._attribute(name)
        kind = h5py.check_string_dtype(dtype)
        # Strings of variable length may all share one block of a crafted file; their sum would be
        # known only after it was read.
        if kind is None or kind.length is None or shape is None or len(shape) != 1:
            self.fail(f"attribute {name!r} is not a list of texts of fixed length")
        if shape[0] > most:
            self.fail(f"attribute {name!r} holds {shape[0]} texts, more than {most}")
        try:
            return tuple(bytes(each).decode("utf-8") for each in self.group.attrs[name])
        except UnicodeDecodeError:
            self.fail(f"attribute {name!r} is not UTF-8")

    def fail(self, what: str, mend: str = _MEND) -> NoReturn:
        """Raise :class:`PlanFileError` about this group."""
        raise PlanFileError(what, where=self.where, mend=mend)

    def _linked(self, name: str) -> Any:
        link = self.group.get(name, getlink=True)
        if link is None:
            self.fail(f"{name!r} is missing; has {_listed(self.group)}")
        if not isinstance(link, h5py.HardLink):
            self.fail(f"{name!r} is a soft or external link")
        return self.group[name]

    def _attribute(self, name: str) -> tuple[np.dtype[Any], tuple[int, ...] | None]:
        if name not in self.group.attrs:
            self.fail(f"attribute {name!r} is missing; has {_listed(self.group.attrs)}")
        found = self.group.attrs.get_id(name)
        if found.get_storage_size() > MAX_TEXT_BYTES:
            self.fail(f"attribute {name!r} is too large")
        return found.dtype, found.shape

    def _check_type(
        self, name: str, dtype: Any, shape: tuple[int, ...] | None, wanted: tuple[int | None, ...]
    ) -> None:
        if dtype.kind != "f" or dtype.itemsize != 8:
            self.fail(f"{name!r} has type {dtype}, not float64")
        fits = shape is not None and len(shape) == len(wanted)
        if not fits or any(w not in (None, s) for s, w in zip(shape or (), wanted, strict=True)):
            shown = "(" + ", ".join("N" if w is None else str(w) for w in wanted) + ")"
            self.fail(f"{name!r} has shape {shape}, not {shown}")

    def _spend(self, size: int) -> None:
        self._spent[0] += size
        if self._spent[0] > MAX_FILE_BYTES:
            self.fail(f"holds more than {MAX_FILE_BYTES >> 20} MB of data")


def _listed(names: Iterable[str]) -> str:
    return ", ".join(list(names)[:12]) or "nothing"
