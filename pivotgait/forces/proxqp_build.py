"""ProxQP as built for any processor: its results do not depend on where memory lies."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

_CHECKS = "proxsuite.instructionset"
_WIDE = ("has_AVX512F", "has_AVX2")


def load_proxqp() -> Any:
    """The module ``proxsuite.proxqp``.

    Proxsuite brings builds for AVX-512, AVX2 and any processor and takes the widest that the
    processor has. The wide ones sum in an order that depends on the address of their buffers
    modulo 32 or 64 bytes, which differs from process to process: the same program has answers
    1e-11 apart. The portable one needs 16 bytes, which every allocation has. For programs of our
    sizes it is as fast.

    Two builds in one process break it off, so that one which is already there is kept.
    """
    if "proxsuite" not in sys.modules:
        none = ModuleType(_CHECKS)
        for check in _WIDE:
            setattr(none, check, bool)  # bool() is False
        sys.modules[_CHECKS] = none
    from proxsuite import proxqp

    return proxqp


def load_cvxpy() -> Any:
    """The module ``cvxpy``, which looks for proxsuite when it loads and finds our build."""
    load_proxqp()
    import cvxpy

    return cvxpy
