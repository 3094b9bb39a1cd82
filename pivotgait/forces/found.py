"""What every allocation solver hands back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Found(NamedTuple):
    """Forces of T samples.

    Attributes:
        force: (T, m, 3) forces [N], NaN where infeasible.
        feasible: (T,) whether there are any.
        iterations: of the slowest sample: Newton steps, or programs solved.
        converged: whether every sample reached its optimum; the forces hold all limits anyway.
    """

    force: NDArray[np.float64]
    feasible: NDArray[np.bool_]
    iterations: int
    converged: bool = True

    @classmethod
    def of(cls, parts: list[Found]) -> Found:
        """Samples solved one by one."""
        return cls(
            np.concatenate([part.force for part in parts]),
            np.concatenate([part.feasible for part in parts]),
            max(part.iterations for part in parts),
            all(part.converged for part in parts),
        )
