"""Joints and solids of the paper's arm from its URDF, read once for all tabs.

The reader of URDF files takes long to import, so it is imported when there is an arm to draw.
"""

from __future__ import annotations

import functools
import io
import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import viser.transforms

from abi import assets
from abi.arm.arm import Arm, urdf
from abi.arrays import FloatArray, read_only
from app import style

if TYPE_CHECKING:
    import trimesh
    import yourdfpy

_SHIPPED_FILE = assets.path("urdf", "abi.urdf")
_REACH = 100.0  # [m], since loading drops faces as small as those of a short arm may be
_KEPT = 8
"""Arms of different sizes that are kept."""


@dataclass(frozen=True, eq=False)
class Joint:
    """Joint between two links.

    Attributes:
        name: of the joint.
        parent: link it is on.
        child: link it moves.
        prismatic: whether it slides along the axis instead of turning about it.
        axis: (3,), in the joint's frame.
        origin: the joint's frame in the parent link's, [unit].
    """

    name: str
    parent: str
    child: str
    prismatic: bool
    axis: FloatArray
    origin: viser.transforms.SE3


@dataclass(frozen=True, eq=False)
class Solid:
    """All that is rigid with a link, as binary glTF.

    Attributes:
        glb: in its own colours.
        red: in the colour of what is in the way.
    """

    glb: bytes
    red: bytes


@dataclass(frozen=True, eq=False)
class ArmSolids:
    """An arm's links and joints.

    Attributes:
        base: link that does not move.
        joints: parents before their children.
        solids: of the links that have any, in the link's frame, [unit].
    """

    base: str
    joints: tuple[Joint, ...]
    solids: dict[str, Solid]


_reading = threading.Lock()


def solids_of(arm: Arm) -> ArmSolids:
    """An arm's links and joints, the same object for arms of the same lengths."""
    text, scale = urdf(arm), 1 / arm.metres
    if text != shipped_urdf():
        factor = _REACH / (arm.a1 + arm.a2 + arm.a3 + arm.a4 + arm.a5)
        text, scale = urdf(arm, factor), 1 / factor
    with _reading:
        return _arm_solids(text, scale)


@functools.lru_cache(_KEPT)
def _arm_solids(text: str, scale: float) -> ArmSolids:
    """The arm of a URDF, its metres times ``scale``; the shipped one has its meshes beside it."""
    robot = _load(text)
    joints = []
    for joint in robot.robot.joints:
        matrix = np.eye(4) if joint.origin is None else np.array(joint.origin)
        matrix[:3, 3] *= scale
        axis = np.zeros(3) if joint.axis is None else np.array(joint.axis, dtype=float)
        joints.append(
            Joint(
                joint.name,
                joint.parent,
                joint.child,
                prismatic=joint.type == "prismatic",
                axis=read_only(axis),
                origin=viser.transforms.SE3.from_matrix(matrix),
            )
        )
    solids = {
        link: Solid(_glb(solid), _glb(_reddened(solid)))
        for link, solid in _link_meshes(robot, scale).items()
    }
    return ArmSolids(robot.base_link, tuple(joints), solids)


@functools.cache
def shipped_urdf() -> str:
    """Text of the shipped URDF, of the arm in the paper's proportions."""
    return _SHIPPED_FILE.read_text(encoding="utf-8")


def _load(text: str) -> yourdfpy.URDF:
    """The robot of a URDF's text; the shipped one from its file, beside its meshes."""
    import yourdfpy

    if text == shipped_urdf():
        return yourdfpy.URDF.load(str(_SHIPPED_FILE))
    return yourdfpy.URDF.load(io.BytesIO(text.encode()))


def _glb(solid: trimesh.Trimesh) -> bytes:
    data = solid.export(file_type="glb")
    assert isinstance(data, bytes)
    return data


def _reddened(solid: trimesh.Trimesh) -> trimesh.Trimesh:
    """The same mesh in the colour of what is in the way."""
    from trimesh.visual import ColorVisuals

    red = solid.copy()
    colours = np.tile(np.array([*style.TOUCHING, 255], dtype=np.uint8), (len(red.faces), 1))
    red.visual = ColorVisuals(red, face_colors=colours)
    return red


def _link_meshes(robot: yourdfpy.URDF, scale: float) -> dict[str, trimesh.Trimesh]:
    """One mesh a link, in the link's frame, with all its solids."""
    import trimesh

    solids: dict[str, list[Any]] = {}
    graph = robot.scene.graph
    for node in graph.nodes_geometry:
        link = graph.transforms.parents[node]
        link_from_solid, geometry = graph.get(node, link)
        solid = robot.scene.geometry[geometry].copy()
        solid.apply_transform(link_from_solid)
        solid.apply_scale(scale)
        solids.setdefault(link, []).append(solid)
    return {link: trimesh.util.concatenate(parts) for link, parts in solids.items()}  # type: ignore[misc]
