"""Errors of pivotgait: one base, each with the offending data and the way to mend it."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from math import degrees


class PivotGaitError(Exception):
    """Base of every error this package raises on purpose.

    Args:
        what: what is wrong, with the offending value and its unit.
        where: the file, field or phase it was found in.
        mend: what the user can do about it.

    The command line prints ``str(error)`` on one line and leaves with ``exit_code``.
    """

    exit_code = 1

    def __init__(self, what: str, *, where: str = "", mend: str = "") -> None:
        self.what, self.where, self.mend = what, where, mend
        text = f"{where}: {what}" if where else what
        text = f"{text} - {mend}" if mend else text
        super().__init__(" ".join(text.split()))


class InputError(PivotGaitError):
    """Something the user gave (file, value, name) cannot be used; exit code 2."""

    exit_code = 2


class UrdfError(InputError):
    """A URDF file that must not reach the native parsers."""


class SceneError(InputError):
    """A scene file that cannot be read, or whose values contradict each other."""


class PlanFileError(InputError):
    """A plan file that is missing, damaged or not of this schema."""


class UnknownNameError(InputError):
    """A name that is not among the known ones; lists them and the nearest."""

    def __init__(self, kind: str, name: str, known: Iterable[str], *, where: str = "") -> None:
        self.name, self.known = name, tuple(known)
        near = get_close_matches(name, self.known, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        listed = ", ".join(self.known) or "none"
        super().__init__(f"unknown {kind} {name!r}", where=where, mend=f"{hint}known: {listed}")


class InfeasibleError(PivotGaitError):
    """No forces or no motion satisfy the constraints; says which one binds."""


class SolverError(PivotGaitError):
    """A solver failed on a problem that is not known to be infeasible."""


class SingularCoordinatesError(PivotGaitError):
    """An orientation so near psi = +-90 degrees that theta and phi cannot be told apart.

    Attributes:
        angle: the largest |psi| met [rad].
    """

    def __init__(self, angle: float, *, where: str = "") -> None:
        self.angle = angle
        super().__init__(
            f"local coordinates are singular near 90 degrees, |psi| = {degrees(angle):.2f} degrees",
            where=where,
            mend="choose target axes nearer to the frame's own",
        )
