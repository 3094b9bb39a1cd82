"""The nodes of a gait's scene, and how they move from frame to frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pivotgait.margins.gait import LEAST_FORCE_N
from pivotgait.models.shape import Shape
from pivotgait.models.urdf import check_urdf
from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.picture import LONGEST_ARROW, Moment, look_at, tip_radii
from pivotgait.plotting.robot import part_colours
from pivotgait.plotting.shapes import material
from pivotgait.plotting.style import contact_colours
from pivotgait.plotting.timeline import phase_title
from pivotgait.viewing.contact_nodes import ContactNodes, place
from pivotgait.viewing.frames import ContactFrames, Frames
from pivotgait.viewing.solids import add_shape

if TYPE_CHECKING:
    from viser import SceneApi, ViserServer

_TABLE = (240, 237, 230)
_LINES = (215, 210, 198)
_FIELD_OF_VIEW = float(np.radians(40.0))


class GaitScene:
    """A gait in a viser scene: table, tool, arm-hand, forces and friction cones.

    Args:
        scene: of a viser server.
        plan: the gait.
        moments: its bodies and forces at even times.

    Raises:
        UrdfError: if a URDF of the plan is broken.
    """

    def __init__(self, scene: SceneApi, plan: GaitPlan, moments: Frames) -> None:
        self.plan, self.moments = plan, moments
        self._colours = contact_colours(plan)
        largest = max(
            (float(np.linalg.norm(c.force, axis=1).max()) for c in moments.contacts), default=0.0
        )
        self._add_table(scene)
        self._tool = self._add_tool(scene)
        self._links = self._add_robot(scene)
        self._forces = [
            ContactNodes(
                scene,
                f"{each.track.name}_{number}",
                each,
                colour=self._colours[each.track.name],
                tip_radius=self._tip_radius(each),
                metres_per_newton=LONGEST_ARROW / max(largest, LEAST_FORCE_N),
            )
            for number, each in enumerate(moments.contacts)
        ]
        self.show(0)

    def aim(self, server: ViserServer) -> None:
        """Let cameras of ``server`` begin as in the pictures: where most fingertips are seen."""
        phases = self.plan.phases
        shown = [Moment(phases[0], 0)]
        shown += [Moment(phase, len(phase.time) - 1) for phase in phases]
        look = look_at(self.plan, shown, hand=True)
        points = np.concatenate(
            [s.faces.reshape(-1, 3) for moment in shown for s in look.bodies(moment)]
        )
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        radius = float(np.linalg.norm(points - middle, axis=1).max())
        distance = 1.15 * radius / np.tan(_FIELD_OF_VIEW / 2)
        server.initial_camera.position = middle + distance * look.camera.axes[2]
        server.initial_camera.look_at = middle
        server.initial_camera.fov = _FIELD_OF_VIEW

    def title(self, number: int) -> str:
        """Number and name of a phase."""
        found = self.moments.spans
        return f"{number + 1}/{len(found)} {phase_title(found[number].phase)}"

    def caption(self, frame: int) -> str:
        """Number and name of the phase at a frame."""
        return self.title(int(self.moments.phase[frame]))

    def show(self, frame: int) -> None:
        """Move every node to its place at a frame."""
        place(self._tool, self.moments.tool.position[frame], self.moments.tool.wxyz[frame])
        for name, node in self._links.items():
            link = self.moments.links[name]
            place(node, link.position[frame], link.wxyz[frame])
        for nodes in self._forces:
            nodes.show(frame)

    def _tip_radius(self, contact: ContactFrames) -> float:
        """Radius of the fingertip to draw [m]; 0 for the pivot and where the robot has its own."""
        if contact.track.is_pivot or self.moments.skeleton:
            return 0.0
        return tip_radii(self.plan)[contact.track.name]

    def _add_table(self, scene: SceneApi) -> None:
        tip = self.moments.tool.position[0]
        scene.add_grid(
            "/table",
            width=1.6,
            height=1.6,
            cell_size=0.05,
            section_size=0.25,
            cell_color=_LINES,
            section_color=_LINES,
            plane_color=_TABLE,
            plane_opacity=1.0,
            shadow_opacity=0.25,
            position=(0.25 * round(tip[0] / 0.25), 0.25 * round(tip[1] / 0.25),
                      self.plan.table_height),
        )  # fmt: skip

    def _add_tool(self, scene: SceneApi) -> Any:
        tool = self.plan.tool
        urdf = check_urdf(tool.urdf, where=f"URDF of {tool.name}")
        node = scene.add_frame("/tool", show_axes=False)
        for shape in urdf.links[urdf.root].collisions:
            local = shape.shifted(tool.centre_of_mass_in_root)
            add_shape(scene, f"/tool/{shape.name}", local, material(shape.name))
        return node

    def _add_robot(self, scene: SceneApi) -> dict[str, Any]:
        body = self.moments.skeleton
        if body is None:
            return {}
        colours = part_colours(body, self._colours)
        nodes = {}
        for name, link in body.urdf.links.items():
            shapes: tuple[Shape, ...] = link.collisions
            if not shapes:
                continue
            nodes[name] = scene.add_frame(f"/robot/{name}", show_axes=False)
            for shape in shapes:
                add_shape(scene, f"/robot/{name}/{shape.name}", shape, colours[name])
        return nodes
