from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from abi.arrays import FloatArray
from abi.curves import curve
from abi.curves.bspline import BSpline, clamped, fit
from abi.obstacles.obstacle_set import NO_OBSTACLES, ObstacleSet
from abi.obstacles.primitives import (
    Box,
    Capsule,
    Cylinder,
    Obstacle,
    Obstacles,
    Sphere,
)


@st.composite
def splines(draw: st.DrawFn) -> BSpline:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    degree = draw(st.integers(1, 5))
    points = rng.uniform(-1, 1, (draw(st.integers(degree + 1, 12)), 3))
    return clamped(points * 10.0 ** draw(st.floats(-3, 3)), degree)


def basis(knots: FloatArray, k: int, degree: int, u: float) -> float:
    """Cox-de Boor recursion, an oracle; u below the last knot."""
    if degree == 0:
        return float(knots[k] <= u < knots[k + 1])
    value = 0.0
    rise, fall = knots[k + degree] - knots[k], knots[k + degree + 1] - knots[k + 1]
    if rise > 0:
        value += (u - knots[k]) / rise * basis(knots, k, degree - 1, u)
    if fall > 0:
        value += (knots[k + degree + 1] - u) / fall * basis(knots, k + 1, degree - 1, u)
    return value


def obstacle(rng: np.random.Generator, size: float) -> Obstacle:
    x, y, z = (rng.uniform(0.15, 0.85, 3) * size).tolist()
    w, i, j, k = rng.normal(size=4).tolist()
    a, b, c = (rng.uniform(0.05, 0.35, 3) * size).tolist()
    pose = {"position": (x, y, z), "wxyz": (w, i, j, k)}
    kind = rng.integers(4)
    if kind == 0:
        return Box(size=(a, b, c), **pose)
    if kind == 1:
        return Sphere(radius=a, **pose)
    if kind == 2:
        return Cylinder(radius=a / 2, height=b, **pose)
    return Capsule(radius=a / 3, height=b, **pose)


def taut_path(
    rng: np.random.Generator, obstacles: Obstacles, size: float, margin: float
) -> FloatArray | None:
    """Shortest path between opposite corners over random points, most of them near obstacles.

    All its segments keep the margin, and its corners hug the obstacles. None when there is no way.
    """
    points = rng.uniform(0, size, (70, 3))
    points[:2] = [[0.0] * 3, [size] * 3]
    distance, index = ObstacleSet(obstacles).nearest(points)
    for k, one in enumerate(obstacles):
        rows = 2 + np.flatnonzero((index[2:] == k) & (rng.random(len(points) - 2) < 0.7))
        out = 1.01 * margin + 0.001 * size - distance[rows]
        points[rows] += one.gradient(points[rows]) * out[:, None]
    clear = ObstacleSet(obstacles).nearest(points)[0] > margin
    if not clear[:2].all():
        return None
    points = points[clear]
    i, j = np.triu_indices(len(points), 1)
    lengths = np.linalg.norm(points[i] - points[j], axis=1)
    seen = ~ObstacleSet(obstacles).blocked(points[i], points[j], margin)
    seen &= lengths < rng.choice([0.3, 0.6, 2.0]) * size
    weights = np.zeros((len(points), len(points)))
    weights[i[seen], j[seen]] = lengths[seen]
    _, before = dijkstra(weights, directed=False, indices=0, return_predecessors=True)
    if before[1] < 0:
        return None
    way = [1]
    while way[-1] != 0:
        way.append(int(before[way[-1]]))
    return np.asarray(points[way[::-1]])


def scenes(
    first_seed: int, count: int, slack: float
) -> list[tuple[FloatArray, Obstacles, float, float]]:
    """Path, obstacles, clearance and size; the path keeps the clearance + slack·size."""
    found = []
    for seed in range(first_seed, first_seed + count):
        rng = np.random.default_rng(seed)
        size = 10.0 ** rng.uniform(-3, 3)
        obstacles = tuple(obstacle(rng, size) for _ in range(rng.integers(1, 7)))
        clearance = float(rng.choice([0.0, 0.01, 0.05])) * size
        path = taut_path(rng, obstacles, size, clearance + slack * size)
        if path is not None:
            found.append((path, obstacles, clearance, size))
    return found


@settings(max_examples=60, deadline=None)
@given(splines(), st.floats(0, 1, exclude_max=True))
def test_point_is_the_sum_of_the_basis(spline: BSpline, u: float) -> None:
    count = len(spline.control_points)
    weights = [basis(spline.knots, k, spline.degree, u) for k in range(count)]
    assert sum(weights) == pytest.approx(1, rel=1e-12)
    scale = np.abs(spline.control_points).max()
    assert spline(u) == pytest.approx(weights @ spline.control_points, abs=1e-12 * scale)


@settings(max_examples=100, deadline=None)
@given(splines(), st.integers(1, 5))
def test_derivatives_are_differences(spline: BSpline, order: int) -> None:
    step = 1e-5
    middles = (spline.breaks[:-1] + spline.breaks[1:]) / 2
    ahead, behind = spline(middles + step, order - 1), spline(middles - step, order - 1)
    difference = (ahead - behind) / (2 * step)
    scale = np.abs(spline.control_points).max() * (2 * spline.degree * len(middles)) ** order
    assert np.abs(spline(middles, order) - difference).max() <= 1e-5 * scale


@settings(max_examples=60, deadline=None)
@given(splines())
def test_pieces_join_smoothly(spline: BSpline) -> None:
    inner = spline.breaks[1:-1]
    for order in range(spline.degree):
        scale = np.abs(spline.control_points).max() * (2 * spline.degree * len(inner) + 2) ** order
        jump = spline(inner + 1e-12, order) - spline(inner - 1e-12, order)
        assert np.all(np.abs(jump) <= 1e-8 * scale)


@settings(max_examples=60, deadline=None)
@given(splines(), st.integers(0, 2**32 - 1))
def test_pieces_lie_in_the_hull_of_their_control_points(spline: BSpline, seed: int) -> None:
    directions = np.random.default_rng(seed).normal(size=(3, 50))
    scale = 1e-12 * np.abs(spline.control_points @ directions).max()
    for k in range(len(spline.breaks) - 1):
        u = np.linspace(spline.breaks[k], spline.breaks[k + 1], 30)
        hull = spline.control_points[k : k + spline.degree + 1] @ directions
        reached = spline(u) @ directions
        assert np.all(reached <= hull.max(axis=0) + scale)
        assert np.all(reached >= hull.min(axis=0) - scale)


@settings(max_examples=60, deadline=None)
@given(splines())
def test_ends_are_exact_and_the_outside_is_clamped(spline: BSpline) -> None:
    first, last = spline.control_points[[0, -1]]
    assert np.array_equal(spline([-1.0, 0.0, 1.0, 2.0]), [first, first, last, last])


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_numbers_give_points_and_arrays_give_rows(order: int) -> None:
    spline = clamped(np.random.default_rng(0).normal(size=(6, 3)), 2)
    u = np.linspace(0, 1, 9)
    rows = spline(u, order)
    assert rows.shape == (9, 3)
    assert spline([], order).shape == (0, 3)
    for row, one in zip(rows, u, strict=True):
        assert np.array_equal(spline(float(one), order), row)


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_without_obstacles_the_vertices_are_the_control_points(degree: int, count: int) -> None:
    path = np.random.default_rng(count).normal(size=(count, 3))
    spline = fit(path, degree, NO_OBSTACLES, 0.5)
    assert np.array_equal(spline.control_points, path)
    assert spline.degree == min(degree, count - 1)
    assert spline.holds
    assert spline.clearance.distance == np.inf
    assert (spline.inserted, spline.moved) == (0, 0)
    assert np.array_equal(spline.breaks, np.linspace(0, 1, count - spline.degree + 1))


def test_two_vertices_give_a_straight_line() -> None:
    line = fit(
        np.array([[0.0, 0, 0], [2, 4, 6]]),
        4,
        ObstacleSet((Sphere(radius=1, position=(9, 9, 9)),)),
        0.5,
    )
    u = np.linspace(0, 1, 11)
    assert np.allclose(line(u), np.outer(u, [2, 4, 6]), rtol=0, atol=1e-14)
    assert line.holds


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
@pytest.mark.parametrize("slack", [0.006, 0.001])
def test_keeps_clear_wherever_the_path_is_clearer(degree: int, slack: float) -> None:
    changed = 0
    for path, obstacles, clearance, size in scenes(1000 * degree, 60, slack):
        spline = fit(path, degree, ObstacleSet(obstacles), clearance)
        assert spline.holds
        samples = spline(np.linspace(0, 1, 5001))
        assert ObstacleSet(obstacles).nearest(samples)[0].min() >= clearance - 1e-9
        assert clearance - 1e-9 <= spline.clearance.distance
        assert (
            spline.clearance.distance
            <= ObstacleSet(obstacles).nearest(samples)[0].min() + 1e-5 * size
        )
        assert np.array_equal(spline.control_points[[0, -1]], path[[0, -1]])
        assert np.all(spline.control_points >= path.min(axis=0))
        assert np.all(spline.control_points <= path.max(axis=0))
        assert spline.degree == min(degree, len(path) - 1)
        assert len(spline.control_points) == len(path) + spline.inserted
        polygon = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        assert curve.measure(spline).length <= polygon * (1 + 1e-12)
        # What is left alone is still the path.
        kept = spline.control_points[~spline.added & ~spline.pushed]
        assert {tuple(row) for row in kept} <= {tuple(row) for row in path}
        changed += spline.inserted + spline.moved > 0
    # Otherwise the scenes would have tested nothing.
    assert changed >= 5


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
def test_rounds_the_edge_of_a_plate_that_the_path_turns_at(degree: int) -> None:
    plate = (Box(size=(8, 0.02, 8), position=(0, 0, 0)),)
    path = np.array([[0, 3, 0], [2, 1.5, 0], [4.06, 0.1, 0], [4.06, -0.1, 0], [0, -3, 0.0]])
    assert ObstacleSet(plate).polyline_clearance(path) > 0.05
    plain = clamped(path, min(degree, 4))
    assert ObstacleSet(plate).nearest(plain(np.linspace(0, 1, 2001)))[0].min() < 0.05
    spline = fit(path, degree, ObstacleSet(plate), 0.05)
    assert spline.holds
    assert spline.inserted + spline.moved > 0
    assert spline.clearance.nearest >= 0.05 - 1e-9


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
def test_ends_that_just_keep_the_clearance_do_not_spoil_it(degree: int) -> None:
    obstacles = (Box(size=(2, 2, 2), position=(0, 0, 0)),)
    path = np.array([[-1.2, 0, 0], [-1.3, 1.3, 0], [0.0, 1.3, 0.4], [1.3, 1.3, 0], [1.2, 0.0, 0]])
    assert ObstacleSet(obstacles).polyline_clearance(path) == pytest.approx(0.2, abs=1e-12)
    spline = fit(path, degree, ObstacleSet(obstacles), 0.2)
    assert spline.holds
    assert spline.clearance.distance >= 0.2 - 1e-5


def test_a_path_along_a_face_at_the_clearance_holds() -> None:
    obstacles = (Box(size=(4, 4, 2), position=(0, 0, 0)),)
    path = np.array([[-1.5, 0, 1.2], [0, 0.5, 1.2], [1, -1, 1.2], [1.5, 1, 1.2]])
    assert fit(path, 3, ObstacleSet(obstacles), 0.2).holds


def test_a_path_through_an_obstacle_says_so() -> None:
    ball = (Sphere(radius=1, position=(0, 0, 0)),)
    path = np.array([[-3.0, 0, 0], [-2, 1, 0], [0, 0, 0], [2, 1, 0], [3, 0, 0]])
    spline = fit(path, 3, ObstacleSet(ball), 0.1)
    assert not spline.holds
    assert spline.clearance.distance >= -1 - 1e-3
    assert np.isfinite(spline.control_points).all()


def test_repeated_vertices_work() -> None:
    obstacles = (Box(size=(2, 2, 2), position=(0, 0, 0)),)
    corners = np.array([[-2, -1.2, 0], [-1.2, 1.2, 0], [1.2, 1.2, 0], [2, -1.2, 0]])
    for degree in (2, 3, 4, 5):
        spline = fit(np.repeat(corners, 3, axis=0), degree, ObstacleSet(obstacles), 0.1)
        assert spline.holds
        assert np.isfinite(spline(np.linspace(0, 1, 99), 1)).all()
        point = fit(np.repeat(corners[:1], 3, axis=0), degree, ObstacleSet(obstacles), 0.1)
        assert point.holds


def test_results_cannot_change() -> None:
    path = np.array([[-2, -1.2, 0], [-1.2, 1.2, 0], [1.2, 1.2, 0], [2, -1.2, 0]])
    spline = fit(path, 3, ObstacleSet((Box(size=(2, 2, 2)),)), 0.19)
    path[:] = 0
    assert spline.control_points.any()
    arrays = (spline.control_points, spline.knots, spline.breaks, spline.added, spline.pushed)
    assert not any(array.flags.writeable for array in arrays)
