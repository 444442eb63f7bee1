"""Nodes of a GLB file, which place its meshes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.pose import rotation

Item = Callable[[str, object], dict[str, Any]]
_MOST_NODES = 10_000
_LARGEST = 1e9
_PARTS_OF_POSE = {"translation", "rotation", "scale"}


def placed_meshes(item: Item, roots: object) -> list[tuple[object, FloatArray, object]]:
    """Meshes of a scene, the pose (4, 4) of each, and the weights of its morphs.

    Args:
        item: entry of a list of the document, by the list's name and its number.
        roots: numbers of the scene's nodes.

    Raises:
        ValueError: nodes form no forest, have a skeleton, or are too far away.
    """
    waiting: list[tuple[object, FloatArray]] = [(root, np.eye(4)) for root in _ids(roots)]
    seen: set[object] = set()
    found = []
    while waiting:
        index, outer = waiting.pop()
        node = item("nodes", index)
        if index in seen or len(seen) > _MOST_NODES:
            raise ValueError("a GLB file whose nodes form a tree of at most 10,000")
        seen.add(index)
        if "matrix" in node and node.keys() & _PARTS_OF_POSE:
            raise ValueError(
                "a GLB file whose nodes have a matrix or a translation, rotation and scale, "
                f"nodes[{index}] has both"
            )
        pose = outer @ _pose(node)
        if not np.isfinite(pose).all() or np.abs(pose).max() > _LARGEST:
            raise ValueError("a GLB file whose nodes stay within 1e9")
        if "skin" in node:
            raise ValueError(
                f"a GLB file without a skeleton, nodes[{index}] has one: apply the pose in the "
                "program that wrote it"
            )
        if "mesh" in node:
            found.append((node["mesh"], pose, node.get("weights")))
        waiting += [(child, pose) for child in _ids(node.get("children", []))]
    return found


def _ids(values: object) -> list[object]:
    if not isinstance(values, list):
        raise ValueError("a GLB file whose nodes are lists")
    return values


def _pose(node: dict[str, Any]) -> FloatArray:
    """Local pose (4, 4) of a node: its matrix, or translation times rotation times scale."""
    if "matrix" in node:
        pose = _floats(node["matrix"], 16).reshape(4, 4).T
        if (pose[3] != (0, 0, 0, 1)).any():
            raise ValueError("a GLB file whose matrices end with 0, 0, 0, 1 in their last row")
        return pose
    pose = np.eye(4)
    x, y, z, w = _floats(node.get("rotation", [0, 0, 0, 1]), 4).tolist()
    if not math.hypot(x, y, z, w) > 1e-6:
        raise ValueError("a GLB file whose rotations are not zero")
    pose[:3, :3] = rotation((w, x, y, z)) * _floats(node.get("scale", [1, 1, 1]), 3)
    pose[:3, 3] = _floats(node.get("translation", [0, 0, 0]), 3)
    return pose


def _floats(values: object, count: int) -> FloatArray:
    if (
        not isinstance(values, list)
        or len(values) != count
        or any(type(v) not in (int, float) or not abs(v) <= _LARGEST for v in values)
    ):
        raise ValueError(f"a GLB file whose poses are {count} numbers within 1e9")
    return np.array(values, dtype=np.float64)
