"""Where the URDFs of the built-in models are, in a checkout and in an installed package."""

from __future__ import annotations

from pathlib import Path

import pivotgait


def urdf_root() -> Path:
    """Folder with one sub-folder per model, ``<name>/<name>.urdf``.

    A wheel carries it as package data; a checkout has it beside the package.
    """
    package = Path(pivotgait.__file__).resolve().parent
    installed = package / "_data" / "urdf"
    return installed if installed.is_dir() else package.parent / "urdf"


def model_names() -> tuple[str, ...]:
    """Names of the models under :func:`urdf_root`, sorted."""
    return tuple(sorted(path.stem for path in urdf_root().glob("*/*.urdf")))


def is_file(path: Path) -> bool:
    """Whether ``path`` is a regular file; False for names the file system refuses."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False
