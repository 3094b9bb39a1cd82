"""Which limit of which contact keeps a grasp from being deeper."""

from __future__ import annotations

from typing import NamedTuple

from pivotgait.exceptions import InputError
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.limits import tightest_labels
from pivotgait.forces.local_form import local_form
from pivotgait.forces.null_space import Inconsistent, reduce
from pivotgait.forces.phase_one import phase_one


class Tightest(NamedTuple):
    """The limit with the largest multiplier of a grasp's depth.

    Attributes:
        kind: ``friction``, ``normal_min``, ``normal_max``, ``rows``, or ``wrench`` where no
            forces of any size apply the load.
        contact: whose; the row's number for ``rows``, empty for ``wrench``.
        depth: of the grasp [N], negative where infeasible.
    """

    kind: str
    contact: str
    depth: float


def tightest_limit(grasps: Grasps) -> Tightest:
    """The limit that binds most in one grasp.

    Raises:
        InputError: for more than one grasp.
    """
    if grasps.count != 1:
        raise InputError(f"{grasps.count} grasps", mend="ask about one at a time")
    group = next(reduce(local_form(grasps.problem), grasps.problem.wrench, grasps.friction))
    if isinstance(group, Inconsistent):
        return Tightest("wrench", "", -float(group.residual[0]))
    end = phase_one(group.cones, exact=True)
    kind, index = tightest_labels(group, end.dual)[0]
    contact = str(index) if kind == "rows" else grasps.names[index]
    return Tightest(kind, contact, -float(end.shift[0] * group.scale[0]))
