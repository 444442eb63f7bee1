"""Surroundings of an arm, which it must keep clear of: obstacles, the floor and its own column."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from abi.arm.arm import Arm
from abi.arm.box_row_kernels import box_rows
from abi.arm.link_capsules import COLUMN
from abi.arm.surroundings_kernels import Obstacles
from abi.arrays import BoolArray, FloatArray, IntArray, flat, read_only
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.pose import rotation
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH
from abi.obstacles.primitive_tree_kernels import TREE
from abi.obstacles.triangle_mesh.bvh import tree_of
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.vector_kernels import vec3_at

FLOOR, OWN = -1, -2
"""Numbers of the floor and of the arm's first capsule, beside those of obstacles; -3 is its second,
and so on."""

_MOST_TRIANGLES = 20_000
"""Triangles above which a mesh is taken for the boxes of the leaves of a tree."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Obstacles, floor and column in the format of the kernels.

    A triangle mesh is a tree of boxes, the smallest of which fit its triangles closely.

    Attributes:
        rows: convex primitives, whose tree does not count, flat (k WIDTH,).
        inside: rows of boxes inside each, see :class:`Obstacles`, flat (2 k,).
        numbers: obstacle of each of them, ``OWN`` minus a capsule's number, last ``FLOOR``,
            (k + 1,).
        meshes: the same of the rows of triangle meshes, -1 of others, (k + 1,).
        asked: whether a capsule must keep clear of it, False for boxes inside others, (c, k + 1).
        floor: height of the floor, [unit].
        size: largest coordinate of arm and obstacles, [unit].
    """

    rows: FloatArray
    inside: IntArray
    numbers: IntArray
    meshes: IntArray
    asked: BoolArray
    floor: float
    size: float

    def beyond(self, margin: float) -> Obstacles:
        """Add a distance to keep from obstacles, [unit]; from floor and column it is 0."""
        margins = np.where(self.numbers >= 0, margin, 0.0)
        asked = self.asked.reshape(-1)
        return Obstacles(
            self.rows, self.inside, self.meshes, read_only(margins), asked, self.floor, self.size
        )

    def only(self, kept: BoolArray) -> Surroundings:
        """A copy that asks only about some of the rows; ``kept`` has one flag for each."""
        return replace(self, asked=read_only(self.asked & kept))


def surroundings(arm: Arm, obstacles: ObstacleSet, lowest: float) -> Surroundings:
    """Build the surroundings of the paper's arm.

    The floor is level with the base, or with the bottom of the workspace if that is lower. Links
    with a joint at the column may touch it, and the fingers may touch the floor.

    Args:
        arm: the arm.
        obstacles: the solids.
        lowest: height of the workspace's bottom, [unit].
    """
    solids, own = solid_rows(obstacles), _own_rows(arm)
    number = np.concatenate([solids.numbers, own.numbers])
    within = np.concatenate([solids.inside, np.zeros((len(own.numbers) - 1, 2), dtype=np.int32)])
    asked = np.ones((len(arm.capsules), len(number)), dtype=np.bool_)
    asked[:, len(solids.numbers) :] = own.asked
    if obstacles.meshes:
        asked &= outermost(within)
    packed = np.concatenate([solids.rows, own.rows])
    reach = arm.a1 + arm.a2 + arm.a3 + 2 * arm.a4 + arm.a5
    size = float(np.abs(arm.base).max()) + reach + largest_coordinate(packed)
    return Surroundings(
        *(read_only(packed), read_only(within.reshape(-1)), read_only(number)),
        mesh_numbers(obstacles, number),
        *(read_only(asked), min(float(arm.base[2]), lowest), size),
    )


class _OwnRows(NamedTuple):
    """What an arm keeps clear of beside obstacles: its column, and the floor.

    Attributes:
        rows: of the column, flat (k WIDTH,).
        numbers: ``OWN`` minus a capsule's number of each of them, last ``FLOOR``, (k + 1,).
        asked: whether a capsule is to keep clear of it, (c, k + 1).
    """

    rows: FloatArray
    numbers: IntArray
    asked: BoolArray


@lru_cache(maxsize=16)
def _own_rows(arm: Arm) -> _OwnRows:
    still = [k for k, capsule in enumerate(arm.capsules) if capsule.body == COLUMN]
    x, y, z = arm.base.tolist()
    rows = [np.zeros(0)]
    for capsule in (arm.capsules[k] for k in still):
        half, radius = (capsule.high - capsule.low) / 2, capsule.radius
        centre = np.array([[x, y, z + (capsule.low + capsule.high) / 2]])
        rows.append(_rows(centre, np.eye(3)[None], np.array([[0.0, 0.0, half]]), radius))
    numbers = np.array([*(OWN - k for k in still), FLOOR], dtype=np.int32)
    moves = np.array([capsule.body != COLUMN for capsule in arm.capsules])[:, None]
    jointed = np.array([capsule.neighbour for capsule in arm.capsules])[:, None]
    grips = np.array([capsule.grips for capsule in arm.capsules])[:, None]
    asked = moves & np.where(numbers == FLOOR, ~grips, ~jointed)
    return _OwnRows(read_only(np.concatenate(rows)), read_only(numbers), read_only(asked))


class SolidRows(NamedTuple):
    """Obstacles as rows of convex primitives.

    Attributes:
        rows: flat (k WIDTH,).
        numbers: obstacle of each, (k,).
        inside: first and last but one of the boxes inside each, 0 and 0 without, (k, 2).
    """

    rows: FloatArray
    numbers: IntArray
    inside: IntArray


def solid_rows(obstacles: ObstacleSet) -> SolidRows:
    """Obstacles as rows: primitives as they are, meshes as trees of boxes."""
    rows = [obstacles.packed]
    numbers = [obstacles.primitive_numbers]
    inside = [np.zeros((len(obstacles.primitives), 2), dtype=np.int32)]
    for number, mesh in zip(obstacles.mesh_numbers.tolist(), obstacles.meshes, strict=True):
        boxes = _boxes_of(mesh.surface).inside
        inside.append(np.where(boxes[:, 1:] > 0, boxes + sum(map(len, numbers)), 0))
        rows.append(_boxes(mesh))
        numbers.append(np.full(len(boxes), number, dtype=np.int32))
    within = np.concatenate(inside).astype(np.int32)
    some = [one for one in rows if len(one)] or rows  # a large mesh alone is not copied
    packed = some[0] if len(some) == 1 else np.concatenate(some)
    return SolidRows(packed, np.concatenate(numbers), within)


def mesh_numbers(obstacles: ObstacleSet, numbers: IntArray) -> IntArray:
    """Numbers of triangle meshes, with -1 in place of all other numbers."""
    if not obstacles.meshes:
        return read_only(np.full(len(numbers), -1, dtype=np.int32))
    of_mesh = np.isin(numbers, obstacles.mesh_numbers)
    return read_only(np.where(of_mesh, numbers, np.int32(-1)).astype(np.int32))


def outermost(inside: IntArray) -> BoolArray:
    """Flags of the rows that are inside no other, and of the floor after them, (k + 1,)."""
    first, last = inside[inside[:, 1] > 0].T
    count = len(inside) + 2
    steps = np.bincount(first, minlength=count) - np.bincount(last, minlength=count)
    return np.asarray(np.cumsum(steps)[:-1] == 0)


def largest_coordinate(rows: FloatArray) -> float:
    """Largest coordinate of primitives (k WIDTH,), [unit]."""
    bounds = rows.reshape(-1, WIDTH)[:, BOUNDS:TREE]
    return float(np.abs(bounds).max(initial=0.0))


@lru_cache(maxsize=1)  # of large meshes they take up to 100 MB
def _boxes(mesh: MeshShape) -> FloatArray:
    """Rows of the boxes of a mesh, flat; those of the last one are kept."""
    boxes = _boxes_of(mesh.surface)
    turned = rotation(mesh.wxyz)
    a, b, c = (vec3_at(flat(axis), 0) for axis in turned.T)
    rows = np.zeros(WIDTH * len(boxes.inside))
    flat_boxes = flat(boxes.middles), flat(boxes.halves), flat(boxes.axes)
    box_rows(*flat_boxes, (a, b, c), mesh.position, mesh.factor, rows)
    return read_only(rows)


class _Boxes(NamedTuple):
    """A tree of boxes that hold the triangles of a surface, in the file's unit.

    Attributes:
        middles: (n, 3).
        halves: half sizes (n, 3).
        axes: as columns (n, 3, 3).
        inside: first and last but one of the boxes in each, 0 and 0 of the last ones, (n, 2).
    """

    middles: FloatArray
    halves: FloatArray
    axes: FloatArray
    inside: IntArray


@lru_cache(maxsize=16)
def _boxes_of(surface: Surface) -> _Boxes:
    """Boxes of a tree over the triangles, and a flat one for each triangle, in its plane.

    Of a mesh of many triangles these are left out. Each box holds those inside it: were a flat one
    to stick out, an arm could be clear of the one and in the way of the other.
    """
    tree = tree_of(surface)
    low, high = np.split(tree.boxes.reshape(-1, 6), 2, axis=1)
    nodes = len(low)
    inner = nodes // 2
    inside = np.zeros((nodes, 2), dtype=np.int32)
    inside[:inner] = 2 * np.arange(inner)[:, None] + (1, 3)
    upright = np.tile(np.eye(3), (nodes, 1, 1))
    if len(surface.faces) > _MOST_TRIANGLES:
        return _Boxes((low + high) / 2, (high - low) / 2, upright, inside)
    inside[inner:, 0], inside[inner:, 1] = tree.leaves[:-1] + nodes, tree.leaves[1:] + nodes
    corners = tree.corners.reshape(-1, 3, 3)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    # any orthonormal axes do: those of a triangle with no width are whatever comes out
    axes, _ = np.linalg.qr(np.stack([first, second, np.cross(first, second)], axis=2))
    own = np.einsum("nij,nki->nkj", axes, corners)
    middles = np.einsum("nij,nj->ni", axes, (own.min(axis=1) + own.max(axis=1)) / 2)
    halves = np.ptp(own, axis=1) / 2
    spread = np.einsum("nij,nj->ni", np.abs(axes), halves)
    low = _united(np.minimum, middles - spread, tree.leaves, inner)
    high = _united(np.maximum, middles + spread, tree.leaves, inner)
    return _Boxes(
        np.concatenate([(low + high) / 2, middles]),
        np.concatenate([(high - low) / 2, halves]),
        np.concatenate([upright, axes]),
        np.concatenate([inside, np.zeros((len(corners), 2), dtype=np.int32)]),
    )


def _united(outer: np.ufunc, corners: FloatArray, leaves: IntArray, inner: int) -> FloatArray:
    """Outer corner (nodes, 3) of each box of a tree, from those of what its leaves hold."""
    united = np.empty((2 * inner + 1, 3))
    united[inner:] = outer.reduceat(corners, leaves[:-1])
    for k in range(inner - 1, -1, -1):
        united[k] = outer(united[2 * k + 1], united[2 * k + 2])
    return united


def _rows(centres: FloatArray, axes: FloatArray, halves: FloatArray, radius: float) -> FloatArray:
    """Rows of boxes, or of capsules along their z, without a tree, flat (n WIDTH,).

    Args:
        centres: (n, 3), [unit], world.
        axes: in the world, as columns (n, 3, 3).
        halves: half sizes (n, 3), [unit].
        radius: around the core, [unit].
    """
    reach = np.einsum("nij,nj->ni", np.abs(axes), halves) + radius
    core = np.broadcast_to([radius, 0.0], (len(centres), 2))
    turned = np.swapaxes(axes, 1, 2).reshape(-1, 9)
    tree = np.zeros((len(centres), WIDTH - TREE))
    columns = (centres, turned, halves, core, centres - reach, centres + reach, tree)
    return np.concatenate(columns, axis=1).ravel()
