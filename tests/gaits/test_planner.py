"""The tool's gait: every built-in scene gives a plan that certifies, the same one each time."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pivotgait.certification import certify
from pivotgait.exceptions import InfeasibleError, InputError, UnknownNameError
from pivotgait.gaits import PhaseDone, PosturesFound, plan_gait
from pivotgait.models import (
    PhaseConfig,
    RelocationPhase,
    Scene,
    builtin_scenes,
    export_scene,
    load_scene,
    parse_scene,
)
from pivotgait.plans import GaitPlan, write_plan

SCENES = pytest.mark.parametrize("name", builtin_scenes())


@cache
def planned(name: str) -> tuple[Scene, GaitPlan, tuple[PhaseDone | PosturesFound, ...]]:
    scene = load_scene(name)
    news: list[PhaseDone | PosturesFound] = []
    plan = plan_gait(scene, seed=3, hand=False, progress=news.append)
    return scene, plan, tuple(news)


def felt_by_the_tool(scene: Scene) -> list[PhaseConfig]:
    """The gait's phases without relocations, during which the tool rests in the same grasp."""
    return [each for each in scene.gaits["default"] if not isinstance(each, RelocationPhase)]


@SCENES
def test_plan_of_every_built_in_scene_certifies(name: str) -> None:
    _, plan, _ = planned(name)
    certificate = certify(plan)
    assert certificate.valid, [violation.as_json() for violation in certificate.violations]


@SCENES
def test_plan_follows_its_scene(name: str) -> None:
    scene, plan, _ = planned(name)
    configs = felt_by_the_tool(scene)
    assert [phase.kind for phase in plan.phases] == [config.kind for config in configs]
    for place, (phase, config) in enumerate(zip(plan.phases, configs, strict=True)):
        assert phase.name == f"{place:02d}_{config.kind}"
        assert phase.duration_s == pytest.approx(config.duration_s, rel=1e-15)
        assert len(phase.time) == config.steps + 1
    assert plan.scene == scene.yaml
    assert plan.seed == 3
    assert plan.tool.mass == scene.tool.mass
    assert plan.certificate is None
    assert plan.robot is None
    assert all(phase.robot is None for phase in plan.phases)
    assert {"pivotgait", "numpy", "casadi", "clarabel"} <= set(plan.versions)


@SCENES
def test_phases_join(name: str) -> None:
    _, plan, _ = planned(name)
    for before, after in zip(plan.phases, plan.phases[1:], strict=False):
        turn = before.tool.rotation[-1].inv() * after.tool.rotation[0]
        assert turn.magnitude() < 1e-12
        for contact in before.contacts.keys() & after.contacts.keys():
            ends = before.contacts[contact].force[-1], after.contacts[contact].force[0]
            # a thousandth of the certificate's 1e-6 N
            np.testing.assert_allclose(*ends, atol=1e-9)


@SCENES
def test_progress_is_told_once_per_phase(name: str) -> None:
    _, plan, news = planned(name)
    assert all(isinstance(each, PhaseDone) for each in news)  # no hand, no postures
    assert [each.place for each in news] == list(range(len(plan.phases)))
    assert all(each.count == len(plan.phases) for each in news)
    assert all(each.phase is phase for each, phase in zip(news, plan.phases, strict=True))
    assert all(each.plan_time_s > 0.0 for each in news)


@pytest.mark.parametrize("name", ["knife", "wrench"])
def test_same_seed_gives_the_same_bytes(name: str, tmp_path: Path) -> None:
    scene, plan, _ = planned(name)
    write_plan(plan, tmp_path / "first.h5")
    write_plan(plan_gait(scene, seed=3, hand=False), tmp_path / "second.h5")
    assert (tmp_path / "first.h5").read_bytes() == (tmp_path / "second.h5").read_bytes()


def test_heading_of_the_scene_changes_nothing_but_the_heading() -> None:
    _, straight, _ = planned("screwdriver")
    text = export_scene("screwdriver").replace("yaw_deg: 0\n", "yaw_deg: -50\n")
    turned = plan_gait(parse_scene(text), hand=False)
    assert certify(turned).valid
    for here, there in zip(straight.phases, turned.phases, strict=True):
        # two runs of converged solvers in two frames
        assert there.reorientation_deg == pytest.approx(here.reorientation_deg, abs=1e-2)
        for contact, track in here.contacts.items():
            size = np.linalg.norm(track.force, axis=1)
            other = np.linalg.norm(there.contacts[contact].force, axis=1)
            np.testing.assert_allclose(other[[0, -1]], size[[0, -1]], atol=1e-3)


def test_an_unknown_gait_lists_those_there_are() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown gait 'defualt'.*did you mean 'default'"):
        plan_gait(load_scene("knife"), gait="defualt")


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(InputError, match="seed -1 is negative"):
        plan_gait(load_scene("knife"), seed=-1)


def test_a_named_gait_is_planned() -> None:
    lift = "    - {kind: lift, contacts: [thumb_side, index_side], duration_s: 1, steps: 20, "
    text = export_scene("wrench") + "  up:\n" + lift + "to: {pitch_deg: 20}}\n"
    plan = plan_gait(parse_scene(text), gait="up")
    assert [phase.name for phase in plan.phases] == ["00_lift"]
    assert certify(plan).valid


def test_an_infeasible_phase_is_named() -> None:
    text = export_scene("wrench").replace("friction: 0.8", "friction: 0.02")
    with pytest.raises(InfeasibleError, match=r"^00_lift: .*binds") as caught:
        plan_gait(parse_scene(text))
    assert caught.value.mend
