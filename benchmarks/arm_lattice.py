"""Fine lattice of tool places on both elbow branches: whether an arm has a motion at all.

It shares nothing with the planner but the distance of a segment to the obstacles: a cubic lattice
with 26 neighbours, joints by the cosine rule, poses tried one by one, and the edges of a path tried
densely, until no edge of it is refused.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import scipy

from abi.arrays import BoolArray, FloatArray, IntArray
from abi.obstacles.obstacle_set import ObstacleSet
from abi.obstacles.primitives import Capsule
from abi.robot.paper_arm.link_capsules import COLUMN
from abi.robot.paper_arm.paper_arm import PaperArm
from abi.scene.scene import Scene

NODES = 100_000
_STEP = 0.05
"""Between the poses that are tried along an edge, [unit]."""
_TURN = 0.05
"""The same, of q1, [rad]."""
_MOST_REPAIRS = 400
_FLAT = 1e-9
_SIDES: tuple[Literal[1, -1], ...] = (1, -1)


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of an arm by tool place and branch, tried without margins."""

    scene: Scene
    arm: PaperArm

    @cached_property
    def obstacles(self) -> ObstacleSet:
        """The scene's."""
        return ObstacleSet(self.scene.obstacles)

    @cached_property
    def _column(self) -> ObstacleSet:
        x, y, z = self.arm.base.tolist()
        still = [c for c in self.arm.capsules if c.body == COLUMN]
        return ObstacleSet(
            tuple(
                Capsule(
                    shape="capsule",
                    radius=c.radius,
                    height=max(c.high - c.low, _FLAT),
                    position=(x, y, z + (c.low + c.high) / 2),
                )
                for c in still
            )
        )

    def free(self, points: FloatArray, sides: FloatArray) -> BoolArray:
        """Check whether tool and arm are clear at places (n, 3) on branches (n,), 1 or -1."""
        joints, reached = self.joints(points, sides)
        free = reached & self._tool_is_free(points)
        rows = np.flatnonzero(free)
        ends = self.arm.place(joints[rows])
        floor = min(float(self.arm.base[2]), self.scene.workspace.min[2])
        for k, capsule in enumerate(self.arm.capsules):
            low, high = (np.ascontiguousarray(ends[:, k, side]) for side in (0, 1))
            touching = self.obstacles.blocked(low, high, capsule.radius + self.scene.arm.clearance)
            if capsule.body != COLUMN:
                if not capsule.neighbour:
                    touching |= self._column.blocked(low, high, capsule.radius)
                if not capsule.grips:
                    touching |= np.minimum(low[:, 2], high[:, 2]) - capsule.radius < floor
            free[rows[touching]] = False
            rows, ends = rows[~touching], ends[~touching]
        return free

    def edge_is_free(self, a: FloatArray, b: FloatArray, side: int) -> bool:
        """Check whether the way between two places (3,) is, on one branch."""
        shares = self._shares(a, b)
        if shares is None:
            return False
        points = a + shares[:, None] * (b - a)
        if self.obstacles.blocked(a[None], b[None], self.scene.spline.clearance)[0]:
            return False
        return bool(self.free(points, np.full(len(points), float(side))).all())

    def _shares(self, a: FloatArray, b: FloatArray) -> FloatArray | None:
        """Shares of a way at which it is tried, near in place and in the angle of q1.

        None where it runs through the base axis: there q1 would jump to the other side.
        """
        count = max(2, int(np.linalg.norm(b - a) / _STEP) + 2)
        shares = np.linspace(0, 1, count)
        first, way = (a - self.arm.base)[:2], (b - a)[:2]
        square = float(way @ way)
        if square == 0:
            return shares
        foot = -float(first @ way) / square
        off = abs(first[0] * way[1] - first[1] * way[0]) / square
        if off < _FLAT:
            return None if 0 <= foot <= 1 else shares
        low, high = np.arctan2([-foot, 1 - foot], off)
        angles = np.linspace(low, high, int((high - low) / _TURN) + 2)
        return np.union1d(shares, np.clip(foot + off * np.tan(angles), 0, 1))

    def turn_is_free(self, a: FloatArray) -> bool:
        """Check whether the arm may stretch from a place (3,), and bend the other way."""
        shoulder = self.arm.shoulder
        away = a - shoulder
        full = shoulder + away / np.linalg.norm(away) * (self._longest - 1e-9)
        box = self.scene.workspace
        if (full < box.min).any() or (full > box.max).any():
            return False
        return all(self.edge_is_free(a, full, side) for side in _SIDES)

    def nearly_stretched(self, points: FloatArray, within: float) -> BoolArray:
        """Places (n, 3) at most so far from full stretch."""
        away = np.linalg.norm(points - self.arm.shoulder, axis=1)
        return np.asarray((away <= self._longest) & (away > self._longest - within))

    @property
    def _longest(self) -> float:
        return float(self.arm.a3 + self.arm.forearm(self.scene.arm.q5))

    def _tool_is_free(self, points: FloatArray) -> BoolArray:
        return ~self.obstacles.blocked(points, points, self.scene.spline.clearance)

    def joints(self, points: FloatArray, sides: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Joints (n, 6) by the cosine rule, and whether they are within reach and limits."""
        x, y, z = (points - self.arm.shoulder).T
        upper, lower = self.arm.a3, float(self.arm.forearm(self.scene.arm.q5))
        r = np.hypot(x, y)
        cosine = (r**2 + z**2 - upper**2 - lower**2) / (2 * upper * lower)
        q3 = sides * np.arccos(np.clip(cosine, -1, 1))
        q2 = np.arctan2(r, z) - np.arctan2(lower * np.sin(q3), upper + lower * np.cos(q3))
        joints = np.zeros((len(points), 6))
        joints[:, 0] = np.arctan2(x, -y)
        joints[:, 1], joints[:, 2], joints[:, 4] = q2, q3, self.scene.arm.q5
        limits = self.arm.limits
        within = (np.abs(cosine) <= 1) & (q2 >= limits[1, 0]) & (q2 <= limits[1, 1])
        return joints, within & (q3 >= limits[2, 0]) & (q3 <= limits[2, 1])


def lattice_motion(scene: Scene, arm: PaperArm, nodes: int = NODES) -> float | None:
    """Length of the tool's path along a lattice's edges, [unit]; None where there is none.

    Args:
        scene: the scene; its elbow counts as auto.
        arm: its arm.
        nodes: of the lattice, about, of both branches together.
    """
    poses = Poses(scene, arm)
    points, shape = _places(scene, nodes // 2)
    count = len(points)
    both = np.concatenate([points, points])
    sides = np.repeat(np.array(_SIDES, dtype=float), count)
    free = poses.free(both, sides)
    pairs = _pairs(shape, points, scene)
    lines = np.concatenate([pairs, pairs + count])
    step = float((np.subtract(scene.workspace.max, scene.workspace.min) / shape).max())
    turns = np.flatnonzero(poses.nearly_stretched(points, step))
    lines = np.concatenate([lines, np.stack([turns, turns + count], axis=1)])
    lines = lines[free[lines].all(axis=1)]
    ends = [end for end in (count - 2, 2 * count - 2) if free[end]]
    goals = [end for end in (count - 1, 2 * count - 1) if free[end]]
    return _search(poses, both, lines, (ends, goals), count)


def _search(
    poses: Poses, points: FloatArray, lines: IntArray, ends: tuple[list[int], list[int]], half: int
) -> float | None:
    """Shortest path along lines whose ends are free, without those that turn out not to be."""
    starts, goals = ends
    if not starts or not goals:
        return None
    lengths = np.linalg.norm(points[lines[:, 0]] - points[lines[:, 1]], axis=1) + 1e-9
    tried: set[tuple[int, int]] = set()
    matrix = scipy.sparse.csr_array(
        (lengths, (lines[:, 0], lines[:, 1])), (len(points), len(points))
    )
    matrix = (matrix + matrix.T).tocsr()
    for _ in range(_MOST_REPAIRS):
        away, before, _ = scipy.sparse.csgraph.dijkstra(
            matrix, indices=starts, min_only=True, return_predecessors=True
        )
        goal = min(goals, key=lambda end: away[end])
        if not np.isfinite(away[goal]):
            return None
        path = _path(before, goal)
        shut = []
        for a, b in itertools.pairwise(path):
            if (a, b) in tried:
                continue
            side = 1 if a < half else -1
            turning = (a < half) != (b < half)
            is_free = (
                poses.turn_is_free(points[a])
                if turning
                else poses.edge_is_free(points[a], points[b], side)
            )
            if is_free:
                tried.add((a, b))
            else:
                shut.append((a, b))
        if not shut:
            return float(away[goal])
        for a, b in shut:
            _shut(matrix, a, b)
            _shut(matrix, b, a)
    return None


def _shut(matrix: scipy.sparse.csr_array, a: int, b: int) -> None:
    """Make an edge endless."""
    row = slice(matrix.indptr[a], matrix.indptr[a + 1])
    matrix.data[row][matrix.indices[row] == b] = np.inf


def _path(before: IntArray, goal: int) -> list[int]:
    path = [goal]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return path[::-1]


def _places(scene: Scene, count: int) -> tuple[FloatArray, tuple[int, int, int]]:
    """Places of a cubic lattice that fills the workspace, then start and goal; and its shape."""
    box = scene.workspace
    sides = np.subtract(box.max, box.min)
    cell = float(np.prod(sides) / count) ** (1 / 3)
    x, y, z = (max(2, round(float(side) / cell) + 1) for side in sides)
    axes = [np.linspace(a, b, k) for a, b, k in zip(box.min, box.max, (x, y, z), strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.concatenate([grid, [scene.start, scene.goal]]), (x, y, z)


def _pairs(shape: tuple[int, int, int], points: FloatArray, scene: Scene) -> IntArray:
    """Neighbours in the lattice, (k, 2), and start and goal with the places around them."""
    ids = np.arange(np.prod(shape)).reshape(shape)
    ways = [way for way in np.ndindex(3, 3, 3) if way > (1, 1, 1)]
    pairs = []
    for way in ways:
        steps = np.subtract(way, 1)
        first = ids[tuple(slice(max(0, -s), shape[k] - max(0, s)) for k, s in enumerate(steps))]
        second = ids[tuple(slice(max(0, s), shape[k] - max(0, -s)) for k, s in enumerate(steps))]
        pairs.append(np.stack([first.ravel(), second.ravel()], axis=1))
    cell = float((np.subtract(scene.workspace.max, scene.workspace.min) / shape).max())
    for end in (len(points) - 2, len(points) - 1):
        near = np.flatnonzero(np.linalg.norm(points[:-2] - points[end], axis=1) < 2 * cell)
        pairs.append(np.stack([np.full(len(near), end), near], axis=1))
    return np.concatenate(pairs).astype(np.int32)
