"""Why branches of a search died: counted by the test that ended them and its reason."""

from __future__ import annotations

from collections import Counter
from typing import Any

STAGES = (
    "place on the handle",
    "order of fingers",
    "over the table",
    "span of the hand",
    "forces at rest",
    "attitude after a removal",
    "postures",
    "palm",
    "phases",
    "hand's motion",
    "certificate",
)
"""Tests in their order, from the cheapest to the dearest."""


class Deaths:
    """Counts branches, or places and moves that never became one.

    Attributes:
        counts: (stage, reason) -> number.
    """

    def __init__(self) -> None:
        self.counts: Counter[tuple[str, str]] = Counter()

    def add(self, stage: str, reason: str, number: int = 1) -> None:
        """Count some; none are not entered."""
        if number:
            self.counts[stage, reason] += number

    @property
    def total(self) -> int:
        """Of all stages."""
        return self.counts.total()

    def rows(self) -> list[tuple[str, str, int]]:
        """Stage, reason, number: by stage, the most frequent first."""
        ordered = sorted(
            self.counts.items(), key=lambda each: (STAGES.index(each[0][0]), -each[1], each[0][1])
        )
        return [(stage, reason, number) for (stage, reason), number in ordered]

    def as_json(self) -> list[dict[str, Any]]:
        """Plain data for the command line."""
        return [
            {"stage": stage, "reason": reason, "count": number}
            for stage, reason, number in self.rows()
        ]
