"""The gait that ``tests/plotting`` draws, and pictures that cost nothing."""

import zlib

import pytest

from pivotgait.reporting import Picture
from pivotgait.validation import Metrics, Verdict
from pivotgait.validation.record_reading import RecordedRun
from tests.plotting.knife_gait import knife_plan, motion_of, with_robot


@pytest.fixture(scope="session")
def plan():
    return knife_plan()


@pytest.fixture(scope="session")
def robot_plan(plan):
    return with_robot(plan)


@pytest.fixture(scope="session")
def motion(robot_plan):
    return motion_of(robot_plan)


@pytest.fixture
def run(motion):
    metrics = Metrics(0.04, 0.3, 1.5, 0.31, 3.5, 0.4)
    return RecordedRun("pybullet", "hybrid", Verdict(passed=True), metrics, motion)


@pytest.fixture
def certificate():
    return {
        "valid": True,
        "residuals": {"force_balance_n": 3.2e-9, "cone_margin_n": 0.012},
        "tolerances": {"force_balance_n": 1e-6, "cone_margin_n": -1e-8},
        "worst": {"force_balance_n": {"phase": "03_removal", "contact": "", "time_s": 0.5}},
        "violations": [],
    }


@pytest.fixture(scope="session")
def dot():
    """A PNG of one pixel."""

    def chunk(kind, data):
        check = zlib.crc32(kind + data).to_bytes(4, "big")
        return len(data).to_bytes(4, "big") + kind + data + check

    header = (1).to_bytes(4, "big") * 2 + bytes([8, 0, 0, 0, 0])
    pixels = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0\0"))
    return b"\x89PNG\r\n\x1a\n" + pixels + chunk(b"IEND", b"")


@pytest.fixture
def figures():
    svg = b'<?xml version="1.0"?><svg xmlns="http://www.w3.org/2000/svg"/>'
    return {
        "hero": Picture(b"\x89PNG hero", alt="the knife", caption="Look.", narrow=b"RIFF narrow"),
        "overview": Picture(svg, alt="curves", caption="Over time."),
        "lift": Picture(svg, alt="the lift", caption="Up.", phase="00_lift"),
    }
