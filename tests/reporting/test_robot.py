"""What the report says of an arm-hand, and that a plan without one says nothing of it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from pivotgait.margins import largest_share
from pivotgait.plotting.posture import skeleton
from pivotgait.reporting import Picture, render_report
from pivotgait.reporting.figures import draw_figures
from pivotgait.reporting.robot_rows import clearance, robot_headline, robot_rows
from pivotgait.reporting.rows import violation_rows
from pivotgait.reporting.summary import PhaseSummary


@pytest.fixture
def certified(certificate):
    return {
        **certificate,
        "residuals": {**certificate["residuals"], "hand_clearance_m": 0.00234},
        "tolerances": {**certificate["tolerances"], "hand_clearance_m": 0.001},
        "worst": {**certificate["worst"], "hand_clearance_m": {"phase": "03_removal"}},
    }


def words(text):
    plain = re.sub(r"<[^>]+>", " ", text.replace("\N{NO-BREAK SPACE}", " "))
    return " ".join(plain.split())


def test_rows_tell_each_phases_largest_shares(robot_plan):
    for row, phase in zip(robot_rows(robot_plan), robot_plan.phases, strict=True):
        assert row.name == phase.name
        for kind in ("torque", "speed", "range"):
            found = largest_share(robot_plan, kind, phase=phase.name)
            text = getattr(row, kind).replace("\N{NO-BREAK SPACE}", " ").removesuffix(" %")
            assert float(text) == pytest.approx(100 * found.value, rel=6e-3)
            assert getattr(row, f"{kind}_joint") == found.joint


def test_only_a_relocation_has_a_path_and_it_is_as_seen_from_the_tool(robot_plan):
    rows = {row.name: row.path for row in robot_rows(robot_plan)}
    assert rows["00_lift"] == rows["03_removal"] == "–"
    phase = robot_plan.phases[1]
    tip = skeleton(robot_plan.robot).poses(phase.robot.q)["mftip"][:, :3, 3]
    # the tool rests in this phase, so the path in the world is as long
    wanted = 1e3 * np.linalg.norm(np.diff(tip, axis=0), axis=1).sum()
    told = float(rows["01_relocation"].replace("\N{NO-BREAK SPACE}", " ").removesuffix(" mm"))
    assert told == pytest.approx(wanted, rel=6e-3)


def test_clearance_stands_beside_its_limit(certified, certificate):
    found = clearance(certified)
    assert words(found.value) == "2.34 mm"
    assert words(found.limit) == "limit ≥ 1 mm, 03_removal"
    assert clearance(certificate).value == "–"


def test_a_violation_of_the_robot_names_its_part(certificate):
    place = {"phase": "03_removal", "contact": "", "time_s": 0.5, "part": "WRJ1"}
    broken = {"what": "joint_speed", "value": 1.2, "limit": 1.0, **place}
    (row,) = violation_rows({**certificate, "violations": [broken]})
    assert words(row.where) == "03_removal, WRJ1, 0.5 s"


def test_the_page_tells_the_arm_and_hand(robot_plan, certified, figures):
    figures["joint_torques"] = Picture(b"\x89PNG", alt="torques", caption="Torques.", robot=True)
    text = words(render_report(robot_plan, certified, figures))
    assert f"Arm and hand: {words(robot_headline(robot_plan, certified))}" in text
    assert "clearance 2.34 mm" in text
    assert text.index("Phases") < text.index("Arm and hand") < text.index("Joints over time")
    over_time = text[text.index("Joints over time") : text.index("Forces, margins")]
    assert "Torques." in over_time


def test_a_plan_without_a_robot_says_nothing_of_one(plan, certificate, figures):
    text = render_report(plan, certificate, figures)
    assert "Arm and hand" not in text
    assert "Joints over time" not in text
    assert robot_rows(plan) == ()
    assert robot_headline(plan, certificate) == ""


def test_a_relocation_is_reported_with_its_search_and_its_path():
    found = {
        "name": "01_relocation",
        "solver": "RRT",
        "iterations": 812,
        "nodes": 340,
        "length_found_m": 0.42,
        "length_m": 0.21,
    }
    note = words(PhaseSummary.model_validate(found).note)
    for part in ("RRT", "812 samples", "340 nodes", "420 mm", "210 mm"):
        assert part in note


@pytest.mark.parametrize("view", ["", "view.html"])
def test_the_animated_scene_is_linked_if_it_is_there(view, plan, certificate, figures):
    text = render_report(plan, certificate, figures, view=view)
    assert re.findall('href="([^"]*)"', text) == ([view] if view else [])


@pytest.mark.slow
def test_figures_of_the_robot_are_drawn_and_described(robot_plan, tmp_path):
    short = replace(robot_plan, phases=robot_plan.phases[:1])
    pictures = draw_figures(short, tmp_path)
    names = {name for name, picture in pictures.items() if picture.robot}
    assert names == {"robot_scene", "joint_positions", "joint_speeds", "joint_torques"}
    assert "hand" in pictures["hero"].alt
    for name in names:
        assert pictures[name].alt
        assert (tmp_path / f"{name}.pdf").is_file()
