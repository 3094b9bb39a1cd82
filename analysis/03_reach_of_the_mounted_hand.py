"""How should the hand hang under the arm: which tilt, how high the pedestal, where the tool?

The forearm hangs under the flange of the SCARA arm, tilted from straight down, and a pedestal
carries the arm. Asked of the gaits of two scenes: from how many random starts does the planner's
search find postures for the whole sequence of key poses?

* **Tilt**: one search for every tilt and scene, on an arm whose quill is long enough for every
  pedestal. Only J3 moves the hand up and down, so pedestals differ in nothing but what J3 must
  make up: each posture found is shifted to each pedestal, and counts there if it then keeps the
  joints' limits and every clearance.
* **Check**: the same search on the arm as it would be built, for the chosen mounting, for a
  pedestal above all that the shift allows, and for the tilts next to the chosen one.
* **Place**: a SCARA arm puts the flange at any x, y and yaw, so a posture found is carried with
  the tool to another distance and yaw, with both elbows, and checked again for limits and
  clearances, but not for its conditioning. Distance and yaw count from the grasp; J1 turns the
  rest, within its limits.

More tilt needs a longer wedge, so that the rim of the forearm's plate clears the flange, and
swings more mass about J4, which the arm's maker limits. Both enter.
"""

from __future__ import annotations

import argparse
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.optimize import brentq
from study_files import write_results

from pivotgait.gaits.itinerary import Itinerary
from pivotgait.gaits.steps import plan_steps
from pivotgait.models import Robot, Scene, load_scene
from pivotgait.models.robot_loading import build_robot
from pivotgait.models.urdf import check_urdf
from pivotgait.phases.grasp import Setting
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import Postures
from pivotgait.planning.posture_search import PostureOptions, PostureSearch
from pivotgait.plotting.reach import MountingMap, PlaceMap, mounting_maps, place_maps
from pivotgait.plotting.save import save_figure

Array = NDArray[np.float64]
SCENES = ("knife", "screwdriver")
TILT_DEG = np.linspace(0.0, 60.0, 9)
HEIGHT_M = np.round(np.arange(0.05, 0.36, 0.02), 2)
RADIUS_M = np.round(np.arange(0.10, 0.851, 0.025), 3)
YAW_DEG = np.arange(-180.0, 181.0, 15.0)
PLATE_RADIUS_M, DISC_M, WEDGE_M = 0.0675, 0.012, 0.034
"""Forearm's elbow plate; the adapter's disc and the least height of its wedge."""
J4_INERTIA_MAX = 0.045
"""Largest inertia about J4 [kg m^2] (README of the URDF; recalled)."""
ABOVE_M = 0.04
"""A pedestal this much higher than any that fits is searched on the built arm, too."""
SEED = 3


@dataclass(frozen=True)
class Mounting:
    """How the hand hangs and how high the arm stands.

    Attributes:
        tilt_deg: of the forearm from straight down, about its x.
        height_m: of the pedestal.
    """

    tilt_deg: float
    height_m: float

    @classmethod
    def of(cls, urdf: str) -> Mounting:
        """The mounting a URDF's text has."""
        joints = check_urdf(urdf, where="urdf").joints
        turn = joints["forearm_mount"].rotation
        tilt = float(np.degrees(np.arctan2(-turn[2, 1], turn[2, 2])))
        height = float(joints["pedestal_mount"].translation[2])
        return cls(round(tilt, 9), round(height, 9))

    @property
    def offset_m(self) -> float:
        """From the flange to the forearm: the rim of its plate clears the adapter's disc."""
        rim = PLATE_RADIUS_M * float(np.sin(np.radians(self.tilt_deg)))
        return DISC_M + max(WEDGE_M, rim)

    def apply(self, urdf: str, longer_m: float = 0.0) -> str:
        """The URDF's text with this mounting and a stroke of J3 that is longer by so much."""
        root = ET.fromstring(urdf)
        mount = root.find("joint[@name='forearm_mount']/origin")
        stand = root.find("joint[@name='pedestal_mount']/origin")
        stroke = root.find("joint[@name='J3']/limit")
        if mount is None or stand is None or stroke is None:
            raise ValueError("the URDF has no forearm_mount, pedestal_mount or J3")
        mount.set("xyz", f"0 0 {self.offset_m!r}")
        mount.set("rpy", f"{-float(np.radians(self.tilt_deg))!r} 0 0")
        stand.set("xyz", f"0 0 {self.height_m!r}")
        stroke.set("upper", repr(float(stroke.attrib["upper"]) + longer_m))
        for kind in ("collision", "visual"):
            for shape in root.findall(f"link[@name='pedestal']/{kind}"):
                for origin in shape.iter("origin"):
                    origin.set("xyz", f"0 0 {self.height_m / 2.0!r}")
                for box in shape.iter("box"):
                    wide, deep, _ = box.attrib["size"].split()
                    box.set("size", f"{wide} {deep} {self.height_m!r}")
        return ET.tostring(root, encoding="unicode")


@dataclass(frozen=True, eq=False)
class Task:
    """What the hand has to do in a scene.

    Attributes:
        scene: with the robot as it is.
        keys: key poses of the scene's first gait.
        grasp: (2,) horizontal place of the first grasp on the tool at rest, world [m].
        forward: yaw of the tool at rest, from the grasp to the tip, world [rad].
    """

    scene: Scene
    keys: tuple[KeyPose, ...]
    grasp: Array
    forward: float

    @classmethod
    def of(cls, scene: Scene) -> Task:
        """The first gait of a scene, planned as the tool feels it."""
        steps = plan_steps(Setting.of(scene), next(iter(scene.gaits.values())))
        keys = Itinerary.of(scene, steps).keys
        first = keys[0]
        places = [first.rotation @ each.point for each in first.contacts.values()]
        grasp = (first.position + np.mean(places, axis=0))[:2]
        ahead = scene.pivot[:2] - grasp
        return cls(scene, keys, grasp, float(np.arctan2(ahead[1], ahead[0])))

    @property
    def urdf(self) -> str:
        """Text of the robot as it is."""
        assert self.scene.robot is not None
        return self.scene.robot.urdf

    @property
    def place(self) -> tuple[float, float]:
        """Own distance of the grasp from J1 [m] and yaw from pointing away from it [deg]."""
        azimuth = np.arctan2(self.grasp[1], self.grasp[0])
        yaw = (self.forward - azimuth + np.pi) % (2.0 * np.pi) - np.pi
        return float(np.hypot(*self.grasp)), float(np.degrees(yaw))

    def robot(self, mounting: Mounting, longer_m: float = 0.0) -> Robot:
        """The scene's robot with another mounting."""
        config = self.scene.config.robot
        assert config is not None
        text = mounting.apply(self.urdf, longer_m)
        return build_robot(text, config, where=f"{self.scene.name}.robot")

    def world(self, robot: Robot) -> CollisionWorld:
        """What that robot must not touch."""
        scene = self.scene
        return CollisionWorld(robot, scene.tool, scene.table.height, scene.clearance)

    def moved(self, radius_m: float, yaw_deg: float) -> tuple[Array, Array]:
        """Turn about z (3, 3) and shift (3,) that bring the grasp to another place (y = 0)."""
        angle = np.radians(yaw_deg) - self.forward
        turn = np.array(pin.rpy.rpyToMatrix(0.0, 0.0, angle))
        return turn, np.array([radius_m, 0.0, 0.0]) - turn @ np.append(self.grasp, 0.0)


@dataclass(frozen=True, eq=False)
class Search:
    """Postures found on one robot from random starts, the same ones for every robot.

    Attributes:
        starts: number of them.
        found: postures.
        failures: reason -> number of starts.
    """

    starts: int
    found: tuple[Postures, ...]
    failures: Counter[str]

    @classmethod
    def run(cls, task: Task, robot: Robot, starts: int) -> Search:
        """Search from every start, without a limit of time."""
        options = PostureOptions(starts=starts, time_limit_s=np.inf)
        rng = np.random.default_rng(SEED)
        search = PostureSearch(robot, task.world(robot), task.keys, rng, options)
        return cls(starts, tuple(search.candidates()), search.record.failures)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of the share of starts (Wilson's score)."""
        n, share, z = self.starts, len(self.found) / self.starts, 1.96
        middle = (share + z**2 / (2.0 * n)) / (1.0 + z**2 / n)
        half = z / (1.0 + z**2 / n) * np.sqrt(share * (1.0 - share) / n + (z / (2.0 * n)) ** 2)
        return max(0.0, float(middle - half)), float(middle + half)

    def summary(self) -> dict[str, Any]:
        """Numbers of the postures found."""
        return {
            "starts": self.starts,
            "found": len(self.found),
            "interval_95": list(self.interval),
            "best_singular_value_m": max((p.singular_value for p in self.found), default=np.nan),
            "best_clearance_m": max((p.clearance for p in self.found), default=np.nan),
            "failures": dict(self.failures.most_common()),
        }


@dataclass(frozen=True)
class Cell:
    """One mounting: what is left of the postures found at its tilt. NaN where nothing is.

    Attributes:
        found: number of postures.
        singular_value_m: best distance of H from singularity.
        clearance_m: best, as found.
        stroke_m: best distance of J3 from its ends.
    """

    found: int = 0
    singular_value_m: float = np.nan
    clearance_m: float = np.nan
    stroke_m: float = np.nan


@dataclass(frozen=True, eq=False)
class TiltRow:
    """One tilt in one scene.

    Attributes:
        search: on the arm with the long quill.
        cells: one for each of ``HEIGHT_M``.
    """

    search: Search
    cells: tuple[Cell, ...]

    @property
    def heights(self) -> tuple[float, float]:
        """Lowest and highest pedestal [m] with a posture; NaN without any."""
        good = [h for h, cell in zip(HEIGHT_M, self.cells, strict=True) if cell.found]
        return (float(min(good)), float(max(good))) if good else (np.nan, np.nan)


def long_quill(tilt_deg: float) -> tuple[Mounting, float]:
    """The highest pedestal, and how much longer J3 must be to reach as low as the lowest."""
    return Mounting(tilt_deg, float(HEIGHT_M[-1])), float(HEIGHT_M[-1] - HEIGHT_M[0])


def shifted(robot: Robot, q: Array, lower_m: float) -> Array:
    """Postures (K, nv) on a pedestal that is lower by so much: J3 gives the difference."""
    moved = np.array(q)
    moved[:, robot.joint_names.index("J3")] -= lower_m
    return moved


def fits(robot: Robot, world: CollisionWorld, q: Array, keys: Sequence[KeyPose]) -> bool:
    """Whether postures (K, nv) keep every limit and every clearance."""
    return robot.within_limits(q) and all(
        world.holding(frozenset(key.contacts)).free(each, key.rotation, key.position)
        for key, each in zip(keys, q, strict=True)
    )


def cell(task: Task, mounting: Mounting, search: Search) -> Cell:
    """What one pedestal leaves of the postures found with the long quill."""
    robot = task.robot(mounting)
    world, lower = task.world(robot), float(HEIGHT_M[-1]) - mounting.height_m
    column = robot.joint_names.index("J3")
    kept = [(each, shifted(robot, each.q, lower)) for each in search.found]
    kept = [(each, q) for each, q in kept if fits(robot, world, q, task.keys)]
    if not kept:
        return Cell()
    stroke = [
        min(q[:, column].min() - robot.lower[column], robot.upper[column] - q[:, column].max())
        for _, q in kept
    ]
    return Cell(
        len(kept),
        max(each.singular_value for each, _ in kept),
        max(each.clearance for each, _ in kept),
        float(max(stroke)),
    )


def tilt_row(task: Task, tilt_deg: float, starts: int) -> TiltRow:
    """Search once at a tilt, then try every pedestal."""
    search = Search.run(task, task.robot(*long_quill(tilt_deg)), starts)
    cells = [cell(task, Mounting(tilt_deg, float(h)), search) for h in HEIGHT_M]
    return TiltRow(search, tuple(cells))


def carried(robot: Robot, q: Array, turn: Array, shift: Array) -> Iterator[Array]:
    """Postures (K, nv) with the flange moved by a turn about z and a shift, for both elbows.

    Nothing where the arm does not reach. The flange is at (l1 c1 + l2 c12, l1 s1 + l2 s12), its
    yaw is J1 + J2 - J4.
    """
    j1, j2, j3, j4 = (robot.joint_names.index(name) for name in ("J1", "J2", "J3", "J4"))
    first, second = (robot.model.jointPlacements[k + 1].translation[0] for k in (j2, j3))
    sum12 = q[:, j1] + q[:, j2]
    flange = np.stack(
        (
            first * np.cos(q[:, j1]) + second * np.cos(sum12),
            first * np.sin(q[:, j1]) + second * np.sin(sum12),
        ),
        axis=1,
    )
    x, y = (flange @ turn[:2, :2].T + shift[:2]).T
    yaw = sum12 - q[:, j4] + np.arctan2(turn[1, 0], turn[0, 0])
    bend = (x**2 + y**2 - first**2 - second**2) / (2.0 * first * second)
    if np.abs(bend).max() > 1.0:
        return
    for elbow in (1.0, -1.0):
        moved = np.array(q)
        moved[:, j2] = elbow * np.arccos(bend)
        reach = np.arctan2(second * np.sin(moved[:, j2]), first + second * np.cos(moved[:, j2]))
        moved[:, j1] = (np.arctan2(y, x) - reach + np.pi) % (2.0 * np.pi) - np.pi
        last = np.unwrap(moved[:, j1] + moved[:, j2] - yaw)
        moved[:, j4] = last - 2.0 * np.pi * np.round(last.mean() / (2.0 * np.pi))
        yield moved


def place_map(task: Task, robot: Robot, found: Sequence[Postures], quick: bool) -> PlaceMap:
    """Share of postures that the arm carries to each place, with at least one elbow."""
    radii = RADIUS_M[::6] if quick else RADIUS_M
    yaws = YAW_DEG[::6] if quick else YAW_DEG
    world = task.world(robot)
    share = np.zeros((len(yaws), len(radii)))
    for i, yaw in enumerate(yaws.tolist()):
        for k, radius in enumerate(radii.tolist()):
            turn, shift = task.moved(radius, yaw)
            keys = [
                replace(key, rotation=turn @ key.rotation, position=turn @ key.position + shift)
                for key in task.keys
            ]
            able = [
                any(fits(robot, world, q, keys) for q in carried(robot, each.q, turn, shift))
                for each in found
            ]
            share[i, k] = np.mean(able) if able else 0.0
    return PlaceMap(task.scene.name, radii, yaws, share, task.place)


def j4_inertia(task: Task, tilt_deg: float) -> float:
    """Inertia of all that J4 turns, straight hand [kg m^2]."""
    robot = task.robot(Mounting(tilt_deg, 0.2))
    mass = pin.crba(robot.model, robot.model.createData(), pin.neutral(robot.model))
    column = robot.joint_names.index("J4")
    return float(mass[column, column])


def tilt_max_deg(task: Task) -> float:
    """Tilt at which the inertia about J4 reaches its limit."""
    return float(brentq(lambda tilt: j4_inertia(task, tilt) - J4_INERTIA_MAX, 0.0, 60.0, xtol=1e-3))


def common_heights(rows: Iterable[TiltRow]) -> tuple[float, float]:
    """Lowest and highest pedestal [m] with postures in every scene; NaN without any."""
    low, high = (np.array(each) for each in zip(*(row.heights for row in rows), strict=True))
    # NaN compares false.
    both = np.isfinite(low).all() and low.max() <= high.min()
    return (float(low.max()), float(high.min())) if both else (np.nan, np.nan)


def main(quick: bool = False, out: Path = Path("reports/out/analysis/03")) -> dict[str, Any]:
    """Run the study; write ``mounting`` and ``place`` as PDF and PNG, ``reach.json`` into ``out``.

    Args:
        quick: 3 tilts and 10 starts instead of 9 and 100, and few places.
        out: folder.

    Returns:
        What the JSON file holds.
    """
    console, began = Console(markup=False), perf_counter()
    tasks = [Task.of(load_scene(name)) for name in SCENES]
    chosen = Mounting.of(tasks[0].urdf)
    tilts = [15.0, 30.0, 45.0] if quick else TILT_DEG.tolist()
    starts, starts_built = (10, 10) if quick else (100, 160)
    shown = track(tilts, "tilts ", console=console, transient=True)
    rows = {tilt: [tilt_row(task, tilt, starts) for task in tasks] for tilt in shown}
    todo = to_check(chosen, rows)
    shown = track(todo, "checks", console=console, transient=True)
    checked = {
        mounting: [Search.run(task, task.robot(mounting), starts_built) for task in tasks]
        for mounting in shown
    }
    maps = []
    for k, task in enumerate(tasks):
        robot = task.robot(chosen)
        maps.append(place_map(task, robot, checked[chosen][k].found, quick))
    inertia = {tilt: j4_inertia(tasks[0], tilt) for tilt in tilts}
    limit = tilt_max_deg(tasks[0])
    result = {
        "scenes": list(SCENES),
        "chosen": {"tilt_deg": chosen.tilt_deg, "height_m": chosen.height_m},
        "starts": starts,
        "height_m": HEIGHT_M.tolist(),
        "tilt_of_largest_j4_inertia_deg": limit,
        "tilts": [tilt_record(tilt, rows[tilt], inertia[tilt]) for tilt in tilts],
        "checks": [
            {
                "tilt_deg": mounting.tilt_deg,
                "height_m": mounting.height_m,
                "scenes": {n: each.summary() for n, each in zip(SCENES, searches, strict=True)},
            }
            for mounting, searches in checked.items()
        ],
        "places": {each.scene: place_record(each) for each in maps},
    }
    pictured = [mounting_map(name, k, rows, starts) for k, name in enumerate(SCENES)]
    own = (chosen.tilt_deg, 1e3 * chosen.height_m)
    save_figure(mounting_maps(pictured, own=own, tilt_max_deg=limit), out, "mounting")
    save_figure(place_maps(maps), out, "place")
    target = out / "reach.json"
    write_results(target, result)
    tell(console, result)
    console.print(f"{target.parent}: {perf_counter() - began:.0f} s")
    return result


def to_check(chosen: Mounting, rows: Mapping[float, Sequence[TiltRow]]) -> list[Mounting]:
    """The chosen mounting, a pedestal above all that fit, and the tilts next to the chosen one."""
    tilts = sorted(rows)
    place = int(np.argmin(np.abs(np.array(tilts) - chosen.tilt_deg)))
    found = [chosen]
    highest = max((row.heights[1] for row in rows[tilts[place]] if row.search.found), default=0.0)
    if highest:
        found.append(Mounting(chosen.tilt_deg, round(highest + ABOVE_M, 3)))
    for tilt in tilts[max(place - 1, 0) : place + 2]:
        low, high = common_heights(rows[tilt])
        if tilt != chosen.tilt_deg and np.isfinite(low):
            found.append(Mounting(tilt, round((low + high) / 2.0, 3)))
    return found


def tilt_record(tilt_deg: float, rows: Sequence[TiltRow], inertia: float) -> dict[str, Any]:
    """One tilt in all scenes."""
    return {
        "tilt_deg": tilt_deg,
        "offset_m": Mounting(tilt_deg, 0.0).offset_m,
        "j4_inertia_kg_m2": inertia,
        "common_heights_m": list(common_heights(rows)),
        "scenes": {
            name: {
                **row.search.summary(),
                "heights_m": list(row.heights),
                "fitting": [each.found for each in row.cells],
                "singular_value_m": [each.singular_value_m for each in row.cells],
                "clearance_m": [each.clearance_m for each in row.cells],
                "stroke_margin_m": [each.stroke_m for each in row.cells],
            }
            for name, row in zip(SCENES, rows, strict=True)
        },
    }


def place_record(each: PlaceMap) -> dict[str, Any]:
    """One map of places, and the distances to which some posture can be carried at every yaw."""
    everywhere = each.radius[(each.share > 0.0).all(axis=0)]
    return {
        "own": {"radius_m": each.own[0], "yaw_deg": each.own[1]},
        "radius_m": each.radius.tolist(),
        "yaw_deg": each.yaw_deg.tolist(),
        "share": each.share.tolist(),
        "every_yaw_m": [float(r) for r in everywhere],
    }


def mounting_map(
    name: str, place: int, rows: dict[float, list[TiltRow]], starts: int
) -> MountingMap:
    """The figure's panels of one scene, heights by tilts."""
    cells = [[row[place].cells[i] for row in rows.values()] for i in range(len(HEIGHT_M))]

    def grid(attribute: str) -> Array:
        return np.array([[getattr(each, attribute) for each in line] for line in cells])

    return MountingMap(
        name,
        np.array(list(rows)),
        1e3 * HEIGHT_M,
        grid("found") / starts,
        1e3 * grid("stroke_m"),
        1e3 * grid("singular_value_m"),
    )


def tell(console: Console, result: dict[str, Any]) -> None:
    """Print both tables and the answer in words."""
    table = Table(title=f"Postures from {result['starts']} starts, and the pedestals they fit")
    for head in ("tilt [deg]", "wedge [mm]", "J4 [kg m²]", *SCENES, "both"):
        table.add_column(head, justify="right")
    for row in result["tilts"]:
        scenes = [f"{each['found']}: {span(each['heights_m'])}" for each in row["scenes"].values()]
        wedge, inertia = 1e3 * (row["offset_m"] - DISC_M), row["j4_inertia_kg_m2"]
        numbers = (f"{row['tilt_deg']:g}", f"{wedge:.1f}", f"{inertia:.3f}")
        table.add_row(*numbers, *scenes, span(row["common_heights_m"]))
    console.print(table)
    table = Table(title="Searched on the arm as built")
    for head in ("tilt [deg]", "pedestal [m]", "scene", "found", "95 %", "best H", "clearance"):
        table.add_column(head, justify="right")
    for row in result["checks"]:
        for name, each in row["scenes"].items():
            low, high = each["interval_95"]
            table.add_row(
                f"{row['tilt_deg']:g}",
                f"{row['height_m']:.3f}",
                name,
                f"{each['found']} / {each['starts']}",
                f"{low:.0%}-{high:.0%}",
                millimetres(each["best_singular_value_m"]),
                millimetres(each["best_clearance_m"]),
            )
    console.print(table)
    console.print(answer(result))


def span(heights: Sequence[float]) -> str:
    """A range of heights as text."""
    low, high = heights
    return f"{low:.2f}-{high:.2f} m" if np.isfinite(low) else "-"


def millimetres(length_m: float) -> str:
    """A length as text, a dash if there is none."""
    return f"{1e3 * length_m:.2f} mm" if np.isfinite(length_m) else "-"


def answer(result: dict[str, Any]) -> str:
    """Which choice follows, and why."""
    able = [row for row in result["tilts"] if np.isfinite(row["common_heights_m"][0])]
    if not able:
        return "No tilt has a pedestal with postures in both scenes: too few starts."
    limit, chosen = result["tilt_of_largest_j4_inertia_deg"], result["chosen"]
    light = [row for row in able if row["tilt_deg"] <= limit]
    text = "Pedestals with postures in both scenes exist at " + listed(able)
    text += f"; the inertia about J4 allows {limit:.1f} deg, which leaves {listed(light)}. "
    best = max(result["checks"], key=fewest)
    text += f"Of those searched as built, {best['tilt_deg']:g} deg, {best['height_m']:g} m finds "
    text += "most where it finds least. "
    text += f"Chosen: {chosen['tilt_deg']:g} deg, {chosen['height_m']:g} m."
    for name, each in result["places"].items():
        radii = each["every_yaw_m"]
        where = f"{radii[0]:.2f}-{radii[-1]:.2f} m" if radii else "no distance"
        text += f" {name}: grasp {each['own']['radius_m']:.2f} m from J1; at every yaw a posture "
        text += f"can be carried to {where}."
    return text


def fewest(check: Mapping[str, Any]) -> int:
    """Postures found in the scene with the fewest."""
    return min(int(each["found"]) for each in check["scenes"].values())


def listed(rows: Sequence[dict[str, Any]]) -> str:
    """Their tilts as text."""
    return ", ".join(f"{row['tilt_deg']:g}" for row in rows) + " deg" if rows else "none"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="3 tilts, 10 starts, few places")
    parser.add_argument("--out", type=Path, default=Path("reports/out/analysis/03"))
    given = parser.parse_args()
    main(given.quick, given.out)
