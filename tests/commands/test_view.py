"""``pivotgait view``: a file or a server, and one clear line where that cannot be."""

from __future__ import annotations

import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pivotgait.viewing import HOST, Player

Call = Callable[..., Any]


def test_html_is_written_and_told(call: Call, small_run: Path, tmp_path: Path) -> None:
    path = tmp_path / "wrench.html"
    answer = call("view", small_run / "plan.h5", "--html", path)
    assert answer.code == 0
    assert "wrench.html" in answer.out
    assert path.read_text(encoding="utf-8").rstrip().endswith("</html>")


def test_json_tells_the_file_and_its_size(call: Call, small_run: Path, tmp_path: Path) -> None:
    path = tmp_path / "wrench.html"
    data = call("view", small_run / "plan.h5", "--html", path, "--json").data
    assert data == {"html": str(path), "bytes": path.stat().st_size}


def test_a_run_leaves_the_view_and_its_report_links_it(small_run: Path) -> None:
    assert (small_run / "view.html").is_file()
    assert 'href="view.html"' in (small_run / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_without_a_view_an_old_one_does_not_stay(
    call: Call, small_scene: Path, tmp_path: Path
) -> None:
    (tmp_path / "view.html").write_text("of another plan")
    assert call("run", small_scene, "--out", tmp_path, "--no-view").code == 0
    assert not (tmp_path / "view.html").exists()
    assert "view.html" not in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("browse", [True, False])
def test_a_server_plays_until_interrupted(
    call: Call, small_run: Path, monkeypatch: pytest.MonkeyPatch, browse: bool
) -> None:
    opened: list[str] = []

    def interrupt(_: Player) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Player, "run", interrupt)
    monkeypatch.setattr("webbrowser.open", opened.append)
    answer = call("view", small_run / "plan.h5", "--open" if browse else "--no-open")
    assert answer.code == 0
    assert f"http://{HOST}:" in answer.out
    assert [url in answer.out for url in opened] == [True] * browse


def test_a_port_in_use_is_bad_input(call: Call, small_run: Path) -> None:
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        answer = call("view", small_run / "plan.h5", "--no-open", "--port", port)
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert str(port) in answer.err


@pytest.mark.parametrize("port", ["0", "65536", "-1", "http"])
def test_a_port_that_is_none_is_bad_input(call: Call, small_run: Path, port: str) -> None:
    answer = call("view", small_run / "plan.h5", "--no-open", "--port", port)
    assert answer.code == 2
    assert answer.err.count("\n") == 1


@pytest.mark.parametrize("content", [None, b"", b"this is no HDF5 file\n"])
def test_a_plan_that_cannot_be_read_is_bad_input(
    call: Call, tmp_path: Path, content: bytes | None
) -> None:
    plan, html = tmp_path / "plan.h5", tmp_path / "view.html"
    if content is not None:
        plan.write_bytes(content)
    answer = call("view", plan, "--html", html)
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert "plan.h5" in answer.err
    assert not html.exists()


def test_a_folder_that_is_missing_is_bad_input(call: Call, small_run: Path, tmp_path: Path) -> None:
    answer = call("view", small_run / "plan.h5", "--html", tmp_path / "none" / "view.html")
    assert answer.code == 2
    assert "does not exist" in answer.err
