"""One contact in the scene: its force, its friction cone and, without a robot, its fingertip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.contacts import contact_frame
from pivotgait.frozen import Array
from pivotgait.margins.gait import LEAST_FORCE_N
from pivotgait.plotting import mesh
from pivotgait.viewing.frames import ContactFrames
from pivotgait.viewing.solids import add_faces, rgb

if TYPE_CHECKING:
    from viser import SceneApi

_CONE_HEIGHT = 0.025
_SHAFT_RADIUS, _HEAD_RADIUS, _HEAD_LENGTH = 0.0013, 0.0035, 0.009


class ContactNodes:
    """Nodes of one contact.

    Args:
        scene: of a viser server.
        name: unique in the scene.
        contact: its places and forces.
        colour: ``#rrggbb``.
        tip_radius: of the fingertip to draw [m], 0 for none.
        metres_per_newton: length of the arrow.
    """

    def __init__(
        self,
        scene: SceneApi,
        name: str,
        contact: ContactFrames,
        *,
        colour: str,
        tip_radius: float,
        metres_per_newton: float,
    ) -> None:
        track = contact.track
        self._contact, self._metres_per_newton = contact, metres_per_newton
        holder = "" if track.is_pivot else "/tool"
        axis = track.normal if track.is_pivot else -track.normal
        self._cone = add_faces(
            scene,
            f"{holder}/cone_{name}",
            mesh.cone(_CONE_HEIGHT, track.friction),
            colour,
            opacity=0.22,
            position=track.point,
            wxyz=_upright(axis),
        )
        self._arrow = scene.add_frame(f"/force_{name}", show_axes=False)
        shaft = mesh.cylinder(_SHAFT_RADIUS, 1.0, 1.0) + np.array([0.0, 0.0, 0.5])
        head = mesh.revolve([[0.0, 0.0], [_HEAD_RADIUS, 0.0], [0.0, _HEAD_LENGTH]])
        self._shaft = add_faces(scene, f"/force_{name}/shaft", shaft, colour)
        self._head = add_faces(scene, f"/force_{name}/head", head, colour)
        # a viewer may show a node one frame before it changes its size
        self._stretch(LEAST_FORCE_N * metres_per_newton)
        self._tip = None
        if tip_radius > 0.0:
            self._tip = scene.add_icosphere(
                f"{holder}/tip_{name}",
                tip_radius,
                rgb(colour),
                position=track.point - tip_radius * track.normal,
            )

    def show(self, frame: int) -> None:
        """Show what there is of the contact at a frame."""
        point, force = self._contact.point[frame], self._contact.force[frame]
        size = float(np.linalg.norm(force))
        exists = bool(np.isfinite(point[0]))
        loaded = exists and size > LEAST_FORCE_N
        self._cone.visible = self._arrow.visible = loaded
        if self._tip is not None:
            self._tip.visible = exists
        if loaded:
            length = size * self._metres_per_newton
            # as in the pictures: fingers push from outside, the table's arrow stands on it
            tail = point if self._contact.track.is_pivot else point - force / size * length
            place(self._arrow, tail, _upright(force / size))
            self._stretch(length)

    def _stretch(self, length: float) -> None:
        """Make the arrow ``length`` long [m]; a short one shrinks as a whole."""
        size = min(1.0, length / (2.0 * _HEAD_LENGTH))
        shaft = length - size * _HEAD_LENGTH
        self._shaft.scale = (size, size, shaft)
        self._head.scale = size
        self._head.position = np.array([0.0, 0.0, shaft])


def place(node: Any, position: Array, wxyz: Array) -> None:
    """Put a viser node at a position [m] and orientation (unit quaternion, scalar first)."""
    node.position, node.wxyz = position, wxyz


def _upright(direction: Array) -> Array:
    """Orientation (4,) of a frame whose z axis is the unit vector ``direction`` (3,)."""
    return np.asarray(Rotation.from_matrix(contact_frame(direction)).as_quat(scalar_first=True))
