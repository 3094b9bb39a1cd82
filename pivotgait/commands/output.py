"""Where commands write: one JSON object or tables on stdout, progress and logs on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table


class Output:
    """A command's voice.

    Args:
        json_output: print one JSON object on stdout and nothing else there.
    """

    def __init__(self, json_output: bool) -> None:
        self.json = json_output
        self.out = Console(soft_wrap=True, highlight=False)
        self.log = Console(stderr=True, highlight=False)

    def emit(self, data: dict[str, Any]) -> None:
        """Print the command's result as JSON, if that was asked for."""
        if self.json:
            json.dump(data, sys.stdout, indent=2, allow_nan=False)
            sys.stdout.write("\n")

    def say(self, text: str) -> None:
        """Print a line for people (not with ``--json``); escape what is not markup in it."""
        if not self.json:
            self.out.print(text)

    def table(
        self, title: str, columns: Sequence[tuple[str, str]], rows: Iterable[Sequence[str]]
    ) -> None:
        """Print a table for people; columns are (heading, ``left`` or ``right``).

        Cells may hold markup: escape what comes from files.
        """
        if self.json:
            return
        table = Table(
            title=escape(title),
            title_justify="left",
            header_style="bold",
            box=box.SIMPLE_HEAD,
            padding=(0, 1, 0, 0),
        )
        for heading, side in columns:
            # what is read from the right (numbers) must not be cut
            right = side == "right"
            table.add_column(
                escape(heading),
                justify="right" if right else "left",
                no_wrap=right,
                overflow="fold",
            )
        for row in rows:
            table.add_row(*row)
        self.out.print(table)

    @contextmanager
    def progress(self, text: str, total: int | None) -> Iterator[Progress]:
        """A progress bar on stderr with one task, advanced by ``advance(task_id)``.

        Without a total the bar only moves, while ``update`` tells what is being done.
        """
        columns = (
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TextColumn("" if total is None else "{task.completed}/{task.total}"),
            TimeElapsedColumn(),
        )
        silent = not self.log.is_terminal  # a log file gets no bar, not even its empty line
        with Progress(*columns, console=self.log, transient=True, disable=silent) as bar:
            bar.add_task(text, total=total)
            yield bar


def verdict(good: bool, yes: str, no: str) -> str:
    """A coloured word."""
    return f"[bold green]{yes}[/]" if good else f"[bold red]{no}[/]"
