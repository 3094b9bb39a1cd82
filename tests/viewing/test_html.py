"""The page with the animation: whole, offline, and it plays."""

import re
import shutil
import subprocess
from dataclasses import replace

import pytest

from pivotgait.exceptions import InputError
from pivotgait.viewing import view_html, write_view

BROWSER = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")


@pytest.fixture(scope="module")
def page(robot_plan):
    return view_html(robot_plan)


def test_it_loads_nothing(page):
    tags = re.findall(r"<(?:script|link|img|iframe|source|video|audio)\b[^>]*>", page)
    for tag in tags:
        for target in re.findall(r"(?:src|href)\s*=\s*[\"']?([^\"'\s>]+)", tag):
            assert target.startswith("data:"), tag
    assert not re.search(r"@import|url\(\s*[\"']?https?:", page)


def test_it_is_small_enough_to_mail(page):
    assert len(page) < 3_000_000


def test_phases_are_named_with_their_start(page):
    starts = re.findall(r'data-start="([\d.]+)" data-jump="([\d.]+)">([^<]+)<', page)
    assert [(float(start), title) for start, _, title in starts] == [
        (0.0, "lift"), (0.8, "relocation middle"), (1.3, "addition middle"), (1.7, "removal index")
    ]  # fmt: skip
    for start, jump, _ in starts:
        assert 0.0 <= float(jump) - float(start) < 0.15


def test_hostile_names_are_only_text(plan):
    nasty = '</title><script>alert("1")</script>\\1'
    page = view_html(replace(plan, tool=replace(plan.tool, name=nasty)), 5.0)
    assert nasty not in page
    assert "&lt;/title&gt;" in page


def test_it_is_written_whole_or_not_at_all(plan, tmp_path, monkeypatch):
    path = write_view(plan, tmp_path / "view.html", 5.0)
    old = path.read_bytes()
    assert old.rstrip().endswith(b"</html>")

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pivotgait.atomic.os.fsync", full)
    with pytest.raises(InputError, match="No space left"):
        write_view(plan, path, 5.0)
    assert [entry.name for entry in tmp_path.iterdir()] == ["view.html"]
    assert path.read_bytes() == old


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="needs a Chromium")
def test_a_browser_plays_it_and_follows_the_phases(page, tmp_path):
    path = tmp_path / "view.html"
    path.write_text(page)
    run = subprocess.run(
        [
            BROWSER, "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader", f"--user-data-dir={tmp_path / 'profile'}",
            "--virtual-time-budget=4000", "--dump-dom", path.as_uri(),
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    strip = run.stdout[run.stdout.index('<nav id="phase-strip"') :]
    assert strip.count('aria-current="true"') == 1
    assert "<canvas" in run.stdout
