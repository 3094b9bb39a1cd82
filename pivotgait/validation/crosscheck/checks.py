"""A URDF through every engine, each quantity held against the first engine's."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.models.robot_parts import write
from pivotgait.models.urdf.nodes import read_nodes
from pivotgait.validation.crosscheck.found import CrossCheck, Row, Tolerances
from pivotgait.validation.crosscheck.friction import friction_deviation
from pivotgait.validation.crosscheck.reading import ENGINES, Limits, Reading
from pivotgait.validation.engine_check import check_engine
from pivotgait.validation.simulator import SIMULATORS

_SHAPES = ("visual", "collision")
_SPEED, _ACCELERATION = 1.0, 1.0
"""Standard deviations of the joint speeds and accelerations drawn, per second and squared."""


def cross_check(
    urdf: Path | str,
    *,
    engines: Sequence[str] = tuple(ENGINES),
    postures: int = 5,
    friction: float | None = 0.5,
    tolerances: Tolerances | None = None,
    rng: np.random.Generator | None = None,
) -> CrossCheck:
    """Do engines see the same robot in a URDF, its base fixed in the world?

    Compared with the first engine: names of joints and links, position and effort limits, and at
    random postures within the limits the mass matrix, the inverse dynamics (bias included) and
    the placement of every link. Visuals and collisions are removed before: no engine may make
    masses up from them, and no mesh is needed. A joint that mimics another counts as a joint of
    its own. Contact friction, of which a URDF says nothing, is that at which a block of 1 kg
    starts to slide in eight directions, held against Coulomb's law.

    Args:
        urdf: path of a file, or its text.
        engines: names; the first is what the others are held against.
        postures: how many to draw.
        friction: coefficient to ask for; None for no contacts.
        tolerances: the default ones if not given.
        rng: source of the postures; a fixed seed if not given.

    Returns:
        Every comparison. An engine that refuses the file has one row, which says why.

    Raises:
        InputError: a file that cannot be read, fewer than two engines, one not installed; a
            robot without joints, or one the first engine refuses.
        UnknownNameError: no such engine.
        UrdfError: text that is no XML, or unsafe for the engines' parsers.
    """
    text, name = _text(urdf)
    if len(engines) < 2 or postures < 1:
        what = f"{len(engines)} engines, {postures} postures"
        raise InputError(what, where="cross-check", mend="give two engines and a posture at least")
    for engine in engines:
        check_engine("engine", engine, ENGINES)
    bare = without_shapes(text, where=name)
    limits = tolerances or Tolerances()
    rng = np.random.default_rng(0) if rng is None else rng
    rows: list[Row] = []
    with ExitStack() as stack:
        try:
            reference = stack.enter_context(ENGINES[engines[0]](bare))
        except Exception as error:  # each engine has errors of its own
            what = f"{engines[0]} refuses it: {_line(error)}"
            raise InputError(what, where=name, mend="give a URDF it can read") from error
        if not reference.joints:
            mend = "give a robot, not a single body"
            raise InputError("has no joint that moves", where=name, mend=mend)
        motions = [_motion(reference, rng) for _ in range(postures)]
        for engine in engines[1:]:
            try:
                other = stack.enter_context(ENGINES[engine](bare))
            except Exception as error:
                rows.append(Row(engine, "loads", np.inf, 0.0, _line(error)))
                continue
            rows += _Pair(engine, reference, other, limits).rows(motions)
    if friction is not None:
        for engine in (each for each in engines if each in SIMULATORS):
            deviation, where = friction_deviation(engine, friction)
            rows.append(Row(engine, "contact friction", deviation, limits.friction, where))
    return CrossCheck(name, engines[0], tuple(rows))


def without_shapes(urdf: str, *, where: str) -> str:
    """URDF text without visuals and collisions.

    Raises:
        UrdfError: no XML, or not of a robot.
    """
    robot = read_nodes(urdf, where=where)
    for link in robot.all("link"):
        link.children[:] = [each for each in link.children if each.tag not in _SHAPES]
    robot.children[:] = [each for each in robot.children if each.tag in ("link", "joint")]
    return write(robot)


@dataclass(frozen=True, eq=False)
class _Motion:
    """A posture with speeds and accelerations, by the joints' names."""

    q: Mapping[str, float]
    v: Mapping[str, float]
    a: Mapping[str, float]


def _motion(reading: Reading, rng: np.random.Generator) -> _Motion:
    q = {}
    for name, limit in reading.limits().items():
        low, high = max(limit.lower, -np.pi), min(limit.upper, np.pi)
        q[name] = float(rng.uniform(low, high)) if low < high else float(low)
    speeds, accelerations = (
        dict(zip(q, (scale * rng.standard_normal(len(q))).tolist(), strict=True))
        for scale in (_SPEED, _ACCELERATION)
    )
    return _Motion(MappingProxyType(q), speeds, accelerations)


@dataclass(frozen=True)
class _Pair:
    """An engine beside the first one."""

    engine: str
    one: Reading
    two: Reading
    tolerances: Tolerances

    def rows(self, motions: Sequence[_Motion]) -> Iterator[Row]:
        """Every comparison; the numbers only where the joints are the same."""
        joints = set(self.one.joints) ^ set(self.two.joints)
        links = set(self.one.links) ^ set(self.two.links)
        yield self._row("joints", float(len(joints)), 0.0, ", ".join(sorted(joints)))
        yield self._row("links", float(len(links)), 0.0, ", ".join(sorted(links)))
        if joints:
            return
        yield from self._limits()
        allowed = self.tolerances
        yield self._worst("mass matrix", allowed.mass_matrix, motions, self._mass)
        yield self._worst("inverse dynamics", allowed.inverse_dynamics, motions, self._torque)
        yield self._worst("link positions", allowed.position_m, motions, self._position)
        yield self._worst("link orientations", allowed.orientation_rad, motions, self._turn)

    def _limits(self) -> Iterator[Row]:
        pair = self.one.limits(), self.two.limits()

        def largest(of: Callable[[Limits, Limits], float]) -> tuple[float, str]:
            return max((of(pair[0][name], pair[1][name]), name) for name in pair[0])

        allowed = self.tolerances
        lower = largest(lambda a, b: _apart(a.lower, b.lower))
        upper = largest(lambda a, b: _apart(a.upper, b.upper))
        yield self._row("position limits", *_with(max(lower, upper), allowed.limit))
        effort = largest(lambda a, b: _apart(a.effort, b.effort) / max(abs(a.effort), 1.0))
        yield self._row("effort limits", *_with(effort, allowed.effort))

    def _mass(self, motion: _Motion) -> tuple[float, str]:
        ours, theirs = (each.mass_matrix(_vector(each, motion.q)) for each in (self.one, self.two))
        order = _order(self.one, self.two)
        apart = np.abs(theirs[np.ix_(order, order)] - ours)
        row, column = np.unravel_index(int(np.argmax(apart)), apart.shape)
        joints = self.one.joints
        where = f"{joints[int(row)]}, {joints[int(column)]}"
        return float(apart.max() / max(np.abs(ours).max(), 1e-300)), where

    def _torque(self, motion: _Motion) -> tuple[float, str]:
        ours, theirs = (
            each.inverse_dynamics(*(_vector(each, x) for x in (motion.q, motion.v, motion.a)))
            for each in (self.one, self.two)
        )
        apart = np.abs(theirs[_order(self.one, self.two)] - ours)
        where = self.one.joints[int(np.argmax(apart))]
        return float(apart.max() / max(np.abs(ours).max(), 1e-300)), where

    def _position(self, motion: _Motion) -> tuple[float, str]:
        return self._placed(motion, lambda a, b: float(np.linalg.norm(a[:3, 3] - b[:3, 3])))

    def _turn(self, motion: _Motion) -> tuple[float, str]:
        return self._placed(motion, lambda a, b: _angle(a[:3, :3].T @ b[:3, :3]))

    def _placed(self, motion: _Motion, apart: Callable[[Array, Array], float]) -> tuple[float, str]:
        ours, theirs = (each.placements(_vector(each, motion.q)) for each in (self.one, self.two))
        both = [name for name in ours if name in theirs]
        return max(((apart(ours[name], theirs[name]), name) for name in both), default=(0.0, ""))

    def _worst(
        self,
        quantity: str,
        tolerance: float,
        motions: Sequence[_Motion],
        of: Callable[[_Motion], tuple[float, str]],
    ) -> Row:
        return self._row(quantity, *_with(max(map(of, motions)), tolerance))

    def _row(self, quantity: str, deviation: float, tolerance: float, where: str) -> Row:
        return Row(self.engine, quantity, deviation, tolerance, where)


def _with(found: tuple[float, str], tolerance: float) -> tuple[float, float, str]:
    return found[0], tolerance, found[1]


def _apart(one: float, two: float) -> float:
    return 0.0 if one == two else abs(one - two)


def _angle(turn: Array) -> float:
    """Of a rotation matrix [rad]; exact also for small ones."""
    skew = turn - turn.T
    sine = 0.5 * float(np.linalg.norm([skew[2, 1], skew[0, 2], skew[1, 0]]))
    return float(np.arctan2(sine, 0.5 * (np.trace(turn) - 1.0)))


def _vector(reading: Reading, values: Mapping[str, float]) -> Array:
    return np.array([values[name] for name in reading.joints])


def _order(one: Reading, two: Reading) -> list[int]:
    """Places of the first engine's joints in the other's order."""
    return [two.joints.index(name) for name in one.joints]


def _text(urdf: Path | str) -> tuple[str, str]:
    if isinstance(urdf, str) and urdf.lstrip().startswith("<"):
        return urdf, "robot"
    path = Path(urdf)
    try:
        return path.read_text(encoding="utf-8-sig"), path.stem
    except (OSError, ValueError) as error:
        mend = "give the path of a URDF file"
        raise InputError(f"cannot be read: {error}", where=str(path)[-80:], mend=mend) from error


def _line(error: Exception) -> str:
    """What an engine complains of, on one line."""
    return " ".join(str(error).split())[:160] or type(error).__name__
