"""How far one sample of soft fingers reaches: whether they hold, and the ends of linear ranges."""

from __future__ import annotations

from typing import Any

import numpy as np

from pivotgait.contacts import contact_frame, grasp_map
from pivotgait.forces.clarabel_ import optimum
from pivotgait.forces.soft_finger import COORDINATES, SoftFingerProblem
from pivotgait.frozen import Array

HELD_N = 1e-6
"""A wrench is applied that misses the wanted one by less, moments over the grasp's size."""


class SoftFingerRange:
    """One sample of a :class:`SoftFingerProblem`, without its rate of forces.

    Variables are (t_x, t_y, f_n, w) of every finger, with w = mu m / e, and one more: by how much
    the wrench is missed, or the factor of the wrench.

    Args:
        problem: the fingers.
        sample: which of its samples.
    """

    def __init__(self, problem: SoftFingerProblem, sample: int) -> None:
        m = len(problem.names)
        self._problem, self._width = problem, COORDINATES * m + 1
        maps = grasp_map(problem.lever[sample]).reshape(6, m, 3)
        self._normals = problem.normals[sample]
        self._forces = np.einsum("amj,mjk->amk", maps, contact_frame(self._normals))
        size = float(np.sqrt(np.mean(np.sum(problem.lever[sample] ** 2, axis=1))))
        self._weight = np.repeat([1.0, 1.0 / size], 3)
        self._wrench = self._weight * problem.wrench[sample]

    def holds(self, *, friction: float = 1.0, torsion: float = 1.0) -> bool:
        """Whether forces apply the wrench, with factors of mu and of e."""
        import clarabel

        last = np.zeros(self._width)
        last[-1] = 1.0
        missed = np.zeros((7, self._width))
        missed[0], missed[1:, :-1] = -last, self._applied(friction, torsion)
        side = np.append(0.0, self._wrench)
        found = self._end(last, friction, (missed, side, clarabel.SecondOrderConeT(7)))
        return found is not None and float(found[-1]) <= HELD_N

    def load(self) -> tuple[float, float] | None:
        """Least and largest factor of the wrench that forces apply; None for none at all."""
        return self._both(self._width - 1, load=0.0)

    def normal(self, finger: int) -> tuple[float, float] | None:
        """Least and largest normal force of a finger [N]; None where nothing holds."""
        return self._both(COORDINATES * finger + 2, load=1.0)

    def _both(self, variable: int, *, load: float) -> tuple[float, float] | None:
        """Ends of a variable; ``load`` is the least factor of the wrench, 1 stands for just 1."""
        import clarabel

        rows = np.zeros((7, self._width))
        rows[:6, :-1], rows[:6, -1] = self._applied(1.0, 1.0), -self._wrench
        if load == 1.0:
            rows[6, -1] = 1.0
            given = (rows, np.append(np.zeros(6), 1.0), clarabel.ZeroConeT(7))
        else:
            given = (rows[:6], np.zeros(6), clarabel.ZeroConeT(6))
        one = np.zeros(self._width)
        one[variable] = 1.0
        least, most = (self._end(sign * one, 1.0, given) for sign in (1.0, -1.0))
        return None if least is None or most is None else (float(one @ least), float(one @ most))

    def _applied(self, friction: float, torsion: float) -> Array:
        """(6, 4 m) wrench of the fingers' variables, moments over the grasp's size."""
        p = self._problem
        columns = np.zeros((6, len(p.names), COORDINATES))
        columns[..., :3] = self._forces
        spin = torsion * p.torsion / (friction * p.friction)
        columns[3:, :, 3] = (self._normals * spin[:, None]).T
        return np.asarray(self._weight[:, None] * columns.reshape(6, -1))

    def _end(self, linear: Array, friction: float, given: tuple[Array, Array, Any]) -> Array | None:
        """Variables that minimise a linear function; None where the limits leave none."""
        import clarabel
        from scipy.sparse import csc_matrix

        p, m = self._problem, len(self._problem.names)
        place = COORDINATES * np.arange(m)
        normal = np.zeros((m + 1, self._width))
        normal[np.arange(m), place + 2], normal[m, -1] = 1.0, 1.0
        stiff = np.flatnonzero(p.torsion == 0.0)
        still = np.zeros((len(stiff), self._width))
        still[np.arange(len(stiff)), place[stiff] + 3] = 1.0
        cones = np.zeros((m, 4, self._width))
        for k, at in enumerate(place.tolist()):
            cones[k, 0, at + 2] = -friction * p.friction[k]
            cones[k, [1, 2, 3], [at, at + 1, at + 3]] = -1.0
        blocks = [
            given,
            (-normal, np.append(-p.normal_min, 0.0), clarabel.NonnegativeConeT(m + 1)),
            (normal[:m], p.normal_max, clarabel.NonnegativeConeT(m)),
        ]
        if len(stiff):
            blocks.append((still, np.zeros(len(stiff)), clarabel.ZeroConeT(len(stiff))))
        rows = np.concatenate([block[0] for block in blocks] + list(cones))
        sides = np.concatenate([block[1] for block in blocks] + [np.zeros(4 * m)])
        kinds = [block[2] for block in blocks] + [clarabel.SecondOrderConeT(4)] * m
        square = csc_matrix((self._width, self._width))
        return optimum(square, linear, csc_matrix(rows), sides, kinds)[0]
