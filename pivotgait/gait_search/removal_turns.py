"""The attitudes in which the fingers that stay after a removal hold the tool, known once found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from scipy.spatial.transform import Rotation

from pivotgait.feasibility.turns import Turn, smallest_tilt
from pivotgait.gait_search.candidates import Candidate
from pivotgait.gait_search.static_tests import grasp_depths
from pivotgait.models import Scene

NEARLY_N = 0.05
"""A coarse scan that comes so near to a good attitude may have missed a narrow patch."""


class RemovalTurns:
    """Smallest tilts of a tool that some fingers go on holding.

    Args:
        scene: tool, table, limits.
        coarse_from: for a rough answer, the attitude from which tilts are looked for whatever the
            one before; each set of fingers is then asked for only once. None for the exact one.
    """

    def __init__(self, scene: Scene, coarse_from: Rotation | None = None) -> None:
        self._scene, self._coarse_from = scene, coarse_from
        self._known: dict[tuple[tuple[str, ...], bytes], Turn] = {}

    def __call__(self, staying: Sequence[Candidate], rotation: Rotation) -> Turn:
        """The turn from an attitude."""
        if self._coarse_from is None:
            return self._found(staying, rotation)
        contacts = [each.contact for each in staying]
        depth = float(grasp_depths(self._scene, [contacts], rotation, exact=False)[0])
        if depth >= 0.0:
            return Turn(True, 0.0, rotation, depth)
        found = self._found(staying, self._coarse_from, coarse=True)
        return replace(found, angle=float((found.rotation * rotation.inv()).magnitude()))

    def _found(
        self, staying: Sequence[Candidate], rotation: Rotation, *, coarse: bool = False
    ) -> Turn:
        key = tuple(each.name for each in staying), rotation.as_quat().tobytes()
        if key not in self._known:
            contacts = [each.contact for each in staying]
            turn = smallest_tilt(self._scene, contacts, rotation, coarse=coarse)
            if coarse and not turn.feasible and turn.depth > -NEARLY_N:
                turn = smallest_tilt(self._scene, contacts, rotation)
            self._known[key] = turn
        return self._known[key]
