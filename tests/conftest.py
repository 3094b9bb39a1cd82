"""What every test may rely on."""

from __future__ import annotations

from hypothesis import settings

# The same examples in every run, and no time limit: the machine may be busy.
settings.register_profile("pivotgait", deadline=None, derandomize=True)
settings.load_profile("pivotgait")
