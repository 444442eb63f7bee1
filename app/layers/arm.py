"""The arm, drawn from its URDF, and the trace its tool leaves.

What reads a URDF takes long to import; it is imported when there is an arm to draw.
"""

from __future__ import annotations

import functools
import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import viser
import viser.transforms

from abi import assets
from abi.arm.arm import JOINTS, Arm, urdf
from abi.arm.trajectory import rest_pose
from abi.arrays import FloatArray
from abi.planner.plan import Plan
from app import style
from app.frame import Frame, Switch
from app.layers.lines import segments
from app.layout import Layout

if TYPE_CHECKING:
    import trimesh
    import yourdfpy

_SHIPPED = assets.path("urdf", "abi.urdf")
_TRACE_SAMPLES = 100
_LONG = 100.0  # [m], so that no face of a short arm is small enough to be taken for none


@dataclass
class _Hinge:
    """A joint as a scene node: where it sits in its parent link, and how it moves."""

    frame: viser.FrameHandle
    column: int | None
    slides: bool
    axis: FloatArray
    origin: viser.transforms.SE3

    def move(self, positions: FloatArray) -> None:
        """Put the node where ``positions`` (6,), [rad] and [unit], have it."""
        if self.column is None:
            return
        value = float(positions[self.column])
        if self.slides:
            self.frame.position = self.origin @ (self.axis * value)
        else:
            turn = viser.transforms.SO3.exp(self.axis * value)
            self.frame.wxyz = (self.origin.rotation() @ turn).wxyz


class ArmLayer:
    """One node a link, nested as in the URDF, so that a frame sends six poses and no geometry."""

    switches: ClassVar[tuple[Switch, ...]] = (
        Switch("trace", "tool trace", style.TRACE),
        Switch("arm", "arm", style.POINT),
    )

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._base = self._scene.add_frame("/arm", show_axes=False)
        self._hinges: list[_Hinge] = []
        self._arm: Arm | None = None
        self._built: tuple[str, float] | None = None
        self._posed: object = None
        self._trace = self._scene.add_line_segments(
            "/trace", np.zeros((1, 2, 3)), style.TRACE, thickness=4.0, thickness_units="screen"
        )
        self._traced: tuple[object, int] = (None, -1)

    def draw(self, frame: Frame) -> None:
        """Draw the arm where it is at the frame's time, and the trace up to there."""
        if frame.plan.arm is not None and frame.plan.arm is not self._arm:
            self._place(frame.plan.arm)
        self._pose(frame.plan, frame.time)
        self._base.visible = "arm" in frame.shown
        self._trace.visible = "trace" in frame.shown

    def _place(self, arm: Arm) -> None:
        """Build the arm anew when its links changed, and put it on its base."""
        self._base.position = arm.base
        text, scale = urdf(arm), 1 / arm.metres
        if text != _shipped():
            enlarged = _LONG / (arm.a1 + arm.a2 + arm.a3 + arm.a4 + arm.a5)
            text, scale = urdf(arm, enlarged), 1 / enlarged
        if self._built != (text, scale):
            self._build(_load(text), scale)
            self._built = text, scale
        self._arm = arm

    def _pose(self, plan: Plan, time: float) -> None:
        """Move the arm to where it is at ``time`` [s], and draw the trace up to there."""
        motion = plan.motion
        moment = (motion if motion is not None else plan, time)
        if moment == self._posed:
            return
        self._posed = moment
        if motion is None:
            self._trace.points = segments(np.zeros((0, 3)))
            if plan.arm is not None:
                self._move(rest_pose(plan.arm, plan.scene.arm, plan.scene.start))
            return
        self._move(np.array([np.interp(time, motion.time, q) for q in motion.positions.T]))
        count = int(np.searchsorted(motion.time, time, side="right"))
        if self._traced != (motion, count):
            self._traced = (motion, count)
            kept = np.linspace(0, count - 1, min(count, _TRACE_SAMPLES)).astype(int)
            # Just above the curve, where both are to be seen.
            above = 0.008 * max(plan.scene.workspace.size)
            self._trace.points = segments(motion.tool[kept] + np.array([0.0, 0.0, above]))

    def _move(self, positions: FloatArray) -> None:
        for hinge in self._hinges:
            hinge.move(positions)

    def _build(self, robot: yourdfpy.URDF, scale: float) -> None:
        """Add the nodes of ``robot``, its metres times ``scale``."""
        for hinge in self._hinges[:1]:
            hinge.frame.remove()
        self._hinges = []
        self._posed = None
        meshes = _link_meshes(robot, scale)
        names = {robot.base_link: "/arm/links"}
        self._add_mesh(names[robot.base_link], meshes.get(robot.base_link))
        for joint in robot.robot.joints:
            names[joint.child] = name = f"{names[joint.parent]}/{joint.child}"
            matrix = np.eye(4) if joint.origin is None else np.array(joint.origin)
            matrix[:3, 3] *= scale
            origin = viser.transforms.SE3.from_matrix(matrix)
            frame = self._scene.add_frame(
                name,
                show_axes=False,
                wxyz=origin.rotation().wxyz,
                position=origin.translation(),
            )
            self._add_mesh(name, meshes.get(joint.child))
            column = JOINTS.index(joint.name) if joint.name in JOINTS else None
            axis = np.zeros(3) if joint.axis is None else np.asarray(joint.axis, dtype=float)
            slides = joint.type == "prismatic"
            self._hinges.append(_Hinge(frame, column, slides, axis, origin))

    def _add_mesh(self, name: str, mesh: trimesh.Trimesh | None) -> None:
        if mesh is not None:
            self._scene.add_mesh_trimesh(f"{name}/mesh", mesh)


@functools.cache
def _shipped() -> str:
    return _SHIPPED.read_text(encoding="utf-8")


def _load(text: str) -> yourdfpy.URDF:
    """The shipped file where it fits, the same text made for other link lengths otherwise."""
    import yourdfpy

    if text == _shipped():
        return yourdfpy.URDF.load(str(_SHIPPED))
    return yourdfpy.URDF.load(io.BytesIO(text.encode()))


def _link_meshes(robot: yourdfpy.URDF, scale: float) -> dict[str, trimesh.Trimesh]:
    """One mesh a link, in the link's frame; all solids of a link in one go."""
    import trimesh

    parts: dict[str, list[Any]] = {}
    graph = robot.scene.graph
    for node in graph.nodes_geometry:
        link = graph.transforms.parents[node]
        link_from_solid, geometry = graph.get(node, link)
        part = robot.scene.geometry[geometry].copy()
        part.apply_transform(link_from_solid)
        part.apply_scale(scale)
        parts.setdefault(link, []).append(part)
    meshes: dict[str, trimesh.Trimesh] = {}
    for link, solids in parts.items():
        meshes[link] = trimesh.util.concatenate(solids)  # type: ignore[assignment]
    return meshes
