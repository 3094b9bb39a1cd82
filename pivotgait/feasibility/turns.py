"""The smallest turn of the tool after which some fingers hold it at rest: a global search.

Statics does not change when everything turns about the vertical: what counts of a turn is its
tilt, about a horizontal axis. Two numbers, its direction and size, are few enough to scan. Where
the orientations that can be held form a strip narrower than the scan's nodes lie apart, the depth
still rises towards it: from the best headings of every size it is climbed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.frozen import Array
from pivotgait.models import HandleContact, Scene

TURN_MAX_RAD = np.radians(60.0)
DIRECTIONS, STEP_RAD = 32, np.radians(1.5)
"""Of the scan."""
COARSER = 4
"""The step of a coarse scan over that of a full one."""
REFINEMENTS, FINER, AROUND = 5, 7, 5
"""Rounds of refinement about the best nodes, and nodes of each by size and about each heading."""
HEADINGS = 8
"""Most headings that a round of refinement goes on from."""
CRESTS, CREST_ROUNDS, CREST_NODES = 2, 3, 9
"""Headings of each size that are nearly good and may lie beside a narrow patch; rounds and nodes
of the search for it by heading alone."""
BEYOND_RAD = np.radians(1e-3)
"""The tool is turned so much further than the edge of what can be held."""


@dataclass(frozen=True, eq=False)
class Turn:
    """Answer of :func:`smallest_tilt`.

    Attributes:
        feasible: whether there is one within the range of the search.
        angle: of the smallest tilt [rad]; that of the most nearly feasible one if there is none.
        rotation: the tool's orientation after it, world <- tool.
        depth: of the grasp there [N], see :class:`StaticVerdicts`; negative if infeasible.
    """

    feasible: bool
    angle: float
    rotation: Rotation
    depth: float


def held_at(scene: Scene, fingers: Sequence[HandleContact], rotation: Rotation) -> Grasps:
    """The scene's tool held by fingers at rest in one or B orientations, friction as usable.

    Args:
        scene: tool, table and the friction that plans may use.
        fingers: that touch.
        rotation: world <- tool.
    """
    usable = 1.0 - scene.allocation.friction_reserve
    table = scene.table
    return Grasps.resting(
        [finger.finger for finger in fingers],
        np.atleast_3d(rotation.as_matrix()).reshape(-1, 3, 3),
        scene.tool.pivot_in_tool,
        np.stack([finger.point for finger in fingers]),
        np.stack([finger.normal for finger in fingers]),
        scene.tool.mass * scene.gravity,
        friction=usable * np.array([table.friction, *(f.friction for f in fingers)]),
        normal_min=np.array([table.normal_min, *(f.normal_min for f in fingers)]),
        normal_max=np.array([table.normal_max, *(f.normal_max for f in fingers)]),
    )


def smallest_tilt(
    scene: Scene,
    fingers: Sequence[HandleContact],
    start: Rotation,
    *,
    turn_max_rad: float = TURN_MAX_RAD,
    coarse: bool = False,
) -> Turn:
    """The smallest tilt from ``start`` after which the fingers hold the tool, clear of the table.

    Args:
        scene: tool, table, limits.
        fingers: that stay.
        start: orientation before, world <- tool.
        turn_max_rad: largest tilt tried.
        coarse: whether there is one at all is enough: fewer nodes, no refinement.
    """
    step, directions = (COARSER * STEP_RAD, DIRECTIONS // 2) if coarse else (STEP_RAD, DIRECTIONS)
    sizes = np.append(np.arange(0.0, turn_max_rad, step), turn_max_rad)
    ways = np.arange(directions) * 2.0 * np.pi / directions
    spread = 2.0 * np.pi / directions
    size, way = (grid.reshape(-1) for grid in np.meshgrid(sizes, ways, indexing="ij"))
    depth = _depths(scene, fingers, start, size, way)
    good = depth >= 0.0
    found = float(size[int(np.argmax(good))]) if good.any() else np.inf  # sizes ascend
    # every heading that is good at that size may lead to a smaller one
    headings = _some(way[good & (size == found)])
    patch = None
    if found > 0.0 and not coarse:
        nearer = sizes[sizes < found]
        crests = _crests(depth.reshape(len(sizes), -1)[: len(nearer)], ways)
        patch = _narrow_patch(scene, fingers, start, nearer, crests, spread)
    if patch is not None:
        found, heading = _refined_narrow(scene, fingers, start, patch, step, spread)
        headings = np.array([heading])
    elif not np.isfinite(found):
        best = int(np.argmax(depth))
        return Turn(False, size[best], _tilted(start, size[best], way[best]), float(depth[best]))
    elif found > 0.0 and not coarse:
        found, headings = _refined(scene, fingers, start, found, headings, step, spread)
    heading = float(headings[0])
    if found > 0.0 and not coarse:
        further = min(found + BEYOND_RAD, turn_max_rad)
        if _depths(scene, fingers, start, np.array([further]), np.array([heading]))[0] >= 0.0:
            found = further
    end = _depths(scene, fingers, start, np.array([found]), np.array([heading]))
    return Turn(True, found, _tilted(start, found, heading), float(end[0]))


def _refined(
    scene: Scene,
    fingers: Sequence[HandleContact],
    start: Rotation,
    found: float,
    headings: Array,
    step: float,
    spread: float,
) -> tuple[float, Array]:
    """A smaller size that is good about some headings, and the headings that are good there."""
    for _ in range(REFINEMENTS):
        nearer = np.linspace(max(found - step, 0.0), found, FINER)
        about = headings[:, None] + spread * np.linspace(-1.0, 1.0, AROUND)
        about = np.unique(np.round(np.mod(about, 2.0 * np.pi), 9))
        size, way = (grid.reshape(-1) for grid in np.meshgrid(nearer, about, indexing="ij"))
        good = _depths(scene, fingers, start, size, way) >= 0.0
        if good.any():
            found = float(size[int(np.argmax(good))])
            headings = _some(way[good & (size == found)])
        step, spread = step / (FINER - 1), 0.5 * spread
    return found, headings


def _refined_narrow(
    scene: Scene,
    fingers: Sequence[HandleContact],
    start: Rotation,
    patch: tuple[float, float],
    step: float,
    spread: float,
) -> tuple[float, float]:
    """The same in a patch so narrow that its heading is climbed to anew at every size."""
    for _ in range(REFINEMENTS):
        found, heading = patch
        nearer = np.linspace(max(found - step, 0.0), found, FINER)[:-1]
        about = np.full((len(nearer), 1), heading)
        patch = _narrow_patch(scene, fingers, start, nearer, about, spread) or patch
        step /= FINER - 1
    return patch


def _crests(depth: Array, ways: Array) -> Array:
    """(S, k) headings at which the depth (S, W) is largest among its neighbours, the best first."""
    crest = (depth >= np.roll(depth, 1, axis=1)) & (depth > np.roll(depth, -1, axis=1))
    ranked = np.argsort(-np.where(crest, depth, -np.inf), axis=1, kind="stable")
    return np.asarray(ways[ranked[:, :CRESTS]])


def _narrow_patch(
    scene: Scene,
    fingers: Sequence[HandleContact],
    start: Rotation,
    sizes: Array,
    headings: Array,
    spread: float,
) -> tuple[float, float] | None:
    """The smallest size, and its heading, that is good at some heading near the given ones.

    For every size (S,) and heading (S, k) the depth is climbed by heading alone, all at once.
    """
    size = np.repeat(sizes, headings.shape[1]) if headings.size else np.empty(0)
    best, found = headings.reshape(-1), None
    for _ in range(CREST_ROUNDS):
        if not size.size:
            break
        about = best[:, None] + spread * np.linspace(-1.0, 1.0, CREST_NODES)
        nodes = np.repeat(size, CREST_NODES)
        depth = _depths(scene, fingers, start, nodes, about.reshape(-1), exact=True)
        good = depth >= 0.0
        if good.any():
            first = int(np.argmax(good))
            found = float(nodes[first]), float(about.reshape(-1)[first])
        # a smaller one may come to light at a finer heading
        top = np.argmax(depth.reshape(about.shape), axis=1)
        left = size < (np.inf if found is None else found[0])
        size, best = size[left], about[np.arange(len(about)), top][left]
        spread *= 2.0 / (CREST_NODES - 1)
    return found


def _some(headings: Array) -> Array:
    """At most :data:`HEADINGS` of them, spread evenly."""
    picks = np.linspace(0, len(headings) - 1, min(len(headings), HEADINGS))
    return np.asarray(headings[picks.round().astype(int)])


def _tilted(start: Rotation, size: Array | float, way: Array | float) -> Rotation:
    axis = np.stack((np.cos(way), np.sin(way), np.zeros_like(way)), axis=-1)
    return Rotation.from_rotvec(np.asarray(size)[..., None] * axis) * start


def _depths(
    scene: Scene,
    fingers: Sequence[HandleContact],
    start: Rotation,
    size: Array,
    way: Array,
    *,
    exact: bool = False,
) -> Array:
    """(N,) depths [N], unless ``exact`` of the right sign only; minus infinity near the table."""
    turned = _tilted(start, size, way)
    clear = np.asarray(scene.height(turned)) >= scene.clearance
    depth = np.full(len(size), -np.inf)
    if clear.any():
        verdicts = static_verdicts(held_at(scene, fingers, turned[clear]), exact=exact)
        inside = np.maximum(verdicts.depth, 0.0)
        depth[clear] = np.where(verdicts.feasible, inside, np.minimum(verdicts.depth, -1e-12))
    return depth
