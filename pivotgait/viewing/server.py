"""The animated scene in a browser: a local server with a player."""

from __future__ import annotations

import io
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING, Any

from pivotgait.exceptions import InputError
from pivotgait.plans.plan import GaitPlan
from pivotgait.viewing.frames import frames
from pivotgait.viewing.scene import GaitScene

if TYPE_CHECKING:
    from viser import GuiEvent, ViserServer

HOST = "127.0.0.1"
"""Only this computer sees the scene."""
_SPEEDS = ("0.1x", "0.25x", "0.5x", "1x", "2x")
_PAUSE_AT_END_S = 1.0


def free_port(port: int = 0, *, or_any: bool = False) -> int:
    """``port`` if a server can listen there; 0 lets the system choose one.

    Args:
        port: 0 to 65535.
        or_any: choose another if ``port`` cannot be used.

    Raises:
        InputError: if it cannot be used.
    """
    with socket.socket() as probe:
        # as the server does it: a port that a closed connection lingers on counts as free
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as error:
            if or_any:
                return free_port()
            raise InputError(
                f"port {port} cannot be used: {error.strerror}",
                where="--port",
                mend="give another, or none",
            ) from error
        found: int = probe.getsockname()[1]
    return found


@contextmanager
def quiet_server(port: int = 0) -> Iterator[ViserServer]:
    """A viser server that prints nothing; it ends with the context.

    Raises:
        InputError: if ``port`` cannot be used.
    """
    port = free_port(port)  # viser itself would silently take the next one
    import viser

    # viser has no switch for the table and the farewell that it prints
    with redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=HOST, port=port, verbose=False)
    try:
        yield server
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


class Player:
    """Time, speed and phase of a gait in a browser's panel.

    Args:
        server: a viser server.
        plan: the gait.
    """

    def __init__(self, server: ViserServer, plan: GaitPlan) -> None:
        self._server = server
        self._moments = frames(plan)
        self._scene = GaitScene(server.scene, plan, self._moments)
        self._scene.aim(server)
        self._playing, self._hold = True, 0.0
        self._lock = threading.Lock()  # the clock and the browser come from two threads
        gui = server.gui
        gui.set_panel_label(f"{plan.tool.name}: finger gait")
        gui.configure_theme(show_logo=False, show_share_button=False)
        self._text = gui.add_markdown("")
        last = float(self._moments.time[-1])
        self._time: Any = gui.add_slider("time [s]", 0.0, last, 0.01, 0.0)
        self._button = gui.add_button("Pause")
        self._speed = gui.add_dropdown("speed", _SPEEDS, initial_value="1x")
        self._titles = [self._scene.title(number) for number in range(len(self._moments.spans))]
        self._phase: Any = gui.add_dropdown("phase", self._titles)
        self._time.on_update(self._moved)
        self._button.on_click(lambda _: self.toggle())
        self._phase.on_update(self._chosen)
        self._show()

    @property
    def time(self) -> float:
        """Seconds from the start of the gait."""
        return float(self._time.value)

    @property
    def caption(self) -> str:
        """What the panel says of the moment shown."""
        return str(self._text.content)

    def advance(self, elapsed: float) -> None:
        """Let ``elapsed`` seconds of a clock pass; at the end, rest a moment and begin again."""
        if not self._playing:
            return
        last = float(self._moments.time[-1])
        now = self.time + elapsed * float(self._speed.value.rstrip("x"))
        if self.time < last:
            self._time.value, self._hold = min(now, last), 0.0
        elif self._hold < _PAUSE_AT_END_S:
            self._hold += elapsed
        else:
            self._time.value = 0.0

    def run(self) -> None:
        """Play until interrupted."""
        before = time.monotonic()
        while True:
            time.sleep(1.0 / 30.0)
            now = time.monotonic()
            self.advance(now - before)
            before = now

    def toggle(self) -> None:
        """Pause or go on."""
        self._playing = not self._playing
        self._button.label = "Pause" if self._playing else "Play"

    def _moved(self, event: GuiEvent[Any]) -> None:
        if event.client is not None and self._playing:  # a hand on the slider, not the clock
            self.toggle()
        self._show()

    def jump(self, number: int) -> None:
        """Go to the start of the phase with a number, counted from 0."""
        self._time.value = float(self._moments.spans[number].start)

    def _chosen(self, event: GuiEvent[Any]) -> None:
        if event.client is not None:  # the field also follows the clock
            self.jump(self._titles.index(self._phase.value))

    def _show(self) -> None:
        now = self.time
        frame = self._moments.at(now)
        with self._lock, self._server.atomic():
            self._scene.show(frame)
        self._phase.value = self._scene.caption(frame)
        self._text.content = f"**{self._scene.caption(frame)}**, {now:.2f} s"
