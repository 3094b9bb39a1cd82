"""Tools, table and scenes: loaded from URDF and YAML, checked before native code sees them."""

from pivotgait.models.handle import Handle, SurfacePoint
from pivotgait.models.paths import model_names, urdf_root
from pivotgait.models.rest import attitude, rest_pitch
from pivotgait.models.robot import Finger, Robot
from pivotgait.models.scene import HandleContact, Scene, Table
from pivotgait.models.scene_config import (
    AdditionPhase,
    AllocationConfig,
    LiftPhase,
    LiftTarget,
    PhaseConfig,
    RelocationPhase,
    RemovalPhase,
    RemovalWeights,
    SceneConfig,
    TransferPhase,
)
from pivotgait.models.scene_loading import (
    builtin_scenes,
    export_scene,
    load_scene,
    parse_scene,
    revise_scene,
    scene_folder,
    scene_schema,
)
from pivotgait.models.shape import Shape
from pivotgait.models.tool import Tool, load_tool

__all__ = [
    "AdditionPhase",
    "AllocationConfig",
    "Finger",
    "Handle",
    "HandleContact",
    "LiftPhase",
    "LiftTarget",
    "PhaseConfig",
    "RelocationPhase",
    "RemovalPhase",
    "RemovalWeights",
    "Robot",
    "Scene",
    "SceneConfig",
    "Shape",
    "SurfacePoint",
    "Table",
    "Tool",
    "TransferPhase",
    "attitude",
    "builtin_scenes",
    "export_scene",
    "load_scene",
    "load_tool",
    "model_names",
    "parse_scene",
    "rest_pitch",
    "revise_scene",
    "scene_folder",
    "scene_schema",
    "urdf_root",
]
