"""What boxes enclose that share sides and edges, whichever side their triangles face."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh import enclosed
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.winding import windings
from tests.abi import meshes
from tests.abi.meshes import Mesh
from tests.thorough import examples


def damaged_boxes(rng: np.random.Generator) -> tuple[Mesh, FloatArray]:
    """Boxes that are flush, with triangles inside out or there twice, shuffled; points in them."""
    parts, points = list[Mesh](), list[FloatArray]()
    for _ in range(rng.integers(2, 4)):
        low = rng.integers(0, 2, 3) * 1.0
        size = np.minimum(rng.integers(1, 3, 3), 2 - low)
        vertices, faces = meshes.box((size[0], size[1], size[2]), tuple((low + size / 2).tolist()))
        if rng.random() < 0.5:  # other triangles in the same sides
            vertices = vertices * [-1, 1, 1] + [2 * low[0] + size[0], 0, 0]
            faces = faces[:, ::-1]
        turned = rng.random(12) < rng.choice([0, 0.1, 1])
        faces = np.where(turned[:, None], faces[:, ::-1], faces)
        parts.append((vertices, faces))
        parts.append((vertices, faces[rng.random(12) < rng.choice([0, 0.3])]))
        points.append(rng.uniform(low + 0.01, low + size - 0.01, (8, 3)))
    vertices, faces = meshes.joined(*parts)
    return (vertices, faces[rng.permutation(len(faces))]), np.concatenate(points)


def is_solid(surface: Surface, points: FloatArray) -> np.ndarray:
    return np.asarray(surface.closed & (windings(surface.vertices, surface.faces, points) != 0))


@pytest.mark.slow
@example(10)
@example(45)
@example(87)
@given(st.integers(0, 2**32 - 1))
@settings(max_examples=examples(15))
def test_boxes_are_solid_or_told_however_their_triangles_are_damaged(seed: int) -> None:
    rng = np.random.default_rng(seed)
    (vertices, faces), points = damaged_boxes(rng)
    surface = clean(vertices, faces)
    told = any("thin shell" in note for note in surface.notes)
    assert told or is_solid(surface, points).all()
    # and nothing may cross any triangle
    corners = (rng.dirichlet(np.ones(3), 4) @ vertices[faces]).reshape(-1, 3)
    left = corners[~is_solid(surface, corners)]
    every = surface.vertices[surface.faces]
    pairs = np.repeat(every, len(left), axis=0), np.tile(left, (len(every), 1))
    nearest = trimesh.triangles.closest_point(*pairs)  # type: ignore[no-untyped-call]
    away = np.linalg.norm(nearest - pairs[1], axis=1)
    assert away.reshape(len(every), -1).min(axis=0).max(initial=0) < 1e-6


@pytest.mark.parametrize("inside_out", [False, True])
@pytest.mark.parametrize("is_mirrored", [False, True])
def test_a_box_in_one_that_it_is_flush_with_leaves_none_hollow(
    inside_out: bool, is_mirrored: bool
) -> None:
    outer, inner = meshes.box((2, 2, 2)), meshes.box((2, 1, 2), (0, 0.5, 0))
    if is_mirrored:  # then their common side is cut along another diagonal
        inner = inner[0] * [-1, 1, 1], inner[1][:, ::-1]
    if inside_out:
        outer = meshes.inverted(outer)
    far = meshes.box(at=(9, 0, 0))
    surface = clean(*meshes.joined(outer, inner, far))
    assert is_solid(surface, np.array([[0, 0.5, 0], [0, -0.5, 0], [9, 0, 0]])).all()
    assert not is_solid(surface, np.array([[0, 1.1, 0], [1.1, 0.5, 0], [0, 0, 1.1]])).any()
    assert not any("thin shell" in note for note in surface.notes)
    assert any("inside out" in note for note in surface.notes) == inside_out


@pytest.mark.parametrize("limit", ["_MOST_PATCHES", "_MOST_GROUPS", "_MOST_TRIANGLES"])
def test_boxes_too_many_to_tell_apart_are_solid_or_told(
    limit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(enclosed, limit, 1)
    pair = meshes.joined(meshes.inverted(meshes.box((2, 2, 2))), meshes.box((2, 1, 2), (0, 0.5, 0)))
    places = np.array([[0, 0, 0], [5, 0, 0], [10, 0, 0]])
    mirrored = pair[0] * [-1, 1, 1], pair[1][:, ::-1]
    several = [(one[0] + place, one[1]) for one in (pair, mirrored) for place in places]
    surface = clean(*meshes.joined(*several))
    points = np.concatenate([places + above for above in ([0, 0.5, 0], [0, -0.5, 0])])
    told = any("thin shell" in note for note in surface.notes)
    assert told or is_solid(surface, points).all()


def cut_box(low: tuple[int, int, int], high: tuple[int, int, int]) -> Mesh:
    """A box whose sides are cut into squares of side 1, as those of voxels are."""
    vertices, faces = list[FloatArray](), list[list[int]]()
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for outward, height in ((False, low[axis]), (True, high[axis])):
            for i in range(low[u], high[u]):
                for j in range(low[v], high[v]):
                    square = np.zeros((4, 3))
                    square[:, axis] = height
                    square[:, u], square[:, v] = i + np.array([0, 1, 1, 0]), j + np.arange(4) // 2
                    first = 4 * len(vertices)
                    both = [[first, first + 1, first + 2], [first, first + 2, first + 3]]
                    faces += both if outward else [one[::-1] for one in both]
                    vertices.append(square)
    return np.concatenate(vertices), np.array(faces, dtype=np.int32)


@pytest.mark.parametrize("most", [1, 1000])
def test_valid_boxes_are_solid_or_told_however_many_more_there_are(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(enclosed, "_MOST_PATCHES", most)
    rest = [cut_box((1, 0, 2), (3, 2, 3)), meshes.box((2, 2, 1), (2, 1, 1.5))]
    surface = clean(*meshes.joined(cut_box((0, 1, 2), (2, 3, 4)), *rest))
    told = any("thin shell" in note for note in surface.notes)
    points = np.array([[1.3, 1.3, 2.4], [1.7, 1.6, 2.6], [0.5, 2.5, 3.5], [2.5, 0.5, 1.5]])
    assert told != is_solid(surface, points).all()
    assert not told or most == 1


@pytest.mark.parametrize(("seed", "noise"), [(4, 0), (13, 0), (2, 4e-7)])
def test_flush_boxes_stay_solid_with_corners_on_the_edges_of_those_inside(
    seed: int, noise: float
) -> None:
    """With noise there is nothing in the slivers between sides that should lie on each other."""
    rng, soup = np.random.default_rng(seed), []
    outer = cut_box((0, 0, 0), (3, 3, 3)), cut_box((3, 0, 0), (5, 3, 3))
    vertices, faces = meshes.joined(
        *outer, cut_box((1, 1, 1), (3, 2, 2)), cut_box((2, 1, 1), (3, 2, 2))
    )
    for a, b, c in np.roll(vertices[faces], rng.integers(3), axis=1):
        is_cut = rng.random() < 0.3 and min(*a, *b) >= 1 and max(*a, *b) <= 3
        soup += [(a, (a + b) / 2, c), ((a + b) / 2, b, c)] if is_cut else [(a, b, c)]
    corners = np.reshape(soup, (-1, 3))
    corners += rng.uniform(-noise, noise, corners.shape)
    surface = clean(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))
    points = np.array([[1.5, 1.5, 1.5], [2.5, 1.5, 1.5], [0.5, 0.5, 0.5], [4, 1, 1]])
    assert is_solid(surface, points).all()
    assert not any("inside out" in note for note in surface.notes)


def test_cubes_that_touch_in_edges_leave_flush_boxes_beside_them_solid(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They are no part of what the boxes enclose, however many they are."""
    monkeypatch.setattr(enclosed, "_MOST_PATCHES", 10)
    outer, inner = meshes.box((2, 2, 2)), meshes.box((2, 1, 2), (0, 0.5, 0))
    places = [(1.5 + k, 1.5 + k, 0) for k in range(8)]
    cubes = [meshes.box((1, 1, 2), place) for place in places]
    surface = clean(*meshes.joined(meshes.inverted(outer), inner, *cubes))
    assert is_solid(surface, np.array([(0, 0.5, 0), (0, -0.5, 0), *places])).all()
    assert not any("thin shell" in note for note in surface.notes)


@pytest.mark.parametrize("seed", range(4))
def test_a_valid_box_is_solid_or_told_where_another_crosses_it_beside_some_inside_out(
    seed: int,
) -> None:
    """What touches it in edges, turned outward on the whole, would wind around it -1 times."""
    lows = np.array([[2, 1, 1], [1.5, 1.5, 0.5], [0, 0, 0], [2, 0, 0], [2, 1, 0]])
    highs = np.array([[3, 3, 2], [3.5, 2.5, 1.5], [2, 2, 2], [4, 1, 2], [3, 2, 1]])
    block = cut_box((0, 0, 2), (2, 2, 4))
    parts = [meshes.box(tuple(b - a), tuple((a + b) / 2)) for a, b in zip(lows, highs, strict=True)]
    parts[3:] = [meshes.inverted(one) for one in parts[3:]]
    parts[3] = meshes.inverted(cut_box((2, 0, 0), (4, 1, 2)))
    vertices, faces = meshes.joined(*parts, block)
    surface = clean(vertices, np.random.default_rng(seed).permutation(faces))
    told = any("thin shell" in note for note in surface.notes)
    points = np.random.default_rng(seed).uniform(lows[0] + 0.01, highs[0] - 0.01, (200, 3))
    assert told or is_solid(surface, points).all()
