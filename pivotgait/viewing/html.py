"""The animated scene as one HTML file: viser's client with a recording inside it."""

from __future__ import annotations

import html
import math
import re
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from pivotgait.atomic import write_atomically
from pivotgait.exceptions import InputError
from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.timeline import phase_title
from pivotgait.viewing.frames import RATE_HZ, Frames, frames
from pivotgait.viewing.scene import GaitScene
from pivotgait.viewing.server import quiet_server


def view_html(plan: GaitPlan, rate: float = RATE_HZ) -> str:
    """The whole page: animation, player and 3D view; it loads nothing.

    Args:
        plan: a gait.
        rate: frames per second [Hz].

    Raises:
        InputError: if ``rate`` is not positive, or a phase lacks the robot's motion.
        UrdfError: if a URDF of the plan is broken.
    """
    moments = frames(plan, rate)
    with quiet_server() as server:
        scene = GaitScene(server.scene, plan, moments)
        scene.aim(server)
        recording = server.get_scene_serializer()
        step = float(moments.time[1] - moments.time[0])
        for frame in range(len(moments)):
            scene.show(frame)
            recording.insert_sleep(step)
        page = recording.as_html()
    return _with_phases(page, plan, moments)


def write_view(plan: GaitPlan, path: Path, rate: float = RATE_HZ) -> Path:
    """Write :func:`view_html` to ``path``, whole or not at all, and return it.

    Raises:
        InputError: if the file cannot be written.
    """
    page = view_html(plan, rate)
    try:
        write_atomically(page.encode(), path)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror}", where=str(path), mend="give another path"
        ) from error
    return path


def _with_phases(page: str, plan: GaitPlan, moments: Frames) -> str:
    """The client's page with the tool's name and a strip of phases to jump to."""
    environment = Environment(
        loader=PackageLoader("pivotgait", "viewing"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    step = float(moments.time[1] - moments.time[0])
    strip = environment.get_template("phase_strip.html.j2").render(
        title=plan.tool.name,
        phases=[
            {
                "title": phase_title(span.phase),
                "start": f"{span.start:.3f}",
                # the player's field holds tenths of a second: the first after a frame of the phase
                "jump": f"{math.ceil(10 * (span.start + step)) / 10:.1f}",
            }
            for span in moments.spans
        ],
    )
    title = f"<title>{html.escape(plan.tool.name)}: finger gait</title>"
    page = re.sub("<title>.*?</title>", lambda _: title, page, count=1)
    end = page.rindex("</body>")
    return page[:end] + strip + page[end:]
