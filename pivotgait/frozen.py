"""Read-only arrays for frozen records."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def frozen(array: Any) -> Array:
    """Return a read-only float64 copy of ``array``."""
    copy = np.array(array, dtype=float)
    copy.setflags(write=False)
    return copy


class FrozenArrays:
    """Makes every array field of a frozen dataclass a read-only float64 copy."""

    def __post_init__(self) -> None:
        for entry in fields(cast(Any, self)):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, entry.name, frozen(value))
