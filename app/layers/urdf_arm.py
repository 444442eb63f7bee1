"""An arm that a URDF describes: one node per moving joint, with the links that it carries."""

from __future__ import annotations

import functools
import operator
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import viser
import viser.transforms

from abi.arm.urdf_arm import UrdfArm
from abi.arrays import FloatArray
from abi.robot.robot import Link, Shape
from app import style
from app.frame import Frame, Switch
from app.layers.link_colours import muted
from app.layout import Layout

if TYPE_CHECKING:
    import trimesh

_COLOURS = ((226, 230, 234), (96, 108, 122))
"""Of every other link without a colour of its own, so that one sees where they meet."""


class UrdfArmLayer:
    """One node a joint, all beside each other: a frame sends a pose each and no geometry."""

    switches: ClassVar[tuple[Switch, ...]] = ()

    def __init__(self, layout: Layout) -> None:
        self._scene = layout.client.scene
        self._root = self._scene.add_frame("/robot", show_axes=False)
        self._frames: list[viser.FrameHandle] = []
        self._links: dict[str, list[viser.GlbHandle]] = {}
        self._red: dict[str, list[viser.GlbHandle]] = {}
        self._arm: UrdfArm | None = None
        self._shown: UrdfArm | None = None
        self._posed: object = None
        self._touching: frozenset[str] = frozenset()

    def draw(self, frame: Frame) -> None:
        """Draw the arm at the frame's time, what touches something in red."""
        arm = frame.plan.arm
        visible = isinstance(arm, UrdfArm) and "arm" in frame.shown
        self._root.visible = visible
        if not isinstance(arm, UrdfArm) or not visible:
            return
        if arm is not self._arm:
            self._place(arm)
        moment = (frame.plan, frame.time)
        if moment != self._posed:
            self._posed = moment
            self._pose(frame, arm)
        clearance = frame.plan.arm_clearance
        self._redden(frozenset() if clearance is None else clearance.touching(frame.time))

    def _place(self, arm: UrdfArm) -> None:
        """Show another arm; its geometry stays where the robot, its tip and the unit do."""
        shown = self._shown
        same = shown is not None and (shown.chain.robot, shown.tip, shown.unit) == (
            arm.chain.robot,
            arm.tip,
            arm.unit,
        )
        if not same:
            self._build(arm)
        self._arm, self._posed = arm, None
        self._frames[0].position = arm.base

    def _build(self, arm: UrdfArm) -> None:
        for frame in self._frames:
            frame.remove()
        count = len(arm.chain.joints)
        names = ["/robot/base", *(f"/robot/joint{k}" for k in range(count))]
        self._frames = [self._scene.add_frame(name, show_axes=False) for name in names]
        self._links, self._red, self._touching = {}, {}, frozenset()
        for number, carried in enumerate(arm.chain.carried):
            link = arm.chain.robot.links[carried.link]
            if not link.drawn:
                continue
            pose = np.array(carried.pose)
            if carried.frame < 0:
                pose[:3, 3] -= arm.base * arm.metres
            node = f"{names[carried.frame + 1]}/{number}"
            for label, colour, handles in (
                ("own", _COLOURS[number % 2], self._links),
                ("red", style.TOUCHING, self._red),
            ):
                second = bool(number % 2) if label == "own" else None
                mesh = link_mesh(link, pose, 1 / arm.metres, colour, second)
                handle = self._scene.add_mesh_trimesh(f"{node}/{label}", mesh)
                handle.visible = label == "own"
                handles.setdefault(carried.link, []).append(handle)
        self._shown = arm

    def _pose(self, frame: Frame, arm: UrdfArm) -> None:
        plan = frame.plan
        if plan.motion is None:
            positions = arm.first_poses(np.array(plan.scene.start))[0]
        else:
            rows = plan.motion.positions.T
            positions = np.array([np.interp(frame.time, plan.motion.time, row) for row in rows])
        poses = arm.chain.poses((positions / arm.scales)[None])[0]
        for handle, pose in zip(self._frames[1:], poses, strict=False):
            handle.wxyz = viser.transforms.SO3.from_matrix(pose[:, :3]).wxyz
            handle.position = pose[:, 3] / arm.metres

    def _redden(self, links: frozenset[str]) -> None:
        """Draw links in red, and the others in their own colours."""
        for link in links ^ self._touching:
            for handle in self._red.get(link, ()):
                handle.visible = link in links
            for handle in self._links.get(link, ()):
                handle.visible = link not in links
        self._touching = links


def link_mesh(
    link: Link,
    pose: FloatArray,
    scale: float,
    colour: style.Colour,
    second: bool | None = None,
) -> trimesh.Trimesh:
    """Mesh of what a link is drawn with, in the frame that moves it, its metres times ``scale``.

    Args:
        link: the link.
        pose: of the link in that frame, (4, 4), [m].
        scale: factor.
        colour: of what has none of its own.
        second: whether it is every other link; None where all of it has ``colour``.
    """
    import trimesh  # here, since it takes long to import

    parts = [_shape_mesh(shape, pose @ shape.pose) for shape in link.drawn]
    mesh = functools.reduce(operator.add, parts)
    mesh.apply_scale(scale)  # type: ignore[no-untyped-call]
    colours = np.tile(np.array([*colour, 255], dtype=np.uint8), (len(mesh.faces), 1))
    if second is not None:
        row = 0
        for part, shape in zip(parts, link.drawn, strict=True):
            if len(shape.colours):
                colours[row : row + len(part.faces), :3] = muted(shape.colours, second)
            row += len(part.faces)
    mesh.visual = trimesh.visual.ColorVisuals(mesh, face_colors=colours)
    return mesh


def _shape_mesh(shape: Shape, pose: FloatArray) -> trimesh.Trimesh:
    import trimesh  # here, since it takes long to import

    radius, length, _ = shape.size
    mesh: trimesh.Trimesh
    if shape.kind == "mesh":
        mesh = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    elif shape.kind == "box":
        mesh = trimesh.creation.box(shape.size)
    elif shape.kind == "sphere":
        mesh = trimesh.creation.icosphere(3, radius)
    else:
        mesh = trimesh.creation.cylinder(radius, length, sections=32)
    mesh.apply_transform(pose)
    return mesh
