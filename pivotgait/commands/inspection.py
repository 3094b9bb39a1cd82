"""``scenes`` and ``check``: what there is, and whether it is sound."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich.markup import escape

from pivotgait.commands.output import Output, verdict
from pivotgait.exceptions import InputError
from pivotgait.models import builtin_scenes, export_scene, load_scene, scene_schema
from pivotgait.models.urdf import read_urdf
from pivotgait.plans import read_plan


def run_scenes(schema: bool, export: str | None, out: Output) -> int:
    """List the built-in scenes, or print the schema or one of them."""
    if schema and export is not None:
        raise InputError("--schema and --export exclude each other", mend="give one of them")
    if schema:
        Output(json_output=True).emit(scene_schema())
        return 0
    if export is not None:
        text = export_scene(export)
        if out.json:
            out.emit({"name": export, "yaml": text})
        else:
            sys.stdout.write(text)
        return 0
    rows, data = [], []
    for name in builtin_scenes():
        scene = load_scene(name)
        gaits = {gait: [config.kind for config in configs] for gait, configs in scene.gaits.items()}
        entry = {"name": name, "description": scene.description, "gaits": gaits}
        data.append({**entry, "tool": scene.tool.name, "mass_kg": scene.tool.mass})
        kinds = "; ".join(f"{gait}: {' > '.join(steps)}" for gait, steps in gaits.items())
        rows.append((name, f"{scene.tool.mass:.3f} kg", escape(kinds), escape(scene.description)))
    columns = [("scene", "left"), ("tool", "right"), ("gaits", "left"), ("description", "left")]
    out.table("built-in scenes", columns, rows)
    out.say("print one to start from: pivotgait scenes --export knife")
    out.emit({"scenes": data})
    return 0


def run_check(path: Path, out: Output) -> int:
    """Lint a URDF, a scene or a plan file; raises InputError for what is wrong."""
    checks: dict[str, Callable[[Path], dict[str, Any]]] = {
        ".urdf": _check_urdf,
        ".xml": _check_urdf,
        ".yaml": _check_scene,
        ".yml": _check_scene,
        ".h5": _check_plan,
        ".hdf5": _check_plan,
    }
    if path.suffix not in checks:
        raise InputError(
            f"cannot tell what {path.suffix or 'no suffix'!r} is",
            where=str(path),
            mend=f"give a file ending in {', '.join(checks)}",
        )
    found = checks[path.suffix](path)
    out.say(f"{escape(path.name)}: {verdict(True, 'sound', '')}")
    for name, value in found.items():
        out.say(f"  {name}: {escape(str(value))}")
    out.emit({"file": str(path), "sound": True, **found})
    return 0


def _check_urdf(path: Path) -> dict[str, Any]:
    summary = read_urdf(path, roots=(path.parent,))
    shapes = [shape.name for link in summary.links.values() for shape in link.collisions]
    mass = sum(link.inertial.mass for link in summary.links.values() if link.inertial)
    return {
        "kind": "urdf",
        "robot": summary.name,
        "links": len(summary.links),
        "joints": len(summary.joints),
        "mass_kg": mass,
        "collision_shapes": shapes,
    }


def _check_scene(path: Path) -> dict[str, Any]:
    scene = load_scene(path)
    return {
        "kind": "scene",
        "name": scene.name,
        "tool": scene.tool.name,
        "rest_pitch_deg": float(np.degrees(scene.rest_pitch)),
        "contacts": sorted(scene.contacts),
        "gaits": {name: [config.kind for config in gait] for name, gait in scene.gaits.items()},
    }


def _check_plan(path: Path) -> dict[str, Any]:
    plan = read_plan(path)
    says = None if plan.certificate is None else plan.certificate.get("valid")
    return {
        "kind": "plan",
        "tool": plan.tool.name,
        "phases": [phase.name for phase in plan.phases],
        "duration_s": sum(phase.duration_s for phase in plan.phases),
        "certificate_valid": says,
    }
