"""Capsules of the arm's other poses as bodies, which the page moves by its own clock.

The page goes straight from place to place between the samples that it has of the motion; its part
is in ``assets/page/page.js``.
"""

from __future__ import annotations

import base64
import itertools

import numpy as np
import viser
from viser.transforms import SO3

from abi.arrays import FloatArray
from abi.obstacles.revolution import quarter_circles, revolved
from app.ui import node_poses, page, style

_SIDES = 14
_PLACE = 7
"""Numbers of a place: its position, and a quaternion that turns the z axis along the capsule."""


class GhostBodies:
    """A node for each capsule, see-through."""

    def __init__(self, client: viser.ClientHandle, name: str, colour: style.Colour) -> None:
        self._client, self._name, self._colour = client, name, colour
        self._root: viser.FrameHandle | None = None
        self._nodes: list[viser.MeshHandle] = []
        self._shapes: tuple[tuple[float, float], ...] = ()
        self._following: object = None

    def hide(self) -> None:
        """Hide all of them."""
        self._follow(None, None)
        if self._root is not None:
            self._root.visible = False

    def stand(self, ends: FloatArray, radii: FloatArray) -> None:
        """Show them at their segments' ends (b, 2, 3), [unit], world, with radii (b,)."""
        self._follow(None, None)
        self._build(ends, radii)
        for node, place in zip(self._nodes, places_of(ends[None])[0], strict=True):
            node.position, node.wxyz = place[:3], place[3:]

    def follow(self, ends: FloatArray, radii: FloatArray, places: FloatArray) -> None:
        """Have the page move them, from the samples that it has of the motion.

        Args:
            ends: of their segments at some sample, (b, 2, 3), [unit], world.
            radii: (b,), [unit].
            places: of :func:`places_of` for each sample, (samples, b, 7); NaN where one is not
                there. The same array means the same motion.
        """
        self._build(ends, radii)
        self._follow(places, [node.name for node in self._nodes])

    def _follow(self, places: FloatArray | None, names: list[str] | None) -> None:
        if places is self._following:
            return
        self._following = places
        if places is None:
            page.call(self._client, "follow", None)
            for node in self._nodes:
                node_poses.forget(node)
            return
        table = base64.b64encode(places.astype("<f4").tobytes()).decode()
        page.call(self._client, "follow", {"names": names, "places": table})

    def _build(self, ends: FloatArray, radii: FloatArray) -> None:
        """Show a node for each capsule; they are the same as long as the shapes are."""
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        rows = zip(lengths.round(6).tolist(), radii.round(6).tolist(), strict=True)
        if (shapes := tuple(rows)) != self._shapes:
            if self._root is not None:
                self._root.remove()
            scene = self._client.scene
            self._root = scene.add_frame(self._name, show_axes=False)
            self._shapes, self._nodes, self._following = shapes, [], None
            for number, (length, radius) in enumerate(shapes):
                # around a segment of the z axis
                vertices, faces = revolved(quarter_circles(radius, length / 2, _SIDES), _SIDES)
                self._nodes.append(
                    scene.add_mesh_simple(
                        f"{self._name}/{number}",
                        vertices.astype(np.float32),
                        faces.astype(np.uint32),
                        color=self._colour,
                        opacity=style.GHOST_OPACITY,
                        cast_shadow=False,
                    )
                )
        if self._root is not None:
            self._root.visible = True


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
