"""Postures that a scene's phases suggest are checked before anything native sees them."""

from __future__ import annotations

import pytest

from pivotgait.exceptions import PivotGaitError
from pivotgait.models import LiftPhase, Scene, export_scene, parse_scene

REMOVAL = "{kind: removal, contact: index_edge,"


def with_posture(posture: str, field: str = "posture") -> Scene:
    text = export_scene("knife")
    assert text.count(REMOVAL) == 1
    return parse_scene(text.replace(REMOVAL, f"{REMOVAL} {field}: {posture},"), where="mine")


def test_joints_left_out_are_at_home() -> None:
    scene = with_posture("{J1: 0.25, FFJ2: 0.5}")
    assert scene.robot is not None
    (phase,) = (p for p in scene.gaits["default"] if p.kind == "removal")
    q = scene.robot.posture(phase.posture)
    names = scene.robot.joint_names
    assert (q[names.index("J1")], q[names.index("FFJ2")]) == (0.25, 0.5)
    others = [k for k, name in enumerate(names) if name not in ("J1", "FFJ2")]
    assert q[others] == pytest.approx(scene.robot.home[others], abs=0.0)


def test_a_lift_may_suggest_two() -> None:
    text = export_scene("knife").replace("kind: lift,", "kind: lift, posture_before: {J3: 0.2},")
    (lift,) = (p for p in parse_scene(text).gaits["default"] if isinstance(p, LiftPhase))
    assert lift.posture_before == {"J3": 0.2}
    assert lift.posture == {}


@pytest.mark.parametrize(
    ("posture", "field", "said"),
    [
        ("{J11: 0.0}", "posture", r"gaits\.default\[\d\]\.posture: unknown moving joint 'J11'"),
        ("{J1: 20.0}", "posture", r"posture\.J1: 20 is outside the limits \["),
        ("{J1: .nan}", "posture", "finite"),
        ("{J1: fast}", "posture", "number"),
        ("[0, 1]", "posture", "posture"),
        ("{J1: 0.0}", "posture_before", "posture_before"),
    ],
)
def test_bad_postures_are_refused_in_one_line(posture: str, field: str, said: str) -> None:
    with pytest.raises(PivotGaitError, match=said) as error:
        with_posture(posture, field)
    assert "\n" not in str(error.value)
    assert error.value.exit_code == 2
