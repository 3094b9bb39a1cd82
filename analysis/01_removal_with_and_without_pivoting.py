"""When may a finger leave a tool that must not move, and how much pivoting buys it back?

The tool rests on its tip after the lift, held by all fingers. One finger (the first that the
scene's gait removes) unloads. Two answers for every friction of the fingers and every place of
the finger that was added last:

* **Without moving**: the least normal force of the leaving finger with which static forces of all
  contacts still exist, one second-order cone program (SOCP) per cell; 0 N means that the finger
  may leave. Checked with the package's own allocation just above and just below.
* **With pivoting**: the smallest turn after which the others hold the tool at rest (a bound on
  the turn of any removal; checked on a grid of smaller turns), and the turn of the planned
  removal. Cells in which planning fails are kept and named.

The scene's friction reserve is set to 0 here, so that a friction of 0.6 means 0.6. The friction
of the table stays as it is.
"""

from __future__ import annotations

import argparse
import warnings
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import cvxpy as cp
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.spatial.transform import Rotation
from study_files import write_results

from pivotgait.contacts import grasp_map
from pivotgait.dynamics import pivot_motion
from pivotgait.exceptions import InfeasibleError, SceneError, SolverError
from pivotgait.forces import AllocationProblem, allocate
from pivotgait.models import (
    AdditionPhase,
    HandleContact,
    LiftPhase,
    RemovalPhase,
    Scene,
    load_scene,
)
from pivotgait.phases.allocation import allocation_problem
from pivotgait.phases.grasp import Grasp, Setting
from pivotgait.phases.removal import RemovalOptions, plan_removal, removal_problem
from pivotgait.phases.removal_problem import RemovalWeights
from pivotgait.phases.static_grasp import smallest_turn
from pivotgait.plans import PIVOT
from pivotgait.plotting.pivoting import (
    FrictionLine,
    HandleSection,
    PlaceMap,
    SectionFinger,
    pivoting_maps,
)
from pivotgait.plotting.save import save_figure

Array = NDArray[np.float64]
ALONG_M = {"knife": (0.010, 0.114), "screwdriver": (0.015, 0.095)}
"""Range of the place along the handle, the scene's own place in its middle."""
AROUND_DEG = 30.0
"""The place around the handle goes this far to both sides of the scene's own."""
BESIDE_DEG = 10.0
"""The lines over friction are drawn at the scene's own place and this far beside it."""
FRICTION = (0.30, 1.00)
NO_FORCE_N, NO_TURN_DEG = 1e-6, 1e-4
"""Less than this is 0: ten times what the solvers leave."""
DETOUR_DEG = 1.0
"""A planned removal that turns this much more than needed ended in a worse local optimum."""
BOUND_DEG = 0.05
"""A removal that turns this much less than the bound shows that the bound is none."""
OUTCOMES = ("planned", "detour", "solver failed", "infeasible", "no start", "no place")


@dataclass(frozen=True)
class Situation:
    """The tool at rest after the lift, and which finger leaves.

    Attributes:
        setting: tool and table; no friction reserve.
        rotation: of the tool, world <- tool.
        staying: contacts that stay.
        leaving: the contact that leaves.
        moved: name of the staying contact whose place is varied.
        options: of the removal, as the scene has them.
    """

    setting: Setting
    rotation: Rotation
    staying: tuple[HandleContact, ...]
    leaving: HandleContact
    moved: str
    options: RemovalOptions

    @classmethod
    def of(cls, scene: Scene) -> Situation:
        """What the first removal of the scene's first gait starts from."""
        allocation = scene.allocation.model_copy(update={"friction_reserve": 0.0})
        exact = replace(scene, config=scene.config.model_copy(update={"allocation": allocation}))
        held: list[str] = []
        rotation = scene.rest_rotation
        for phase in next(iter(scene.gaits.values())):
            if isinstance(phase, LiftPhase):
                held, rotation = list(phase.contacts), scene.lift_rotation(phase.to)
            elif isinstance(phase, AdditionPhase):
                held.append(phase.contact)
            elif isinstance(phase, RemovalPhase):
                staying = [name for name in held if name != phase.contact]
                contacts = tuple(scene.contacts[name] for name in staying)
                leaving = scene.contacts[phase.contact]
                weights = RemovalWeights(**phase.weights.model_dump())
                options = RemovalOptions(phase.duration_s, phase.steps, weights)
                return cls(Setting.of(exact), rotation, contacts, leaving, staying[-1], options)
        raise SceneError("the gait removes no finger", where=f"scene {scene.name}")

    @property
    def place(self) -> tuple[float, float]:
        """The scene's own place of the moved contact: along [m] and around [deg]."""
        given = self.setting.scene.config.contacts[self.moved]
        return given.along_m, given.around_deg

    def fingers(self, friction: float, along_m: float, around_deg: float) -> list[HandleContact]:
        """Contacts staying, leaving, with another friction and place of the moved one."""
        point = self.setting.scene.tool.place(along_m, np.radians(around_deg), where=self.moved)
        contacts = [replace(each, friction=friction) for each in (*self.staying, self.leaving)]
        return [
            replace(each, point=point.point, normal=point.normal)
            if each.name == self.moved
            else each
            for each in contacts
        ]

    def static(self, turns: Rotation, fingers: Sequence[HandleContact]) -> AllocationProblem:
        """Allocation problem of the tool at rest after each of N turns (tool axes)."""
        still = np.zeros((len(turns), 3))
        motion = pivot_motion(self.setting.body, self.rotation * turns, still, still)
        return allocation_problem(self.setting, motion, fingers)


@dataclass(frozen=True)
class Cell:
    """One friction and place. Forces and turns are NaN where they do not exist.

    Attributes:
        friction: of all fingers.
        along_m: of the moved contact.
        around_deg: of the moved contact.
        outcome: one of :data:`OUTCOMES`, of the planned removal.
        start_N: normal force of the leaving finger in the starting grasp.
        least_N: without moving, its least normal force.
        bracketed: whether the package's allocation finds forces 1 % above it and none 1 % below.
        needed_deg: smallest turn after which the others hold the tool.
        nearer_found: whether a grid of smaller turns has one that they can hold after all, or
            the planned removal itself turns less: then ``needed_deg`` is not the smallest.
        planned_deg: turn of the planned removal.
        cost: of the planned removal.
        iterations: of its solver.
        solver: that found it.
        message: of the failure.
    """

    friction: float
    along_m: float
    around_deg: float
    outcome: str
    start_N: float = np.nan
    least_N: float = np.nan
    bracketed: bool = True
    needed_deg: float = np.nan
    nearer_found: bool = False
    planned_deg: float = np.nan
    cost: float = np.nan
    iterations: int = 0
    solver: str = ""
    message: str = ""

    @property
    def share(self) -> float:
        """Least normal force without moving, as a share of the starting one."""
        return self.least_N / self.start_N


def solve_cell(situation: Situation, friction: float, along_m: float, around_deg: float) -> Cell:
    """Both answers for one friction and place."""
    cell = partial(Cell, round(friction, 6), round(along_m, 6), round(around_deg, 6))
    try:
        fingers = situation.fingers(friction, along_m, around_deg)
    except SceneError as error:
        return cell("no place", message=str(error))
    static = situation.static(Rotation.identity(1), fingers)
    start = allocate(static)
    if not start.feasible[0]:
        return cell("no start", message="all fingers together cannot hold the tool")
    least = least_force(static)
    names = (PIVOT, *(each.finger for each in fingers))
    grasp = Grasp(
        situation.rotation,
        {each.finger: each for each in fingers},
        dict(zip(names, start.force[0], strict=True)),
    )
    staying, leaving, options = list(fingers[:-1]), fingers[-1], situation.options
    need = smallest_turn(removal_problem(situation.setting, grasp, staying, leaving, options))
    needed = float(np.degrees(need.angle))
    needed = 0.0 if needed < NO_TURN_DEG else needed
    cell = partial(
        cell,
        start_N=float(start.normal_force[0, -1]),
        least_N=least,
        bracketed=is_bracketed(static, least),
        needed_deg=needed,
        nearer_found=need.feasible and nearer_turn(situation, staying, needed),
    )
    try:
        phase, _ = plan_removal(situation.setting, grasp, leaving.finger, options, name="removal")
    except InfeasibleError as error:
        return cell("infeasible", message=str(error))
    except SolverError as error:
        return cell("solver failed", message=str(error))
    planned = phase.reorientation_deg
    return cell(
        "detour" if planned > needed + DETOUR_DEG else "planned",
        planned_deg=planned,
        nearer_found=cell.keywords["nearer_found"] or planned < needed - BOUND_DEG,
        cost=phase.record["cost"],
        iterations=phase.record["iterations"],
        solver=phase.record["solver"],
    )


def least_force(problem: AllocationProblem) -> float:
    """Least normal force [N] of the last contact with which forces (3)-(6) exist, by one SOCP."""
    normals, force = problem.normals[0], cp.Variable((problem.contacts, 3))
    grasp = grasp_map(problem.lever)[0]
    rows = [grasp @ cp.reshape(force, (3 * problem.contacts,), order="C") == problem.wrench[0]]
    pushes = [normal @ force[i] for i, normal in enumerate(normals)]
    for i, push in enumerate(pushes):
        low = problem.normal_min[0, i] if i < len(pushes) - 1 else 0.0
        tangent = force[i] - push * normals[i]
        rows += [cp.norm(tangent) <= problem.friction[i] * push, push >= low]
        rows.append(push <= problem.normal_max[0, i])
    program = cp.Problem(cp.Minimize(pushes[-1]), rows)
    with warnings.catch_warnings():
        # An answer short of these tolerances is judged by is_bracketed, as every other is.
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        program.solve("CLARABEL", tol_gap_abs=1e-8, tol_gap_rel=1e-8, tol_feas=1e-8)
    if program.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        raise SolverError(f"the SOCP of the least force ended as {program.status}")
    return 0.0 if program.value < NO_FORCE_N else float(program.value)


def is_bracketed(problem: AllocationProblem, least: float) -> bool:
    """Whether forces exist 1 % above the least normal force of the last contact, not below."""
    trial = [1.01 * least, 0.99 * least] if least else [0.0]
    count = len(trial)
    fixed, low = (np.repeat(a, count, axis=0) for a in (problem.fixed, problem.normal_min))
    fixed[:, -1], low[:, -1] = trial, 0.0
    repeated = replace(
        problem,
        lever=np.repeat(problem.lever, count, axis=0),
        normals=np.repeat(problem.normals, count, axis=0),
        wrench=np.repeat(problem.wrench, count, axis=0),
        normal_min=low,
        normal_max=np.repeat(problem.normal_max, count, axis=0),
        normal_fixed=fixed,
        objective="effort",
    )
    feasible = allocate(repeated, "interior_point").feasible
    return bool(np.array_equal(feasible, [True, False][:count]))


def nearer_turn(situation: Situation, staying: Sequence[HandleContact], needed_deg: float) -> bool:
    """Whether the staying fingers hold the tool after some turn of a grid inside the smallest."""
    if needed_deg == 0.0:
        return False
    sizes = np.radians(needed_deg) * np.array([0.0, 0.25, 0.5, 0.75, 0.9, 0.98])
    turns = Rotation.from_rotvec((sizes[:, None, None] * _directions(200)).reshape(-1, 3))
    problem = replace(situation.static(turns, staying), objective="effort")
    scene = situation.setting.scene
    clear = scene.height(situation.rotation * turns) >= scene.clearance
    return bool((allocate(problem, "interior_point").feasible & clear).any())


def _directions(count: int) -> Array:
    """(count, 3) unit vectors spread evenly over the sphere (a Fibonacci spiral)."""
    place = np.arange(count) + 0.5
    polar, azimuth = np.arccos(1.0 - 2.0 * place / count), np.pi * (1.0 + 5.0**0.5) * place
    flat = np.sin(polar)
    return np.stack((flat * np.cos(azimuth), flat * np.sin(azimuth), np.cos(polar)), axis=1)


@dataclass(frozen=True, eq=False)
class Sweep:
    """Cells of a friction x place grid, or of a line of frictions at one place.

    Attributes:
        name: ``along``, ``around`` or ``nominal``.
        friction: (m,).
        place: (n,) along [m] or around [deg].
        cells: m rows of n.
    """

    name: str
    friction: Array
    place: Array
    cells: tuple[tuple[Cell, ...], ...]

    def grid(self, name: str) -> Any:
        """(m, n) of one attribute of the cells."""
        return np.array([[getattr(cell, name) for cell in row] for row in self.cells])


def sweep(
    situation: Situation, name: str, friction: Array, place: Array, console: Console
) -> Sweep:
    """Solve every cell, showing the progress."""
    along, around = situation.place
    todo = [
        (mu, along if name == "around" else x, x if name == "around" else around)
        for mu in friction.tolist()
        for x in place.tolist()
    ]
    shown: Iterable[Any] = track(todo, f"{name:8}", console=console, transient=True)
    cells = [solve_cell(situation, *each) for each in shown]
    width = len(place)
    rows = tuple(tuple(cells[i : i + width]) for i in range(0, len(cells), width))
    return Sweep(name, friction, place, rows)


def main(
    quick: bool = False, out: Path = Path("reports/out/analysis/01"), scene: str = "knife"
) -> dict[str, Any]:
    """Run the study; write ``removal_SCENE`` as PDF, PNG and JSON into ``out``.

    Args:
        quick: 3 x 3 cells instead of 15 x 17 and 15 x 13.
        out: folder.
        scene: ``knife`` or ``screwdriver``.

    Returns:
        What the JSON file holds.
    """
    console, began = Console(), perf_counter()
    situation = Situation.of(load_scene(scene))
    along, around = situation.place
    friction = np.linspace(*FRICTION, 3 if quick else 15)
    alongs = np.linspace(*ALONG_M[scene], 3 if quick else 17)
    arounds = around + np.linspace(-AROUND_DEG, AROUND_DEG, 3 if quick else 13)
    fine = np.linspace(*FRICTION, 3 if quick else 29)
    sweeps = {
        "along": sweep(situation, "along", friction, alongs, console),
        "around": sweep(situation, "around", friction, arounds, console),
        "nominal": sweep(situation, "nominal", fine, np.array([along]), console),
    }
    result: dict[str, Any] = {
        "scene": scene,
        "leaving": situation.leaving.name,
        "staying": [each.name for each in situation.staying],
        "moved": situation.moved,
        "nominal": {"along_m": along, "around_deg": around},
        "friction_reserve": 0.0,
        "friction_table": situation.setting.scene.table.friction,
        "findings": findings(sweeps),
        "sweeps": {
            name: {
                "friction": each.friction.tolist(),
                "place": each.place.tolist(),
                "cells": [[asdict(cell) for cell in row] for row in each.cells],
            }
            for name, each in sweeps.items()
        },
    }
    files = save_figure(picture(situation, sweeps), out, f"removal_{scene}")
    target = out / f"removal_{scene}.json"
    write_results(target, result)
    tell(console, situation, sweeps, result["findings"])
    console.print(
        f"{files.png.name}, {files.pdf.name}, {target.name}: {perf_counter() - began:.0f} s"
    )
    return result


def findings(sweeps: dict[str, Sweep]) -> dict[str, Any]:
    """The answer in numbers, over all cells and at the scene's own place."""
    cells = [cell for each in sweeps.values() for row in each.cells for cell in row]
    line = [row[0] for row in sweeps["nominal"].cells]
    known = [cell for cell in cells if np.isfinite(cell.needed_deg)]
    planned = [cell for cell in cells if cell.outcome == "planned"]
    stuck = [cell for cell in cells if cell.least_N > 0.0]
    bought = [cell for cell in stuck if cell.outcome == "planned"]
    extra = [cell.planned_deg - cell.needed_deg for cell in planned if cell.needed_deg > 0.0]
    free = [cell.friction for cell in line if cell.least_N == 0.0]
    return {
        "cells": len(cells),
        "outcomes": dict(Counter(cell.outcome for cell in cells)),
        "solvers": dict(Counter(cell.solver for cell in cells if cell.solver)),
        "possible_without_moving": sum(cell.least_N == 0.0 for cell in cells),
        "impossible_without_moving": len(stuck),
        "of_these_planned_with_pivoting": len(bought),
        "largest_least_N": max((cell.least_N for cell in known), default=float("nan")),
        "largest_share": max((cell.share for cell in known), default=float("nan")),
        "largest_needed_deg": max((cell.needed_deg for cell in known), default=float("nan")),
        "planned_over_needed_deg": {
            "median": float(np.median(extra)) if extra else float("nan"),
            "largest": max(extra, default=float("nan")),
        },
        "nominal_friction_without_moving": min(free, default=float("nan")),
        "least_force_unconfirmed": sum(not cell.bracketed for cell in cells),
        "smaller_turn_exists": sum(cell.nearer_found for cell in cells),
    }


def tell(
    console: Console, situation: Situation, sweeps: dict[str, Sweep], found: dict[str, Any]
) -> None:
    """Print the table of the scene's own place and the answer in words."""
    leaving, moved = situation.leaving.finger, situation.moved
    table = Table(title=f"Removing {leaving}, {moved} at its own place")
    for head in (
        "friction",
        "least force [N]",
        "share",
        "needed [deg]",
        "planned [deg]",
        "outcome",
    ):
        table.add_column(head, justify="right")
    rows = [row[0] for row in sweeps["nominal"].cells]
    for cell in rows[:: max(1, len(rows) // 14)]:
        numbers = (f"{cell.least_N:.3f}", f"{cell.share:.1%}", f"{cell.needed_deg:.2f}")
        table.add_row(f"{cell.friction:.2f}", *numbers, f"{cell.planned_deg:.2f}", cell.outcome)
    console.print(table)
    extra = found["planned_over_needed_deg"]
    limit = found["nominal_friction_without_moving"]
    own = f"from a friction of {limit:.3g}" if np.isfinite(limit) else "at no friction"
    console.print(
        f"If the tool may not move, {leaving} can leave in {found['possible_without_moving']} of "
        f"{found['cells']} cells (at the scene's own place {own}); else removal stops "
        f"with up to {found['largest_least_N']:.2f} N ({found['largest_share']:.0%}) still on it. "
        f"Pivoting by at most {found['largest_needed_deg']:.1f} deg buys it back; the planner "
        f"found {found['of_these_planned_with_pivoting']} of these "
        f"{found['impossible_without_moving']} removals, turning "
        f"{extra['median']:.3f} deg (median; at most {extra['largest']:.2f}) more than needed. "
        f"Outcomes: {found['outcomes']}, by {found['solvers']}. Checks failed: "
        f"{found['least_force_unconfirmed']} of the least force, "
        f"{found['smaller_turn_exists']} of the smallest turn."
    )


def picture(situation: Situation, sweeps: dict[str, Sweep]) -> Any:
    """The figure: maps along and around the handle, lines over friction, the handle's section."""
    own, line, around = situation.place, sweeps["nominal"], sweeps["around"]
    maps = [
        PlaceMap(
            axis=axis,
            place=scale * each.place,
            own=scale * own[i],
            friction=each.friction,
            share=each.grid("share"),
            needed_deg=each.grid("needed_deg"),
            failed=each.grid("outcome") == "solver failed",
            detour=each.grid("outcome") == "detour",
        )
        for i, (axis, scale, each) in enumerate(
            [
                ("along handle [mm]", 1e3, sweeps["along"]),
                ("around handle [deg]", 1.0, around),
            ]
        )
    ]
    lines = [
        FrictionLine(f"{around.place[k]:g}°", around.friction, around.grid("needed_deg")[:, k])
        for k in np.flatnonzero(np.isclose(np.abs(around.place - own[1]), BESIDE_DEG))
    ]
    needed, planned = line.grid("needed_deg")[:, 0], line.grid("planned_deg")[:, 0]
    lines.append(FrictionLine(f"{own[1]:g}°", line.friction, needed, planned))
    moved = situation.setting.scene.contacts[situation.moved].finger
    leaving = situation.leaving.finger
    return pivoting_maps(maps, lines, section(situation), leaving=leaving, moved=moved)


def section(situation: Situation) -> HandleSection:
    """The handle's section at the place of the moved contact, seen along the handle from behind."""
    scene, turn = situation.setting.scene, situation.rotation.as_matrix()
    handle, (along, around) = scene.tool.handle, situation.place
    back = turn @ handle.axis
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    view = np.stack((right, np.cross(back, right))) @ turn

    def spots(angles: Array) -> Array:
        """(n, 2) points [mm] at these angles [deg], without those on an edge."""
        found = []
        for angle in np.radians(angles):
            try:
                found.append(1e3 * view @ handle.place(along, angle).point)
            except SceneError:
                continue
        return np.array(found).reshape(-1, 2)

    ends = around + AROUND_DEG * np.array([-1.0, 1.0])
    return HandleSection(
        outline=spots(np.arange(0.5, 360.0, 1.0)),
        swept=spots(np.linspace(ends[0], ends[1], 61)),
        ends=tuple(f"{end:g}°" for end in ends),
        fingers=tuple(
            SectionFinger(
                each.finger, 1e3 * view @ each.point, view @ each.normal, each is situation.leaving
            )
            for each in (*situation.staying, situation.leaving)
        ),
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="3 x 3 cells")
    parser.add_argument("--out", type=Path, default=Path("reports/out/analysis/01"))
    parser.add_argument("--scene", choices=sorted(ALONG_M), default="knife")
    given = parser.parse_args()
    main(given.quick, given.out, given.scene)
