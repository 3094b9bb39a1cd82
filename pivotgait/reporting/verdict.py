"""The first thing a report says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from pivotgait.reporting.rows import violation_rows


@dataclass(frozen=True)
class Verdict:
    """A headline, a sentence, and how they are coloured."""

    state: Literal["valid", "invalid", "unknown"]
    headline: str
    sentence: str


def verdict(certificate: Mapping[str, Any] | None) -> Verdict:
    """What a certificate (as ``pivotgait certify --json`` gives it) means for the plan."""
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
