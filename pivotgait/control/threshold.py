"""A threshold with hysteresis in value and time."""

from __future__ import annotations


class Threshold:
    """On once a value stayed below for long enough, off once it stayed above for as long.

    Attributes:
        on: whether the value counts as below.
    """

    def __init__(self, below: float, hysteresis: float, lasting_s: float) -> None:
        """Below ``below`` it turns on, above ``below + hysteresis`` off."""
        self._below, self._above = below, below + hysteresis
        self._lasting = lasting_s
        self.reset()

    def reset(self) -> None:
        """Off."""
        self.on = False
        self._since: float | None = None

    def update(self, value: float, time: float) -> bool:
        """Take the value at ``time`` [s]; whether it is on now."""
        against = value >= self._above if self.on else value < self._below
        if not against:
            self._since = None
        elif self._since is None:
            self._since = time
        if self._since is not None and time - self._since >= self._lasting:
            self.on, self._since = not self.on, None
        return self.on
