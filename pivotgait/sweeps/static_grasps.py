"""``compute: static``: can the contacts hold the lifted tool at rest, and with what margin?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pivotgait.feasibility import Grasps, static_verdicts
from pivotgait.frozen import Array
from pivotgait.models import HandleContact, LiftPhase, Scene
from pivotgait.phases.grasp import Setting
from pivotgait.sweeps.cells import Cell
from pivotgait.sweeps.outcome import Columns, Outcome, failed
from pivotgait.sweeps.scene_family import SceneFamily

STATIC_COLUMNS: Columns = {"feasible": "bool", "depth_N": "float", "binding": "text"}


@dataclass(frozen=True, eq=False)
class _Held:
    """A tool, lifted, and the fingers that hold it."""

    scene: Scene
    lift: LiftPhase
    fingers: tuple[HandleContact, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(finger.finger for finger in self.fingers)

    @property
    def rotation(self) -> Array:
        """(3, 3) world <- tool."""
        return self.scene.lift_rotation(self.lift.to).as_matrix()

    @property
    def friction(self) -> Array:
        """(1 + n,) of pivot and fingers, without the scene's reserve."""
        return Setting.of(self.scene).usable_friction(self.fingers)

    def bounds(self, which: str) -> list[float]:
        """(1 + n,) ``normal_min`` or ``normal_max`` of pivot and fingers [N]."""
        return [getattr(each, which) for each in (self.scene.table, *self.fingers)]


class StaticGrasps:
    """Verdicts on grasps after the lift, solved together.

    Args:
        family: makes the scenes.
        contacts: names of those that hold the tool; None for those of the gait's lift.
    """

    def __init__(self, family: SceneFamily, contacts: tuple[str, ...] | None) -> None:
        self._family, self._contacts = family, contacts

    def outcomes(self, cells: Sequence[Cell]) -> list[Outcome]:
        """Of some cells; ``depth_N`` is by how much every limit could be tightened at once [N],
        negative where they must be loosened, minus infinity where that does not help; ``binding``
        is the limit that keeps it from being more: its kind and contact."""
        found: dict[int, Outcome] = {}
        groups: dict[tuple[str, ...], dict[int, _Held]] = {}
        for place, cell in enumerate(cells):
            try:
                held = self._held(cell)
            except Exception as error:  # it is this cell's result
                found[place] = failed(error)
            else:
                groups.setdefault(held.names, {})[place] = held
        for group in groups.values():
            found.update(zip(group, _judge(list(group.values())), strict=True))
        return [found[place] for place in range(len(cells))]

    def _held(self, cell: Cell) -> _Held:
        scene = self._family.scene(cell.values)
        lift = next(p for p in scene.gaits["default"] if isinstance(p, LiftPhase))
        names = self._contacts or lift.contacts
        return _Held(scene, lift, tuple(scene.contacts[name] for name in names))


def _judge(tools: Sequence[_Held]) -> list[Outcome]:
    grasps = Grasps.resting(
        tools[0].names,
        np.stack([each.rotation for each in tools]),
        tools[0].scene.tool.pivot_in_tool,
        np.stack([[finger.point for finger in each.fingers] for each in tools]),
        np.stack([[finger.normal for finger in each.fingers] for each in tools]),
        np.stack([each.scene.tool.mass * each.scene.gravity for each in tools]),
        friction=np.stack([each.friction for each in tools]),
        normal_min=np.array([each.bounds("normal_min") for each in tools]),
        normal_max=np.array([each.bounds("normal_max") for each in tools]),
    )
    verdicts = static_verdicts(grasps, exact=True)
    return [
        Outcome(
            "done",
            "",
            {
                "feasible": bool(verdicts.feasible[k]),
                "depth_N": float(verdicts.depth[k]),
                "binding": " ".join(verdicts.tightest[k]).strip(),
            },
        )
        for k in range(len(tools))
    ]
