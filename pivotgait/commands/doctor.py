"""``doctor``: versions, and one small job for each native library."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version

import numpy as np
from rich.markup import escape

from pivotgait import __version__
from pivotgait.commands.output import Output, verdict
from pivotgait.forces.proxqp_build import load_proxqp
from pivotgait.models import builtin_scenes, load_scene

PACKAGES = (
    "pin",
    "coal",
    "proxsuite",
    "cvxpy",
    "clarabel",
    "casadi",
    "pybullet",
    "example-robot-data",
    "numpy",
    "scipy",
    "matplotlib",
    "h5py",
    "viser",
)


def run_doctor(out: Output) -> int:
    """Check the environment: versions, and one small job for each native library."""
    packages = {name: _version(name) for name in PACKAGES}
    probes = {name: _try(probe) for name, probe in PROBES.items()}
    healthy = all(packages.values()) and all(result == "ok" for result in probes.values())
    out.table(
        f"pivotgait {__version__}, Python {platform.python_version()}, {platform.system()} "
        f"{platform.machine()}, {os.cpu_count()} cores",
        [("package", "left"), ("version", "left")],
        [(name, found or "[red]missing[/]") for name, found in packages.items()],
    )
    rows = [
        (name, result if result == "ok" else f"[red]{escape(result)}[/]")
        for name, result in probes.items()
    ]
    out.table("checks", [("what", "left"), ("result", "left")], rows)
    out.say(f"environment: {verdict(healthy, 'healthy', 'NOT healthy: reinstall what is red')}")
    out.emit(
        {
            "healthy": healthy,
            "pivotgait": __version__,
            "python": platform.python_version(),
            "cores": os.cpu_count(),
            "packages": packages,
            "checks": probes,
        }
    )
    return 0 if healthy else 1


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _try(probe: Callable[[], bool]) -> str:
    try:
        return "ok" if probe() else "wrong answer"
    except Exception as error:
        return f"{type(error).__name__}: {error}"[:120]


def _scenes_load() -> bool:
    return all(load_scene(name).tool.mass > 0.0 for name in builtin_scenes())


def _pinocchio() -> bool:
    import pinocchio as pin

    return bool(pin.buildModelFromXML(load_scene("knife").tool.urdf).nv == 0)


def _coal() -> bool:
    import coal

    pose = coal.Transform3s()
    pose.setTranslation(np.array([0.0, 0.0, 3.0]))
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    coal.distance(coal.Sphere(1.0), coal.Transform3s(), coal.Sphere(1.0), pose, request, result)
    return bool(abs(result.min_distance - 1.0) < 1e-9)


def _proxqp() -> bool:
    answer = load_proxqp().dense.solve(np.eye(2), -np.ones(2), eps_abs=1e-9)
    return bool(np.abs(np.asarray(answer.x) - 1.0).max() < 1e-6)


def _solvers_of_casadi() -> bool:
    import casadi

    return bool(casadi.has_nlpsol("fatrop") and casadi.has_nlpsol("ipopt"))


def _clarabel_in_cvxpy() -> bool:
    import cvxpy

    return "CLARABEL" in cvxpy.installed_solvers()


def _viser() -> bool:
    from pivotgait.viewing import quiet_server

    with quiet_server() as server:
        return bool(server.get_port() > 0)


PROBES: dict[str, Callable[[], bool]] = {
    "built-in scenes load": _scenes_load,
    "Pinocchio reads a tool": _pinocchio,
    "Coal measures a distance": _coal,
    "ProxQP solves a small problem": _proxqp,
    "CasADi carries FATROP and IPOPT": _solvers_of_casadi,
    "CVXPY finds Clarabel": _clarabel_in_cvxpy,
    "viser opens a local server": _viser,
}
