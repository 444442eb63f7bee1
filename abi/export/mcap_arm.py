"""The arm in a recording: its links as they are drawn, and the frames that move them.

So Foxglove draws it from the recording alone: meshes that a URDF names are nowhere where it looks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray
from abi.export import mcap_entities
from abi.export.mcap_entities import Colour, Part
from abi.obstacles.pose import Vec3
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.link import Link, LinkShape

_STILL = 1e-9
"""Change of a pose that counts as none."""
_GREY: Colour = (0.72, 0.75, 0.79, 1.0)


Frames = Mapping[tuple[str, str], FloatArray]
"""Poses x, y, z [m], w, x, y, z of frames in their parents, (samples, 7), by the names of parent
and frame.
"""


def scene_frame(chain: Chain) -> str:
    """Name of the scene's frame, which no link has."""
    name = "world"
    while name in chain.robot.links:
        name = f"scene_{name}"
    return name


def joint_states(trajectory: ArmMotion, legs: Sequence[tuple[Chain, int]]) -> list[Part]:
    """Names, positions and velocities of a robot's joints at each sample, as messages have them.

    So whoever poses the robot by them has its gripper where the chain of each leg holds it.

    Args:
        trajectory: of the joints that move, with those that slide in [m].
        legs: the chain of each leg, and the number of the sample that ends it.
    """
    own = {one.name for one in legs[0][0].robot.joints if one.follows is None}
    names = [name for name in legs[0][0].held if name in own]
    found, still = list[Part](), [0.0] * len(names)
    for chain, last in legs:
        held = [float(chain.held[name]) for name in names]
        found += [
            {
                "name": [*trajectory.joints, *names],
                "position": [*trajectory.positions[sample].tolist(), *held],
                "velocity": [*trajectory.joint_velocities[sample].tolist(), *still],
                "effort": [],
            }
            for sample in range(len(found), last + 1)
        ]
    return found


def link_frames(
    chain: Chain, positions: FloatArray, legs: Sequence[tuple[Chain, int]]
) -> tuple[Frames, Frames]:
    """Frames of links that never move in their parents, and of those that do.

    Args:
        chain: the chain.
        positions: of its joints, (samples, n), [rad] or [m].
        legs: the chain of each leg, whose gripper may be held otherwise, and the number of the
            sample that ends it.
    """
    scene = scene_frame(chain)
    world = {scene: np.broadcast_to(np.eye(4), (len(positions), 4, 4))}
    first, parts = 0, list[dict[str, FloatArray]]()
    for of_leg, last in legs:
        rows = positions[first : last + 1]
        poses, first = of_leg.poses(rows), last + 1
        part = {}
        for link in chain.frames:
            # what is held on the first leg alone stays in the hand
            here = of_leg if link in of_leg.frames else chain
            frame = np.tile(np.eye(4), (len(rows), 1, 1))
            if here.frames[link] >= 0:
                frame[:, :3] = poses[:, here.frames[link]]
            part[link] = frame @ here.places[link]
        parts.append(part)
    world |= {link: np.concatenate([part[link] for part in parts]) for link in chain.frames}
    moving = [(joint.parent, joint.child) for joint in chain.joints]
    pairs = [(joint.parent, joint.child) for joint in chain.robot.joints]
    changing = [
        pair for pair in pairs if pair not in moving and len(legs) > 1 and _moves(world, *pair)
    ]
    moving += changing
    still = [(scene, chain.robot.root), *(pair for pair in pairs if pair not in moving)]
    return _frames(world, still, 1), _frames(world, moving, len(positions))


def _moves(world: dict[str, FloatArray], parent: str, child: str) -> bool:
    """Check whether a frame moves in its parent."""
    poses = np.linalg.inv(world[parent]) @ world[child]
    return bool(np.abs(poses - poses[0]).max() > _STILL)


def link_entities(chain: Chain) -> Part:
    """An update of the scene with an entity for each link that is drawn."""
    links = chain.robot.links.values()
    return {
        "deletions": [],
        "entities": [
            mcap_entities.entity(f"arm/{link.name}", link.name, _drawn(link))
            for link in links
            if link.drawn
        ],
    }


def _frames(world: dict[str, FloatArray], pairs: list[tuple[str, str]], samples: int) -> Frames:
    """Poses of the second frame of each pair in the first, at the first samples."""
    found = {}
    for parent, child in pairs:
        poses = np.linalg.inv(world[parent][:samples]) @ world[child][:samples]
        found[parent, child] = np.hstack([poses[:, :3, 3], quaternions(poses[:, :3, :3])])
    return found


def _drawn(link: Link) -> dict[str, list[Part]]:
    return mcap_entities.by_kind([_part(shape) for shape in link.drawn])


def _part(shape: LinkShape) -> tuple[str, Part]:
    colours: list[Colour] = [
        (*(channel / 255 for channel in row), 1.0) for row in shape.colours.tolist()
    ]
    w, x, y, z = quaternions(shape.pose[None, :3, :3])[0].tolist()
    pose = mcap_entities.pose_of(shape.pose[:3, 3], (w, x, y, z))
    if shape.kind != "mesh":
        return mcap_entities.solid(shape.kind, _extent(shape), pose, (colours or [_GREY])[0])
    if len(colours) > 1:  # corners of two colours cannot be shared
        corners = shape.vertices[shape.faces].reshape(-1, 3)
        own = [colour for colour in colours for _ in range(3)]
        return mcap_entities.triangles(corners, shape.faces[:0], pose, own)
    points, rows = np.unique(shape.vertices, axis=0, return_inverse=True)
    faces = rows.reshape(-1)[shape.faces]
    return mcap_entities.triangles(points, faces.astype(np.int32), pose, colours or [_GREY])


def quaternions(turns: FloatArray) -> FloatArray:
    """Unit quaternions wxyz (k, 4) of rotation matrices (k, 3, 3)."""
    from scipy.spatial.transform import Rotation  # here, since it takes long to import

    # a copy, since the oldest scipy allowed takes no read-only array
    return np.asarray(Rotation.from_matrix(np.array(turns)).as_quat()[:, [3, 0, 1, 2]])


def _extent(shape: LinkShape) -> Vec3:
    """Size of the box around a shape that is not a mesh, [m]."""
    radius, length, _ = shape.size
    if shape.kind == "box":
        return shape.size
    return (2 * radius, 2 * radius, length if shape.kind == "cylinder" else 2 * radius)
