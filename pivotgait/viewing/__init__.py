"""A plan as an animated scene: in a browser, or in one HTML file that needs no network."""

from pivotgait.viewing.frames import Frames, frames
from pivotgait.viewing.html import view_html, write_view
from pivotgait.viewing.scene import GaitScene
from pivotgait.viewing.server import HOST, Player, free_port, quiet_server

__all__ = [
    "HOST",
    "Frames",
    "GaitScene",
    "Player",
    "frames",
    "free_port",
    "quiet_server",
    "view_html",
    "write_view",
]
