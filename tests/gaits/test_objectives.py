"""Every objective and every timing law plans a gait that certifies."""

from __future__ import annotations

import pytest

from pivotgait.certification import certify
from pivotgait.forces import OBJECTIVES
from pivotgait.gaits import plan_gait
from pivotgait.margins import smallest_margin
from pivotgait.models import load_scene, parse_scene


@pytest.mark.parametrize("profile", ["quintic", "trapezoidal"])
@pytest.mark.parametrize("objective", OBJECTIVES)
def test_the_knifes_gait_certifies_and_keeps_its_reserve(objective: str, profile: str) -> None:
    text = load_scene("knife").yaml
    text = text.replace("objective: alignment", f"objective: {objective}")
    scene = parse_scene(text.replace("profile: quintic", f"profile: {profile}"))
    assert scene.allocation.objective == objective
    plan = plan_gait(scene, hand=False)
    certificate = certify(plan)
    assert certificate.valid, certificate.violations
    margin = smallest_margin(plan, ("friction",))
    assert margin is not None
    # the certificate's tolerance of 1e-8 N on a force of a tenth of a newton
    assert margin.value >= scene.allocation.friction_reserve - 1e-6
