"""Capsules of the arm's other poses as bodies, which the page moves by its own clock.

The page goes straight from place to place between the samples that it has of the motion; its part
is in ``assets/page/page.js``.
"""

from __future__ import annotations

import base64
import itertools
from collections.abc import Callable, Sequence

import numpy as np
import viser
from viser.transforms import SO3

from abi.arrays import FloatArray
from abi.obstacles.revolution import quarter_circles, revolved
from app.ui import node_poses, page, style

_SIDES = 14

Pose = Callable[[FloatArray, FloatArray, FloatArray | None], None]
"""Shows capsules by their segments' ends (b, 2, 3) and radii (b,), [unit], world; none for b = 0.

With their places at each sample of the motion by :func:`places_of`, (samples, b, 7), NaN where one
is not there, the page moves them from there on. The same array means the same motion.
"""


def ghost(client: viser.ClientHandle, name: str, colour: style.Colour) -> Pose:
    """A node for each of some capsules, see-through; none until they are posed."""
    root: viser.FrameHandle | None = None
    nodes: list[viser.MeshHandle] = []
    shapes: tuple[tuple[float, float], ...] = ()
    following: FloatArray | None = None

    def pose(ends: FloatArray, radii: FloatArray, places: FloatArray | None = None) -> None:
        nonlocal root, nodes, shapes, following
        if places is None and following is not None:
            following = None
            page.call(client, "follow", None)
            for node in nodes:
                node_poses.forget(node)
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        rows = tuple(zip(lengths.round(6).tolist(), radii.round(6).tolist(), strict=True))
        if rows and rows != shapes:
            if root is not None:
                root.remove()
            root, nodes = _add_capsules(client.scene, name, rows, colour)
            shapes, following = rows, None
        if root is not None:
            root.visible = bool(rows)
        if places is not None and places is not following:
            following = places
            table = base64.b64encode(places.astype("<f4").tobytes()).decode()
            names = [node.name for node in nodes]
            page.call(client, "follow", {"names": names, "places": table})
        elif places is None and rows:
            for node, place in zip(nodes, places_of(ends[None])[0], strict=True):
                node.position, node.wxyz = place[:3], place[3:]

    return pose


def _add_capsules(
    scene: viser.SceneApi,
    name: str,
    shapes: Sequence[tuple[float, float]],
    colour: style.Colour,
) -> tuple[viser.FrameHandle, list[viser.MeshHandle]]:
    """Add a node that all are in, and one for each length and radius, around the z axis."""
    root, nodes = scene.add_frame(name, show_axes=False), []
    for number, (length, radius) in enumerate(shapes):
        vertices, faces = revolved(quarter_circles(radius, length / 2, _SIDES), _SIDES)
        nodes.append(
            scene.add_mesh_simple(
                f"{name}/{number}",
                vertices.astype(np.float32),
                faces.astype(np.uint32),
                color=colour,
                opacity=style.GHOST_OPACITY,
                cast_shadow=False,
            )
        )
    return root, nodes


def places_of(ends: FloatArray) -> FloatArray:
    """Middles of segments, and quaternions wxyz that turn the z axis along them.

    From sample to sample each turns the shortest way, so that what lies between may be taken
    straight.

    Args:
        ends: (samples, b, 2, 3).

    Returns:
        Shape (samples, b, 7).
    """
    ways = ends[:, :, 1] - ends[:, :, 0]
    size = np.linalg.norm(ways, axis=2, keepdims=True)
    axes = np.where(size > 0, ways / np.where(size > 0, size, 1.0), (0.0, 0.0, 1.0))
    turn = _shortest(np.broadcast_to((0.0, 0.0, 1.0), axes[0].shape), axes[0])
    turns = [turn]
    for before, axis in itertools.pairwise(axes):
        turn = np.asarray((SO3(_shortest(before, axis)) @ SO3(turn)).wxyz, np.float64)
        turns.append(turn)
    return np.concatenate([ends.mean(axis=2), np.stack(turns)], axis=2)


def _shortest(first: FloatArray, second: FloatArray) -> FloatArray:
    """Quaternions (b, 4) that turn unit vectors (b, 3) to others."""
    turns = np.column_stack([1 + (first * second).sum(axis=1), np.cross(first, second)])
    opposite = turns[:, 0] < 1e-9
    if opposite.any():  # half a turn about any axis across
        least = np.eye(3)[np.abs(first[opposite]).argmin(axis=1)]
        turns[opposite] = np.column_stack([np.zeros(len(least)), np.cross(first[opposite], least)])
    return np.asarray(turns / np.linalg.norm(turns, axis=1, keepdims=True))
