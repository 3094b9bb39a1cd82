"""The first thing a report says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Literal

from pivotgait.reporting.numbers import quantity
from pivotgait.reporting.rows import violation_rows
from pivotgait.validation.record_reading import RecordedRun

_SIMULATORS = MappingProxyType({"pybullet": "PyBullet", "mujoco": "MuJoCo"})


@dataclass(frozen=True)
class Verdict:
    """A headline, a sentence, and how they are coloured."""

    state: Literal["valid", "invalid", "unknown"]
    headline: str
    sentence: str


def verdict(certificate: Mapping[str, Any] | None, run: RecordedRun | None = None) -> Verdict:
    """What a certificate and, if there is one, a closed-loop run mean for the plan.

    Args:
        certificate: as ``pivotgait certify --json`` gives it.
        run: of the plan.
    """
    found = _certified(certificate)
    if run is None:
        return found
    where = simulator_name(run)
    sentence = f"{found.sentence} {run_sentence(run)}"
    if not run.verdict.passed:
        word = "but" if found.state == "valid" else "and"
        headline = f"{found.headline}, {word} its run in {where} failed"
        return Verdict("invalid", headline, sentence)
    word = "but" if found.state == "invalid" else ""
    headline = f"{found.headline}, {word} carried out in {where}".replace("  ", " ")
    return replace(found, headline=headline, sentence=sentence)


def run_sentence(run: RecordedRun) -> str:
    """What became of a run, and if it failed when and why."""
    where, how = simulator_name(run), f"{run.controller} control"
    found = run.verdict
    if found.passed:
        return f"In {where} under {how} every phase and the final hold were carried out."
    place = f" in {found.stage} after {quantity(found.time_s, 's')}" if found.stage else ""
    why = f": {found.detail}" if found.detail else ""
    return f"In {where} under {how} the run failed by {found.failure}{place}{why}."


def simulator_name(run: RecordedRun) -> str:
    """The simulator as its makers write it."""
    return engine_name(run.simulator)


def engine_name(simulator: str) -> str:
    """A simulator's name as its makers write it."""
    return _SIMULATORS.get(simulator, simulator)


def _certified(certificate: Mapping[str, Any] | None) -> Verdict:
    if not certificate:
        return Verdict("unknown", "Not certified", "Run pivotgait certify on the plan.")
    count = len(certificate.get("residuals", {}))
    if certificate.get("valid") is True:
        sentence = f"All {count} checks of the certificate hold."
        return Verdict("valid", "Valid gait", sentence)
    failed = violation_rows(certificate)
    if not failed:
        return Verdict("invalid", "Not a valid gait", "The certificate does not say why.")
    first = failed[0]
    checks = "One check fails" if len(failed) == 1 else f"{len(failed)} checks fail"
    sentence = (
        f"{checks}; first: {first.meaning}, {first.value} (limit {first.limit}), {first.where}."
    )
    return Verdict("invalid", "Not a valid gait", sentence)
