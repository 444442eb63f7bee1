from __future__ import annotations

import numpy as np
import pytest

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh.bvh import (
    TriangleTree,
    build_tree,
    highest_in_slab,
    moved,
)
from abi.obstacles.triangle_mesh.bvh_kernels import BINS, MOST
from tests.abi import meshes


def triangles_of(name: str) -> FloatArray:
    random = np.random.default_rng(3)
    if name == "alike":
        return np.tile(np.eye(3), (300, 1, 1))
    if name == "pipe":  # coordinates that rise and fall along the file
        shift = np.concatenate([np.arange(500.0), np.arange(500.0)[::-1]])
        return np.asarray(np.eye(3) + shift[:, None, None])
    if name == "far off":  # one that stretches all bins
        return np.concatenate([random.random((300, 3, 3)), random.random((1, 3, 3)) + 1e6])
    if name == "huge":  # differences of them overflow
        return np.asarray((random.random((300, 3, 3)) - 0.5) * 3e308)
    if name == "flat":
        return np.asarray(random.random((777, 3, 3)) * (1, 1, 0))
    vertices, faces = meshes.knot(2_000) if name == "knot" else meshes.soup(int(name))
    return np.asarray(vertices[faces])


NAMES = ("1", "3", "8", "9", "511", "knot", "alike", "pipe", "flat", "far off")


def leaf_of(tree: TriangleTree, node: int) -> tuple[int, int]:
    """First and last leaf below a node, and one more."""
    count = len(tree.leaves) - 1
    first = last = node
    while first < count - 1:
        first, last = 2 * first + 1, 2 * last + 2
    return first - count + 1, last - count + 2


@pytest.mark.parametrize("name", [*NAMES, "huge"])
def test_boxes_hold_their_triangles_and_no_more(name: str) -> None:
    triangles = triangles_of(name)
    tree = build_tree(triangles)
    corners = tree.corners.reshape(-1, 3, 3)
    rows = np.sort(corners.reshape(-1, 9), axis=0)
    assert np.array_equal(rows, np.sort(triangles.reshape(-1, 9), axis=0))
    boxes = tree.boxes.reshape(-1, 2, 3)
    assert len(boxes) == 2 * len(tree.leaves) - 3
    for node in range(len(boxes)):
        first, last = leaf_of(tree, node)
        held = corners[tree.leaves[first] : tree.leaves[last]].reshape(-1, 3)
        assert np.array_equal(boxes[node], [held.min(axis=0), held.max(axis=0)])
    assert tree.size == np.abs(triangles).max()


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_higher_than_its_slab_and_something_is_as_high_along_it(name: str) -> None:
    triangles = triangles_of(name)
    far = moved(build_tree(triangles + 1e6), np.full(3, 1e6), 0.5)
    random = np.random.default_rng(5)
    for tree in (build_tree(triangles), far):
        corners = tree.corners.reshape(-1, 3)
        for node in random.integers(0, len(tree.boxes) // 6, 20).tolist():
            first, last = leaf_of(tree, node)
            held = corners[3 * tree.leaves[first] : 3 * tree.leaves[last]]
            normal = tree.slabs[5 * node : 5 * node + 3]
            for direction in (normal, -normal, *random.normal(size=(5, 3))):
                x, y, z = direction.tolist()
                bound = highest_in_slab(tree, node, (x, y, z))
                most = (held @ direction).max()
                assert bound >= most - 1e-13 * tree.size
                if np.array_equal(abs(direction), abs(normal)) and normal.any():
                    assert bound == pytest.approx(most, abs=1e-12 * tree.size)


def surface_of(boxes: FloatArray) -> float:
    """Half of the surface of what encloses boxes (n, 2, 3)."""
    x, y, z = boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)
    return float(x * y + y * z + z * x)


def cost_of(before: FloatArray, behind: FloatArray) -> float:
    return len(before) * surface_of(before) + len(behind) * surface_of(behind)


@pytest.mark.parametrize("name", NAMES)
def test_no_cut_between_bins_is_cheaper_than_that_of_a_node(name: str) -> None:
    tree = build_tree(triangles_of(name))
    corners = tree.corners.reshape(-1, 3, 3)
    boxes = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)
    assert 1 <= np.diff(tree.leaves).min() <= np.diff(tree.leaves).max() <= MOST
    for node in range((len(tree.boxes) // 6) // 2):
        (first, middle), (_, last) = leaf_of(tree, 2 * node + 1), leaf_of(tree, 2 * node + 2)
        begin, cut, end = tree.leaves[[first, middle, last]]
        own, half = boxes[begin:end], middle - first
        low, high = (middles := own.mean(axis=1)).min(axis=0), middles.max(axis=0)
        cheapest = np.inf
        for axis in np.flatnonzero(high > low):
            place = (middles[:, axis] - low[axis]) / (high[axis] - low[axis])
            bins = np.minimum((place * BINS).astype(int), BINS - 1)
            for edge in range(1, BINS):
                before, behind = own[bins < edge], own[bins >= edge]
                sizes = len(before), len(behind)
                if half <= min(sizes) and max(sizes) <= MOST * half:
                    cheapest = min(cheapest, cost_of(before, behind))
        if cheapest < np.inf:
            cost = cost_of(boxes[begin:cut], boxes[cut:end])
            assert cost == pytest.approx(cheapest, rel=1e-9)
        else:
            assert abs((cut - begin) - (end - cut)) <= 1
            widest = int((high - low).argmax())
            here = middles[: cut - begin, widest].max()
            assert here <= middles[cut - begin :, widest].min()


def test_a_moved_tree_is_the_tree_of_the_moved_triangles() -> None:
    triangles = triangles_of("knot")
    centre = np.array([0.1, -7.3, 1e4 / 3])
    tree = moved(build_tree(triangles), centre, 0.25)
    again = build_tree((triangles - centre) * 0.25)
    assert np.array_equal(tree.boxes, again.boxes)
    assert np.array_equal(tree.leaves, again.leaves)
    assert tree.size == again.size
