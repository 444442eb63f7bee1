"""Scene nodes of an arm that a URDF describes, with the links that each joint carries."""

from __future__ import annotations

import functools
import operator
from typing import TYPE_CHECKING

import numpy as np
import viser
import viser.transforms

from abi.arm.any_arm import AnyArm
from abi.arm.chain_kernels import POSE
from abi.arm.urdf_arm import UrdfArm
from abi.arrays import FloatArray
from abi.obstacles.pose import rotation
from abi.planner.plan import Plan
from abi.robot.robot import Link, Shape
from app import style
from app.layers.arm_nodes import JointNode
from app.layers.link_colours import muted
from app.layers.urdf_poses import first_poses

if TYPE_CHECKING:
    import trimesh

_COLOURS = ((226, 230, 234), (96, 108, 122))
"""Of every other link without a colour of its own, so that one sees where they meet."""


class UrdfArmNodes:
    """One node a joint of the chain, each in that of the joint before it."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.root = scene.add_frame("/robot", show_axes=False)
        self.joint_nodes: list[JointNode] = []
        self._base: viser.FrameHandle | None = None
        self._links: dict[str, list[viser.GlbHandle]] = {}
        self._red: dict[str, list[viser.GlbHandle]] = {}
        self._arm: UrdfArm | None = None
        self._touching: frozenset[str] = frozenset()

    def place(self, arm: AnyArm) -> None:
        """Put the arm on its base; its geometry stays where robot, tip and unit do."""
        assert isinstance(arm, UrdfArm)
        shown, self._arm = self._arm, arm
        same = shown is not None and (shown.chain.robot, shown.tip, shown.unit) == (
            arm.chain.robot,
            arm.tip,
            arm.unit,
        )
        if not same:
            self._build(arm)
        assert self._base is not None
        self._base.position, self._base.wxyz = arm.base, np.array(arm.wxyz)

    def rest_pose(self, plan: Plan) -> FloatArray:
        """The first pose found with the tool on the start."""
        assert isinstance(plan.arm, UrdfArm)
        return first_poses(plan.arm, plan.scene.start)[0]

    def values(self, positions: FloatArray) -> FloatArray:
        """Positions (k, m) of the chain's joints, those that mimic another among them."""
        assert self._arm is not None
        return joint_values(self._arm, positions)

    def redden(self, links: frozenset[str]) -> None:
        """Draw links in red, and the others in their own colours."""
        for link in links ^ self._touching:
            for handle in self._red.get(link, ()):
                handle.visible = link in links
            for handle in self._links.get(link, ()):
                handle.visible = link not in links
        self._touching = links

    def _build(self, arm: UrdfArm) -> None:
        """Add the nodes of another arm, with what they carry."""
        if self._base is not None:
            self._base.remove()
        name = "/robot/base"
        self._base = self._scene.add_frame(name, show_axes=False)
        names, self.joint_nodes = [name], []
        for number, joint in enumerate(arm.chain.joints):
            name = f"{name}/joint{number}"
            names.append(name)
            origin = joint_origin(arm, number)
            frame = self._scene.add_frame(
                name,
                show_axes=False,
                wxyz=origin.rotation().wxyz,
                position=origin.translation(),
            )
            slides = joint.kind == "prismatic"
            node = JointNode(frame, number, prismatic=slides, axis=joint.axis, origin=origin)
            self.joint_nodes.append(node)
        self._links, self._red, self._touching = {}, {}, frozenset()
        for number, carried in enumerate(arm.chain.carried):
            link = arm.chain.robot.links[carried.link]
            if link.drawn:
                pose = np.array(carried.pose)
                if carried.frame < 0:
                    pose = np.linalg.inv(root_pose(arm)) @ pose
                self._add_meshes(f"{names[carried.frame + 1]}/{number}", link, pose, number % 2)

    def _add_meshes(self, name: str, link: Link, pose: FloatArray, second: int) -> None:
        """Add a link twice, in its own colours and in red."""
        assert self._arm is not None
        for label, colour, handles in (
            ("own", _COLOURS[second], self._links),
            ("red", style.TOUCHING, self._red),
        ):
            other = bool(second) if label == "own" else None
            mesh = link_mesh(link, pose, 1 / self._arm.metres, colour, other)
            handle = self._scene.add_mesh_trimesh(f"{name}/{label}", mesh)
            handle.visible = label == "own"
            handles.setdefault(link.name, []).append(handle)


def joint_origin(arm: UrdfArm, number: int) -> viser.transforms.SE3:
    """Frame of a joint at position 0 in that of the joint before it, or in the base, [unit]."""
    packed = arm.chain.table.origins[POSE * number : POSE * (number + 1)]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = packed[:9].reshape(3, 3), packed[9:]
    if number == 0:
        pose = np.linalg.inv(root_pose(arm)) @ pose
    pose[:3, 3] /= arm.metres
    return viser.transforms.SE3.from_matrix(pose)


def root_pose(arm: UrdfArm) -> FloatArray:
    """World from the root link, (4, 4), [m]."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(arm.wxyz), arm.base * arm.metres
    return pose


def joint_values(arm: UrdfArm, positions: FloatArray) -> FloatArray:
    """Positions (k, m) of an arm's joints, [rad] or [unit], of those (k, n) that a motion has."""
    table = arm.chain.table
    values = (positions / arm.scales)[:, table.source] * table.factor + table.offset
    return np.asarray(np.where(table.slides, values / arm.metres, values))


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
