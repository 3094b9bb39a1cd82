"""The command line: names, options and help of the commands."""

from pivotgait.cli.application import app
from pivotgait.cli.entry import main

__all__ = ["app", "main"]
