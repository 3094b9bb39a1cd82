"""``view``: a plan as an animated scene, in a browser or as one HTML file."""

from __future__ import annotations

import webbrowser
from pathlib import Path

from rich.markup import escape

from pivotgait.commands.output import Output
from pivotgait.commands.planning import writable
from pivotgait.plans import GaitPlan, read_plan

DEFAULT_PORT = 8080


def run_view(path: Path, html: Path | None, port: int | None, browse: bool, out: Output) -> int:
    """Show a plan until interrupted, or write it as an HTML file; returns the exit code."""
    if html is not None:
        writable(html)
    plan = read_plan(path)
    if html is None:
        return _serve(plan, port, browse, out)
    from pivotgait.viewing import write_view

    with out.progress("recording the scene", 1) as bar:
        write_view(plan, html)
        bar.advance(bar.task_ids[0])
    out.say(f"view: {escape(str(html))}")
    out.emit({"html": str(html), "bytes": html.stat().st_size})
    return 0


def _serve(plan: GaitPlan, port: int | None, browse: bool, out: Output) -> int:
    from pivotgait.viewing import HOST, Player, free_port, quiet_server

    chosen = free_port(DEFAULT_PORT, or_any=True) if port is None else free_port(port)
    with quiet_server(chosen) as server:
        player = Player(server, plan)
        url = f"http://{HOST}:{server.get_port()}"
        out.say(f"{escape(plan.tool.name)}: {url} (Ctrl-C ends)")
        out.emit({"url": url})
        if browse:
            webbrowser.open(url)
        try:
            player.run()
        except KeyboardInterrupt:
            out.say("stopped")  # the way to end it, no failure
    return 0
