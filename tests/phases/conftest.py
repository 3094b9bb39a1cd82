"""The built-in scenes, played up to a phase; and the laws that every phase keeps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np
import pytest

from pivotgait.contacts import cone_margin, grasp_map
from pivotgait.dynamics import required_wrench
from pivotgait.models import (
    AdditionPhase,
    LiftPhase,
    RelocationPhase,
    RemovalPhase,
    export_scene,
    parse_scene,
)
from pivotgait.phases.addition import AdditionOptions, plan_addition
from pivotgait.phases.grasp import Grasp, Setting
from pivotgait.phases.lift import LiftOptions, plan_lift
from pivotgait.phases.removal import RemovalOptions, plan_removal, removal_problem
from pivotgait.phases.removal_problem import RemovalProblem, RemovalSolution
from pivotgait.phases.removal_solving import RemovalSolver, solve_with
from pivotgait.plans import Phase

Edits = tuple[tuple[str, str], ...]
Config = LiftPhase | AdditionPhase | RemovalPhase


@dataclass(frozen=True, eq=False)
class Moment:
    """A gait just before one of its phases, as the tool feels them: relocations left out."""

    setting: Setting
    grasp: Grasp
    config: Config

    @property
    def finger(self) -> str:
        """The finger that comes or goes."""
        assert not isinstance(self.config, LiftPhase)
        return self.setting.scene.contacts[self.config.contact].finger

    @property
    def options(self) -> RemovalOptions:
        """Of a removal, as in the scene."""
        return RemovalOptions(self.config.duration_s, self.config.steps)

    @property
    def problem(self) -> RemovalProblem:
        """Of a removal."""
        staying = [c for each, c in self.grasp.fingers.items() if each != self.finger]
        leaving = self.grasp.fingers[self.finger]
        return removal_problem(self.setting, self.grasp, staying, leaving, self.options)

    def plan(self, solver: RemovalSolver | None = None) -> tuple[Phase, Grasp]:
        """Plan the phase."""
        scene, config, name = self.setting.scene, self.config, "phase"
        if isinstance(config, LiftPhase):
            contacts = [scene.contacts[each] for each in config.contacts]
            start = Grasp(self.grasp.rotation, {each.finger: each for each in contacts})
            lift = LiftOptions(config.duration_s, config.steps, config.profile)
            return plan_lift(self.setting, start, scene.lift_rotation(config.to), lift, name=name)
        if isinstance(config, AdditionPhase):
            addition = AdditionOptions(config.duration_s, config.steps)
            contact = scene.contacts[config.contact]
            return plan_addition(self.setting, self.grasp, contact, addition, name=name)
        return plan_removal(self.setting, self.grasp, self.finger, self.options, name=name)


@cache
def _moment(name: str, place: int, edits: Edits) -> Moment:
    text = export_scene(name)
    for old, new in edits:
        assert old in text, f"{old!r} is not in the scene {name}"
        text = text.replace(old, new)
    scene = parse_scene(text)
    configs = [each for each in scene.gaits["default"] if not isinstance(each, RelocationPhase)]
    if place == 0:
        nothing = Grasp(scene.rest_rotation, MappingProxyType({}))
        return Moment(Setting.of(scene), nothing, configs[0])
    before = _moment(name, place - 1, edits)
    return Moment(before.setting, _planned(name, place - 1, edits)[1], configs[place])


@cache
def _planned(name: str, place: int, edits: Edits) -> tuple[Phase, Grasp]:
    return _moment(name, place, edits).plan()


@cache
def _solved(name: str, place: int, solver: RemovalSolver, doubling: bool) -> RemovalSolution:
    return solve_with(_moment(name, place, ()).problem, solver, doubling=doubling)


@pytest.fixture(scope="session")
def moment() -> Callable[..., Moment]:
    """A scene's gait before the phase at a place: ``moment("knife", 2, ("old", "new"))``.

    Places count the phases in which the tool feels something: no relocations.
    """
    return lambda name, place, *edits: _moment(name, place, edits)


@pytest.fixture(scope="session")
def planned() -> Callable[..., tuple[Phase, Grasp]]:
    """That phase and the grasp it ends in; each is planned once."""
    return lambda name, place, *edits: _planned(name, place, edits)


@pytest.fixture(scope="session")
def solved() -> Callable[..., RemovalSolution]:
    """Solution of a removal: ``solved("knife", 2, "ipopt")``; each is computed once."""
    return lambda name, place, solver, doubling=False: _solved(name, place, solver, doubling)


@pytest.fixture(scope="session")
def assert_laws() -> Callable[[Moment, Phase], None]:
    """Every phase: dynamics (3), exact cones (5), bounds (6), pivot and start where they were."""
    return _assert_laws


def _assert_laws(before: Moment, phase: Phase) -> None:
    setting, motion, scene = before.setting, phase.tool, before.setting.scene
    tracks = list(phase.contacts.values())
    force = np.stack([track.force for track in tracks], axis=1)
    normal = np.stack([track.world_normal(motion) for track in tracks], axis=1)
    point = np.stack([track.world_point(motion) for track in tracks], axis=1)
    g = grasp_map(point - motion.position[:, None])
    miss = np.einsum("nij,nj->ni", g, force.reshape(len(force), -1))
    miss -= required_wrench(setting.body, motion)
    # a hundredth to a thousandth of what the certificate allows (1e-6 N, 1e-7 N m)
    np.testing.assert_allclose(miss, 0.0, atol=1e-9)
    friction = np.array([track.friction for track in tracks])
    usable = (1.0 - scene.allocation.friction_reserve) * friction
    # the certificate's limits: 1e-8 N beyond the cone or the bounds
    assert cone_margin(force, normal, usable).min() >= -1e-8
    along = np.sum(force * normal, axis=-1)
    for place, track in enumerate(tracks):
        assert along[:, place].min() >= track.normal_min - 1e-8
        assert along[:, place].max() <= track.normal_max + 1e-8
    pivot = motion.position + motion.rotation.as_matrix() @ setting.body.pivot_in_tool
    np.testing.assert_allclose(pivot, np.tile(scene.pivot, (len(pivot), 1)), atol=1e-14)
    turn = before.grasp.rotation.inv() * motion.rotation[0]
    assert turn.magnitude() < 1e-12
    for speed in (motion.angular_velocity, motion.linear_velocity, motion.angular_acceleration):
        np.testing.assert_allclose(speed[[0, -1]], 0.0, atol=1e-12)
    for name, held in before.grasp.forces.items():
        # seams: a thousandth of the certificate's 1e-6 N
        np.testing.assert_allclose(phase.contacts[name].force[0], held, atol=1e-9)
