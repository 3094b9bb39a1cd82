"""Where a scene's first removal begins."""

from __future__ import annotations

from pivotgait.feasibility import rehearse
from pivotgait.models import RemovalPhase, Scene
from pivotgait.phases.grasp import Grasp


def before_removal(scene: Scene) -> tuple[Grasp, RemovalPhase]:
    """The grasp before the first removal, and what the scene asks for."""
    configs = scene.gaits["default"]
    place = next(k for k, each in enumerate(configs) if isinstance(each, RemovalPhase))
    phases = rehearse(scene, configs[:place]).phases
    places = {each.contact: each for each in configs[:place] if hasattr(each, "contact")}
    lift = configs[0]
    names = [*lift.contacts, *(n for n, e in places.items() if e.kind == "addition")]
    fingers = {scene.contacts[n].finger: scene.contacts[n] for n in names}
    config = configs[place]
    assert isinstance(config, RemovalPhase)
    return Grasp.after(phases[-1].tool, fingers, phases[-1].contacts), config
