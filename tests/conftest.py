"""What every test may rely on."""

from __future__ import annotations

from hypothesis import settings

from pivotgait.forces.proxqp_build import load_proxqp

# The same examples in every run, and no time limit: the machine may be busy.
settings.register_profile("pivotgait", deadline=None, derandomize=True)
settings.load_profile("pivotgait")

# Before any test imports cvxpy, which would bring another build of it.
load_proxqp()
