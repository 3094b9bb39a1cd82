"""A plan with moving and idle fingers, its reference, and readings on it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from pivotgait.benchmarks.control import held_knife_plan
from pivotgait.control import Measurement, Reference
from pivotgait.plans import GaitPlan

Array = NDArray[np.float64]


@pytest.fixture(scope="session")
def plan() -> GaitPlan:
    """Phase 0: three fingers turn the knife. Phase 1: the middle finger is in the air."""
    return held_knife_plan()


@pytest.fixture(scope="session")
def reference(plan: GaitPlan) -> Reference:
    return Reference.of(plan)


def reading(
    reference: Reference,
    time: float,
    *,
    off: float | Array = 0.0,
    v_off: float | Array = 0.0,
    more: float = 0.0,
) -> Measurement:
    """The planned state; joints displaced by ``off``; ``more`` normal force on each finger [N]."""
    wanted = reference.at(time)
    tool = wanted.tool
    forces = {
        hold.finger.name: tool.rotation @ (force + more * hold.normal)
        for hold, force in zip(
            reference.phases[wanted.phase].holds, wanted.force_in_tool, strict=True
        )
    }
    return Measurement(
        time=time,
        q=wanted.q + off,
        v=wanted.v + v_off,
        force=forces,
        tool_position=tool.position,
        tool_rotation=tool.rotation,
        tool_linear_velocity=tool.linear_velocity,
        tool_angular_velocity=tool.angular_velocity,
    )


@pytest.fixture(scope="session")
def read(reference: Reference) -> Callable[..., Measurement]:
    def make(time: float, **changes: float | Array) -> Measurement:
        return reading(reference, time, **changes)  # type: ignore[arg-type]

    return make


STENCIL = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0


@pytest.fixture(scope="session")
def rate() -> Callable[[Callable[[float], Array], float], Array]:
    """Derivative by central differences of fourth order."""

    def of(function: Callable[[float], Array], time: float, step: float = 1e-4) -> Array:
        samples = np.stack([function(time + k * step) for k in range(-2, 3)])
        return np.tensordot(STENCIL, samples, axes=1) / step

    return of
