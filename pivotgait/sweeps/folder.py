"""The folder of a sweep: what it is of, and one file for each part that is done.

``sweep.json`` says what the sweep is; ``parts/NNNNNN.parquet`` holds results, and
``timings/NNNNNN.parquet`` how long they took. A part is done when its file is there: files appear
whole or not at all, so that a sweep can be killed at any moment and go on.
"""

from __future__ import annotations

import fcntl
import json
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import IO, Any

from pivotgait import __version__
from pivotgait.atomic import write_atomically
from pivotgait.gaits.planner import PACKAGES
from pivotgait.sweeps.errors import SweepFolderError
from pivotgait.sweeps.part_files import PartImage, read_summary
from pivotgait.sweeps.parts import Parts
from pivotgait.sweeps.study import Study

SCHEMA = "pivotgait-sweep/1"
MANIFEST = "sweep.json"
PARTS, TIMINGS = "parts", "timings"
_LOCK = ".lock"


def file_name(part: int) -> str:
    """Name of a part's files; names sort as parts do."""
    return f"{part:06d}.parquet"


@dataclass(frozen=True, eq=False)
class SweepFolder:
    """A folder whose lock this process holds.

    Attributes:
        path: of the folder.
        parts: how the sweep is cut.
        done: numbers of the parts that were there when it was opened.
        counts: number of cells in them by status; ``feasible`` counts those too.
    """

    path: Path
    parts: Parts
    done: frozenset[int]
    counts: Counter[str]

    @property
    def done_cells(self) -> int:
        """Number of cells that were there."""
        return sum(len(self.parts.numbers(part)) for part in self.done)

    def missing(self) -> Iterator[int]:
        """Numbers of the parts to do, in order."""
        return (part for part in range(self.parts.count) if part not in self.done)

    def write(self, image: PartImage) -> None:
        """Keep a part; from the moment its results are in place it is done.

        Raises:
            SweepFolderError: it cannot be written.
        """
        name = file_name(image.summary.part)
        try:
            write_atomically(image.timings, self.path / TIMINGS / name)
            write_atomically(image.results, self.path / PARTS / name)
        except OSError as error:
            what, mend = f"cannot be written to: {error}", "the sweep can go on from here later"
            raise SweepFolderError(what, where=_short(self.path), mend=mend) from error


@contextmanager
def open_folder(path: Path, study: Study) -> Iterator[SweepFolder]:
    """Begin a sweep in a folder, or go on with it.

    Raises:
        SweepFolderError: the folder holds something else, another study's results, those of
            other versions, or another process is at it.
    """
    lock = _prepared(path, manifest_of(study))
    with lock:
        yield _found(path, study)


def _prepared(path: Path, manifest: dict[str, Any]) -> IO[str]:
    """The open file that locks the folder, which now says what it is of."""
    check_folder(path, manifest)
    with _usable(path):
        for each in (path, path / PARTS, path / TIMINGS):
            each.mkdir(parents=True, exist_ok=True)
        lock = (path / _LOCK).open("w")
        _acquire(lock, path)
        check_folder(path, manifest)  # again: someone may have been here before the lock was ours
        _remove_partial(path)
        if not (path / MANIFEST).exists():
            text = json.dumps(manifest, indent=1) + "\n"
            write_atomically(text.encode(), path / MANIFEST)
    return lock


@contextmanager
def _usable(path: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as error:
        what, mend = f"cannot be used: {error}", "give another folder"
        raise SweepFolderError(what, where=_short(path), mend=mend) from error


def _acquire(lock: IO[str], path: Path) -> None:
    """Take the lock; the system lets go of it when this process ends, however it ends."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        lock.close()
        what, mend = "another sweep is at work here", "wait for it, or end it"
        raise SweepFolderError(what, where=_short(path), mend=mend) from error


def manifest_of(study: Study) -> dict[str, Any]:
    """What ``sweep.json`` says: study, scene, versions, columns' meaning by schema."""
    parts = Parts.of(study)
    return {
        "schema": SCHEMA,
        "study": study.config.model_dump(mode="json", by_alias=True),
        "scene": study.scene_text,
        "digest": study.digest,
        "cells": parts.cells,
        "part_cells": parts.size,
        "parts": parts.count,
        "versions": {"pivotgait": __version__, **{name: version(name) for name in PACKAGES}},
    }


def read_manifest(path: Path) -> dict[str, Any]:
    """What a sweep's folder says it is of.

    Raises:
        SweepFolderError: it is no sweep's folder.
    """
    try:
        found = json.loads((path / MANIFEST).read_text(encoding="utf-8"))
        if found["schema"] != SCHEMA:
            what, mend = f"has schema {found['schema']!r}", f"this version reads {SCHEMA}"
            raise SweepFolderError(what, where=_short(path), mend=mend)
    except (OSError, ValueError, TypeError, KeyError) as error:
        mend = "give the folder of `pivotgait sweep --out`"
        raise SweepFolderError(
            f"holds no readable {MANIFEST}", where=_short(path), mend=mend
        ) from error
    assert isinstance(found, dict)
    return found


def check_folder(path: Path, manifest: dict[str, Any]) -> None:
    """Refuse a folder that is not this sweep's, nor empty; changes nothing.

    Raises:
        SweepFolderError: saying what it holds, or that it is no folder.
    """
    with _usable(path):
        if not path.exists():
            return
        begun = (path / MANIFEST).exists()
        names = sorted(each.name for each in path.iterdir() if not each.name.startswith("."))
    others = [name for name in names if name not in (PARTS, TIMINGS)]
    if not begun and others:
        mend = "give a new folder"
        raise SweepFolderError(f"holds {others[0]!r}", where=_short(path), mend=mend)
    if not begun:
        return
    there = read_manifest(path)
    for name, value in manifest.items():
        # as text, since the order of the axes counts
        if json.dumps(there.get(name)) != json.dumps(value):
            what, mend = _difference(name, there.get(name), value)
            raise SweepFolderError(what, where=_short(path), mend=mend)


def _difference(name: str, there: Any, here: Any) -> tuple[str, str]:
    if name == "versions":
        old = [f"{k} {v}" for k, v in (there or {}).items() if here.get(k) != v]
        what = f"holds results of {', '.join(old) or 'other versions'}"
        return what, "go on with those versions, or give a new folder"
    if name == "study" and isinstance(there, dict):
        keys = [key for key in here if json.dumps(there.get(key)) != json.dumps(here[key])]
        name = f"study, with other {', '.join(keys) or 'fields'}"
    return f"holds results of another {name}", "give a new folder, or the study it was begun with"


def _found(path: Path, study: Study) -> SweepFolder:
    """The parts that are there; a damaged one is done again."""
    parts, done, counts = Parts.of(study), set[int](), Counter[str]()
    for file in (path / PARTS).glob("*.parquet"):
        summary = read_summary(file)
        wanted = summary and (
            file.name == file_name(summary.part)
            and summary.study == study.digest
            and summary.cells == len(parts.numbers(summary.part))
        )
        if summary is None or not wanted:
            file.unlink()
            continue
        done.add(summary.part)
        counts.update(summary.counts)
    return SweepFolder(path, parts, frozenset(done), counts)


def _remove_partial(path: Path) -> None:
    """Remove what a killed process had begun to write."""
    for folder in (path, path / PARTS, path / TIMINGS):
        for file in folder.glob(".*.part"):
            file.unlink()


def _short(path: Path) -> str:
    return str(path)[:80]
