"""Margins off the table: closed forms of two fingers, edges of random grasps, whole transfers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.exceptions import InfeasibleError
from pivotgait.feasibility import Variants, judge, rehearse
from pivotgait.feasibility.carried import CarriedMoments, carried_margins, carried_moments
from pivotgait.forces.soft_finger import SoftFingerProblem, allocate_soft
from pivotgait.forces.soft_range import SoftFingerRange
from pivotgait.models import load_scene
from pivotgait.phases.grasp import Setting

WEIGHT, MU, TORSION, LARGEST = 1.0, 0.6, 4e-3, 3.0
OFFSETS = (0.0, 0.002, 0.006, 0.012)


def opposed(offset: float, *, torsion: float = TORSION) -> SoftFingerProblem:
    """Two fingers along y that carry a weight ``offset`` [m] beside the line through them."""
    return SoftFingerProblem(
        names=("thumb", "index"),
        lever=np.array([[[-offset, -0.01, 0.0], [-offset, 0.01, 0.0]]]),
        normals=np.array([[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]]),
        friction=np.full(2, MU),
        torsion=np.full(2, torsion),
        normal_min=np.full(2, 0.1),
        normal_max=np.full(2, LARGEST),
        wrench=np.array([[0.0, 0.0, WEIGHT, 0.0, 0.0, 0.0]]),
        start=np.zeros((2, 3)),
        force_rate_max=1e6,
        step_s=1.0,
    )


def margins(problem: SoftFingerProblem) -> dict[str, float]:
    force = 1.0 * problem.normals  # its normal part alone counts, for the share of sensing
    found = carried_margins(CarriedMoments("transfer", np.zeros(1), problem, force))
    return {name: float(value[0]) for name, value in vars(found).items()}


@pytest.mark.parametrize("offset", OFFSETS)
def test_two_opposed_fingers(offset):
    """Each bears half the weight and half its moment; both at the largest normal force."""
    found = margins(opposed(offset))
    pull = 0.5 * WEIGHT / (MU * LARGEST)
    twist = 0.5 * WEIGHT * offset / (TORSION * LARGEST)
    used = float(np.hypot(pull, twist))
    assert found["friction_drop"] == pytest.approx(1.0 - used, abs=1e-3)
    assert found["finger_friction_drop"] == found["friction_drop"]
    if used <= 1.0:
        assert found["mass_increase"] == pytest.approx(min(1.0 / used, 10.0) - 1.0, abs=1e-4)
        assert found["mass_decrease"] == pytest.approx(1.0, abs=1e-6)
    else:
        assert np.isnan(found["mass_increase"])
    if offset > 0.0:
        least = twist / np.sqrt(1.0 - pull**2)
        assert found["torsion_drop"] == pytest.approx(1.0 - least, abs=1e-3)
    for name in ("table_friction_drop", "lift_off_N", "torque_drop"):
        assert np.isnan(found[name])


def test_points_bear_no_moment_about_their_line():
    on_line, beside = margins(opposed(0.0, torsion=0.0)), margins(opposed(1e-3, torsion=0.0))
    assert on_line["friction_drop"] == pytest.approx(1.0 - 0.5 * WEIGHT / (MU * LARGEST), abs=1e-3)
    assert beside["friction_drop"] == -np.inf
    assert np.isnan(beside["mass_increase"])
    assert np.isnan(beside["sensing_share"])


def test_a_finger_presses_between_what_carries_and_its_bound():
    used = np.hypot(0.5 * WEIGHT / MU, 0.5 * WEIGHT * 0.002 / TORSION)
    low, high = SoftFingerRange(opposed(0.002), 0).normal(0)
    assert (low, high) == (pytest.approx(used, abs=1e-6), pytest.approx(LARGEST, abs=1e-6))


def held(problem: SoftFingerProblem) -> bool:
    """By the planner's own program, whose first sample is given."""
    twice = {
        name: np.repeat(getattr(problem, name), 2, axis=0)
        for name in ("lever", "normals", "wrench")
    }
    try:
        allocate_soft(replace(problem, **twice))
    except InfeasibleError:
        return False
    return True


@pytest.mark.parametrize("seed", range(8))
def test_the_planners_program_agrees_at_every_edge(seed):
    rng = np.random.default_rng(seed)
    around = 2.0 * np.pi * (np.arange(3) / 3.0 + 0.05 * rng.normal(size=3))
    inward = -np.stack((np.zeros(3), np.cos(around), np.sin(around)), axis=-1)
    lever = -0.015 * inward
    lever[:, 0] = rng.uniform(-0.02, 0.02, 3)
    problem = replace(
        opposed(0.0),
        names=("thumb", "index", "middle"),
        lever=lever[None],
        normals=inward[None],
        friction=rng.uniform(0.4, 0.9, 3),
        torsion=rng.uniform(1e-3, 5e-3, 3),
        normal_min=np.full(3, 0.1),
        normal_max=np.full(3, 4.0),
        wrench=np.append([0.1, 0.0, 1.5], 0.003 * rng.normal(size=3))[None],
        start=np.zeros((3, 3)),
    )
    found = margins(problem)
    edges = {
        "friction_drop": lambda s: replace(
            problem, friction=s * problem.friction, torsion=s * problem.torsion
        ),
        "torsion_drop": lambda s: replace(problem, torsion=s * problem.torsion),
    }
    for name, at in edges.items():
        edge = 1.0 - found[name]
        if 1e-2 < edge < 30.0:
            assert held(at(1.005 * edge))
            assert not held(at(0.995 * edge))
    assert held(problem) == (found["friction_drop"] >= 0.0)
    if held(problem) and found["mass_increase"] < 8.9:
        load = 1.0 + found["mass_increase"]
        assert held(replace(problem, wrench=0.999 * load * problem.wrench))
        assert not held(replace(problem, wrench=1.001 * load * problem.wrench))


@pytest.fixture(scope="module")
def screwdriver():
    return load_scene("screwdriver")


def test_a_planned_transfer_keeps_its_reserve(screwdriver):
    phase = rehearse(screwdriver, screwdriver.gaits["default"]).phases[-1]
    assert phase.kind == "transfer"
    moments = carried_moments(phase, Setting.of(screwdriver).body)
    found = carried_margins(moments)
    assert np.all(found.friction_drop >= screwdriver.allocation.friction_reserve - 1e-3)
    assert np.all(found.torsion_drop >= found.friction_drop - 1e-3)
    # the plan's own forces are those it says, and bear the load
    normals = moments.problem.normals
    pressing = np.sum(moments.force * normals, axis=2)
    assert np.all(pressing >= moments.problem.normal_min - 1e-6)


def test_the_verdict_counts_the_transfer(screwdriver):
    found = judge(Variants(screwdriver)).margins
    here = next(values for name, values in found.by_phase.items() if "transfer" in name)
    assert here["friction_drop"] is not None
    assert here["wrench_ball_N"] is here["lift_off_N"] is here["torque_drop"] is None
    assert found.robust["torsion_drop"].value == here["torsion_drop"]
    # what a transfer has not, the other phases have
    assert found.robust["lift_off_N"].value is not None
    assert found.robust["table_friction_drop"].value is not None
