"""A found sequence as a scene: the file from which ``pivotgait plan`` makes the same gait."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from pivotgait.frozen import Array
from pivotgait.gait_search.candidates import Candidate
from pivotgait.gait_search.states import Move
from pivotgait.gait_search.timing import STAND_OFF_M, PhaseStyle
from pivotgait.models import Robot, Scene, parse_scene

_OWN = {"posture", "posture_before"}
"""Fields that one phase has for itself: no other phase is written like them."""
GAIT = "default"
"""Every scene has a gait of this name; a found scene has no other."""
_OPEN = (
    "",
    "tool",
    "table",
    "rest",
    "robot",
    "robot.fingers",
    "contacts",
    "gaits",
    f"gaits.{GAIT}",
)
"""Parts of a scene's file that go over several lines."""


@dataclass(frozen=True, eq=False)
class FoundScene:
    """A scene and the text of its file.

    Attributes:
        scene: with the found sequence as its only gait.
        text: YAML.
        move_of: for each phase of the gait, the place of the move it belongs to.
    """

    scene: Scene
    text: str
    move_of: tuple[int, ...]


def found_scene(
    scene: Scene,
    moves: Sequence[Move],
    *,
    name: str,
    description: str,
    comment: str,
    home: Array | None = None,
    postures: Sequence[Array] = (),
    folder: Path | None = None,
) -> FoundScene:
    """The scene of a sequence of moves.

    Args:
        scene: that was searched.
        moves: from the table to the goal.
        name: of the new scene.
        description: of the new scene, a sentence or two.
        comment: first line of the file.
        home: (nv,) posture of the hand in the middle of the gait, about which half of the starts
            of a plan's search are drawn; the scene's own without it.
        postures: of the hand at the key poses of each move, (k, nv) each; suggested to the plan.
        folder: in which relative URDF paths start.
    """
    phases, move_of = gait_phases(scene, moves)
    fields = scene.config.model_dump(mode="json", by_alias=True, exclude_unset=True)
    fields["name"], fields["description"] = name, description
    fields["contacts"] = _contact_fields(scene, moves)
    fields["gaits"] = {GAIT: phases}
    if scene.robot is not None:
        if home is not None:
            fields["robot"]["home"] = _by_joint(scene.robot, home)
        if postures:
            _suggest(phases, move_of, postures, scene.robot)
    text = f"# {comment}\n{_yaml(fields)}"
    return FoundScene(parse_scene(text, where=name, folder=folder), text, move_of)


def gait_phases(
    scene: Scene, moves: Sequence[Move]
) -> tuple[list[dict[str, Any]], tuple[int, ...]]:
    """The phases of a gait as a scene's file has them, and the place of the move of each."""
    style = PhaseStyle.of(scene)
    phases: list[dict[str, Any]] = []
    move_of: list[int] = []
    left: dict[str, str] = {}  # finger that holds nothing -> contact it last had
    for place, move in enumerate(moves):
        for phase in _phases(style, move, left, relocated=scene.robot is not None):
            phases.append(phase)
            move_of.append(place)
        for each in move.contacts:
            left.pop(each.finger, None)
            if move.kind == "removal":
                left[each.finger] = each.name
    return phases, tuple(move_of)


def _phases(
    style: PhaseStyle, move: Move, left: dict[str, str], *, relocated: bool
) -> Iterable[dict[str, Any]]:
    """A new kind of move gets a branch here, in :class:`Moves` and in ``PhaseStyle``."""
    relocation = style.relocation.model_dump(mode="json", exclude_unset=True, exclude=_OWN)
    names = [each.name for each in move.contacts]
    if move.kind == "lift":
        lift = style.lift.model_dump(mode="json", exclude=_OWN)
        assert move.target is not None
        yield {**lift, "contacts": names, "to": move.target.model_dump(mode="json")}
        return
    if move.kind == "transfer":
        for contact in left.values() if relocated else ():
            yield {**relocation, "contact": contact, "standoff_m": STAND_OFF_M}
        yield style.transfer.model_dump(mode="json")
        return
    if move.kind == "addition" and relocated:
        yield {**relocation, "contact": names[0]}
    like = style.addition if move.kind == "addition" else style.removal
    yield {**like.model_dump(mode="json", exclude_unset=True, exclude=_OWN), "contact": names[0]}


def _contact_fields(scene: Scene, moves: Sequence[Move]) -> dict[str, Any]:
    """Contacts that the sequence uses, each once, in the order of their use."""
    used: dict[str, Candidate] = {}
    for move in moves:
        used.update({each.name: each for each in move.contacts})
    return {
        name: {
            "finger": each.finger,
            "along_m": each.along_m,
            "around_deg": each.around_deg,
            "friction": each.contact.friction,
            "normal_force_N": {"min": each.contact.normal_min, "max": each.contact.normal_max},
            **({"torsion_m": each.contact.torsion} if each.contact.torsion else {}),
        }
        for name, each in used.items()
    }


def _suggest(
    phases: Sequence[dict[str, Any]],
    move_of: Sequence[int],
    postures: Sequence[Array],
    robot: Robot,
) -> None:
    for phase, place in zip(phases, move_of, strict=True):
        if phase["kind"] in ("lift", "removal", "relocation"):
            phase["posture"] = _by_joint(robot, postures[place][-1])
        if phase["kind"] == "lift":
            phase["posture_before"] = _by_joint(robot, postures[place][0])


def _by_joint(robot: Robot, q: Array) -> dict[str, float]:
    return {
        joint: _rounded(float(value), *limits)
        for joint, value, *limits in zip(
            robot.joint_names, q, robot.lower, robot.upper, strict=True
        )
    }


def _rounded(value: float, lower: float, upper: float) -> float:
    """Three digits are enough for a start of a search; limits must be kept."""
    short = round(value, 3)
    return short if lower <= short <= upper else value


def _yaml(fields: dict[str, Any]) -> str:
    yaml, stream = YAML(), StringIO()
    yaml.width = 4096
    yaml.dump(_styled(fields, ""), stream)
    return stream.getvalue()


def _styled(node: Any, path: str) -> Any:
    """Parts of the file that stand alone on lines of their own, all others in one line."""
    if isinstance(node, dict):
        mapping = CommentedMap(
            {key: _styled(each, f"{path}.{key}".strip(".")) for key, each in node.items()}
        )
        if path not in _OPEN:
            mapping.fa.set_flow_style()
        return mapping
    if isinstance(node, list):
        sequence = CommentedSeq([_styled(each, f"{path}[]") for each in node])
        if path not in _OPEN:
            sequence.fa.set_flow_style()
        return sequence
    return node
