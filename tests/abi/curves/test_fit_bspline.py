from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from abi.arrays import FloatArray
from abi.curves.bspline import clamped
from abi.curves.curve import arc_length
from abi.curves.fit_bspline import fit
from abi.obstacles.obstacle_set import NO_OBSTACLES, Obstacle, Obstacles, ObstacleSet
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere
from tests.abi.shape_distances import gradient


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
        points[rows] += gradient(one, points[rows]) * out[:, None]
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


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_without_obstacles_the_vertices_are_the_control_points(degree: int, count: int) -> None:
    path = np.random.default_rng(count).normal(size=(count, 3))
    found = fit(path, degree, NO_OBSTACLES, 0.5)
    spline = found.curve
    assert np.array_equal(spline.control_points, path)
    assert spline.degree == min(degree, count - 1)
    assert found.holds
    assert found.clearance.distance == np.inf
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
    assert np.allclose(line.curve(u), np.outer(u, [2, 4, 6]), rtol=0, atol=1e-14)
    assert line.holds


@pytest.mark.slow
@pytest.mark.parametrize("degree", [2, 3, 4, 5])
@pytest.mark.parametrize("slack", [0.006, 0.001])
def test_keeps_clear_wherever_the_path_is_clearer(degree: int, slack: float) -> None:
    changed = 0
    for path, obstacles, clearance, size in scenes(1000 * degree, 60, slack):
        found = fit(path, degree, ObstacleSet(obstacles), clearance)
        spline = found.curve
        assert found.holds
        samples = spline(np.linspace(0, 1, 5001))
        assert ObstacleSet(obstacles).nearest(samples)[0].min() >= clearance - 1e-9
        assert clearance - 1e-9 <= found.clearance.distance
        assert (
            found.clearance.distance
            <= ObstacleSet(obstacles).nearest(samples)[0].min() + 1e-5 * size
        )
        assert np.array_equal(spline.control_points[[0, -1]], path[[0, -1]])
        assert np.all(spline.control_points >= path.min(axis=0))
        assert np.all(spline.control_points <= path.max(axis=0))
        assert spline.degree == min(degree, len(path) - 1)
        assert len(spline.control_points) == len(path) + spline.inserted
        polygon = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        assert arc_length(spline).length <= polygon * (1 + 1e-12)
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
    found = fit(path, degree, ObstacleSet(plate), 0.05)
    spline = found.curve
    assert found.holds
    assert spline.inserted + spline.moved > 0
    assert found.clearance.nearest >= 0.05 - 1e-9


@pytest.mark.parametrize("degree", [2, 3, 4, 5])
def test_ends_that_just_keep_the_clearance_do_not_spoil_it(degree: int) -> None:
    obstacles = (Box(size=(2, 2, 2), position=(0, 0, 0)),)
    path = np.array([[-1.2, 0, 0], [-1.3, 1.3, 0], [0.0, 1.3, 0.4], [1.3, 1.3, 0], [1.2, 0.0, 0]])
    assert ObstacleSet(obstacles).polyline_clearance(path) == pytest.approx(0.2, abs=1e-12)
    found = fit(path, degree, ObstacleSet(obstacles), 0.2)
    assert found.holds
    assert found.clearance.distance >= 0.2 - 1e-5


def test_a_path_along_a_face_at_the_clearance_holds() -> None:
    obstacles = (Box(size=(4, 4, 2), position=(0, 0, 0)),)
    path = np.array([[-1.5, 0, 1.2], [0, 0.5, 1.2], [1, -1, 1.2], [1.5, 1, 1.2]])
    assert fit(path, 3, ObstacleSet(obstacles), 0.2).holds


def test_a_path_through_an_obstacle_says_so() -> None:
    ball = (Sphere(radius=1, position=(0, 0, 0)),)
    path = np.array([[-3.0, 0, 0], [-2, 1, 0], [0, 0, 0], [2, 1, 0], [3, 0, 0]])
    found = fit(path, 3, ObstacleSet(ball), 0.1)
    spline = found.curve
    assert not found.holds
    assert found.clearance.distance >= -1 - 1e-3
    assert np.isfinite(spline.control_points).all()


def test_repeated_vertices_work() -> None:
    obstacles = (Box(size=(2, 2, 2), position=(0, 0, 0)),)
    corners = np.array([[-2, -1.2, 0], [-1.2, 1.2, 0], [1.2, 1.2, 0], [2, -1.2, 0]])
    for degree in (2, 3, 4, 5):
        found = fit(np.repeat(corners, 3, axis=0), degree, ObstacleSet(obstacles), 0.1)
        spline = found.curve
        assert found.holds
        assert np.isfinite(spline(np.linspace(0, 1, 99), 1)).all()
        point = fit(np.repeat(corners[:1], 3, axis=0), degree, ObstacleSet(obstacles), 0.1)
        assert point.holds


def test_results_cannot_change() -> None:
    path = np.array([[-2, -1.2, 0], [-1.2, 1.2, 0], [1.2, 1.2, 0], [2, -1.2, 0]])
    found = fit(path, 3, ObstacleSet((Box(size=(2, 2, 2)),)), 0.19)
    spline = found.curve
    path[:] = 0
    assert spline.control_points.any()
    arrays = (spline.control_points, spline.knots, spline.breaks, spline.added, spline.pushed)
    assert not any(array.flags.writeable for array in arrays)
