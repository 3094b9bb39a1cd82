"""Checks of a study that no single field can fail."""

from __future__ import annotations

from pivotgait.exceptions import UnknownNameError
from pivotgait.models import Scene
from pivotgait.models.parameters import MASS_SCALE, Place, places_of
from pivotgait.sweeps.cells import CellSpace
from pivotgait.sweeps.errors import StudyError, of_a_study
from pivotgait.sweeps.scene_family import base_fields
from pivotgait.sweeps.study_config import StudyConfig
from pivotgait.validation.controllers import check_controller
from pivotgait.validation.simulator import check_simulator

MAX_CELLS = 10**12


def check_study(config: StudyConfig, scene: Scene, cells: CellSpace, where: str) -> None:
    """Check a study's fields against one another and against its scene.

    Raises:
        StudyError: naming the field.
        UnknownNameError: a gait, contact, parameter, simulator or controller there is not.
    """
    if config.gait is not None and config.gait not in scene.gaits:
        raise UnknownNameError("gait", config.gait, scene.gaits, where=f"{where}: gait")
    _check_compute(config, scene, where)
    _check_draws(config, cells, where)
    if cells.count > MAX_CELLS:
        what = f"has {cells.count:,} cells"
        raise StudyError(what, where=f"{where}: axes", mend=f"stay below {MAX_CELLS:,}")
    _check_parameters(config, scene, where)


def _check_compute(config: StudyConfig, scene: Scene, where: str) -> None:
    compute = config.compute
    for name in ("static", "trials"):
        if getattr(config, name) is not None and compute != name:
            what = f"is for compute: {name}, this study computes {compute}"
            raise StudyError(what, where=f"{where}: {name}", mend="leave it out")
    if config.static is not None and config.static.contacts is not None:
        _check_contacts(config.static.contacts, scene, f"{where}: static.contacts")
    phases = base_fields(config, scene)["gaits"]["default"]
    if compute == "removal" and all(phase["kind"] != "removal" for phase in phases):
        mend = "choose another gait"
        raise StudyError("the gait has no removal", where=f"{where}: compute", mend=mend)
    if compute == "trials":
        given = config.trials
        if scene.robot is None:
            mend = "choose another scene"
            raise StudyError("trials need a robot", where=f"{where}: compute", mend=mend)
        if given is not None:
            check_simulator(given.simulator)
            check_controller(given.controller)


def _check_contacts(contacts: tuple[str, ...], scene: Scene, at: str) -> None:
    fingers: set[str] = set()
    for contact in contacts:
        if contact not in scene.contacts:
            raise UnknownNameError("contact", contact, scene.contacts, where=at)
        finger = scene.contacts[contact].finger
        if finger in fingers:
            what = f"finger {finger!r} touches twice"
            raise StudyError(what, where=at, mend="leave one of its contacts out")
        fingers.add(finger)


def _check_draws(config: StudyConfig, cells: CellSpace, where: str) -> None:
    drawn = [axis.parameter for axis in cells.axes if axis.drawn]
    if drawn and config.draws is None:
        what = f"is missing: axes.{drawn[0]} is a distribution"
        raise StudyError(what, where=f"{where}: draws", mend="say how often it is drawn")
    if config.draws is not None and not drawn and config.compute != "trials":
        what = "there is no distribution to draw from"
        raise StudyError(what, where=f"{where}: draws", mend="leave it out")


def _check_parameters(config: StudyConfig, scene: Scene, where: str) -> None:
    """Every parameter is one of the scene, of the right kind, and set once."""
    fields = base_fields(config, scene)
    setters: dict[Place | str, str] = {}
    given = [(f"set.{name}", name, False) for name in config.set]
    given += [(f"axes.{name}", name, axis.names is not None) for name, axis in config.axes.items()]
    for field, parameter, named in given:
        at = f"{where}: {field}"
        if parameter == MASS_SCALE and config.compute == "trials":
            mend = "vary validation.mass_share"
            raise StudyError("trials take the tool's mass from its URDF", where=at, mend=mend)
        with of_a_study():
            places = places_of(parameter, fields, where=at)
        for place in places or (parameter,):
            if place in setters:
                what = f"sets what {setters[place]} sets, too"
                raise StudyError(what, where=at, mend="leave one of them out")
            setters[place] = field
        _check_kind(places, fields, named=named, at=at)


def _check_kind(places: tuple[Place, ...], fields: object, *, named: bool, at: str) -> None:
    for place in places:
        node = fields
        for key in place:
            node = node[key]  # type: ignore[index]
        if isinstance(node, str) != named:
            what = f"holds {node!r}, the study gives {'names' if named else 'numbers'}"
            mend = "use names: [...]" if not named else "use values: [...]"
            raise StudyError(what, where=at, mend=mend)
