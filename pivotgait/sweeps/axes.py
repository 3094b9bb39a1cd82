"""The values along one axis of a sweep."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from pivotgait.models.parameters import Value
from pivotgait.sweeps.errors import StudyError
from pivotgait.sweeps.study_config import DRAWN, KINDS, MAX_VALUES, AxisConfig, Between, Range


@dataclass(frozen=True)
class Axis:
    """A parameter with its values.

    Attributes:
        parameter: that varies.
        config: of the values.
    """

    parameter: str
    config: AxisConfig

    @property
    def kind(self) -> str:
        """Which of the study file's words gives the values."""
        return self.config.given[0]

    @property
    def drawn(self) -> bool:
        """Whether the values are drawn from a distribution."""
        return self.kind in DRAWN

    @property
    def named(self) -> bool:
        """Whether the values are names rather than numbers."""
        return self.config.names is not None

    @property
    def count(self) -> int:
        """Number of places on the grid; 1 for a distribution, whose draws are counted apart."""
        config = self.config
        if config.range is not None:
            return _steps(config.range)
        if config.linspace is not None:
            return config.linspace.count
        return len(config.values or config.names or (None,))

    def value(self, place: int) -> Value:
        """The value at a place of the grid."""
        config = self.config
        if config.linspace is not None:
            span = config.linspace
            share = place / (span.count - 1)
            return span.from_ * (1.0 - share) + span.to * share
        if config.range is not None:
            return config.range.from_ + place * config.range.step
        return (config.values or config.names or ())[place]

    def draw(self, seed: int, place: int) -> float:
        """Draw number ``place`` from the distribution.

        It depends on the seed, the parameter's name and ``place`` alone: more draws keep those
        before, and every place of the grid meets the same draws, so that differences between
        places are not blurred by chance.
        """
        name = hashlib.sha256(self.parameter.encode()).digest()[:8]
        sequence = np.random.SeedSequence(seed, spawn_key=(int.from_bytes(name, "big"), place))
        rng, config = np.random.default_rng(sequence), self.config
        if config.normal is not None:
            return float(rng.normal(config.normal.mean, config.normal.sd))
        bounds = config.uniform or config.loguniform
        assert bounds is not None  # `make_axis` admits no axis without values
        if config.uniform is not None:
            return float(rng.uniform(bounds.from_, bounds.to))
        return float(np.exp(rng.uniform(np.log(bounds.from_), np.log(bounds.to))))


def make_axis(parameter: str, config: AxisConfig, *, where: str) -> Axis:
    """An axis whose values are checked.

    Raises:
        StudyError: none or several kinds of values, a value given twice, an empty range, bounds
            that are no interval.
    """
    if len(config.given) != 1:
        what = f"gives {' and '.join(config.given) or 'no values'}"
        raise StudyError(what, where=where, mend=f"give one of: {', '.join(KINDS)}")
    axis = Axis(parameter, config)
    at = f"{where}.{axis.kind}"
    listed = config.values or config.names or ()
    if len(set(listed)) < len(listed):
        twice = next(each for each in listed if listed.count(each) > 1)
        raise StudyError(f"gives {twice!r} twice", where=at, mend="leave one of them out")
    if config.linspace is not None and config.linspace.from_ == config.linspace.to:
        mend = "give one value in values, or another end"
        raise StudyError("starts where it ends", where=at, mend=mend)
    if config.range is not None:
        _check_range(config.range, at)
    for bounds in (config.uniform, config.loguniform):
        if bounds is not None:
            _check_bounds(bounds, at, positive=config.loguniform is not None)
    return axis


def _steps(given: Range) -> int:
    # a billionth of a step is forgiven: 0.1 + 2 * 0.1 is a little more than 0.3
    return int(np.floor((given.to - given.from_) / given.step + 1e-9)) + 1


def _check_range(given: Range, at: str) -> None:
    if given.to < given.from_:
        what = f"is empty: it goes from {given.from_:g} up to {given.to:g}"
        raise StudyError(what, where=at, mend="swap from and to")
    if (given.to - given.from_) / given.step >= MAX_VALUES:
        raise StudyError(f"has over {MAX_VALUES:,} values", where=at, mend="give a longer step")


def _check_bounds(given: Between, at: str, *, positive: bool) -> None:
    if given.to <= given.from_:
        what = f"goes from {given.from_:g} to {given.to:g}"
        raise StudyError(what, where=at, mend="give a lower bound that is below the upper one")
    if positive and given.from_ <= 0.0:
        raise StudyError(f"starts at {given.from_:g}", where=at, mend="give a positive number")
