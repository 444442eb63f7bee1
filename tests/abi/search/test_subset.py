from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from abi.arrays import FloatArray, IntArray
from abi.obstacles.obstacle_set import Obstacles
from abi.obstacles.primitives import Box, Sphere
from abi.planner.plan import Plan
from abi.planner.planner import plan
from abi.scene.lattices import LATTICES
from abi.scene.scene import load_scene
from abi.search.subset import VIEWS, edges_in_all, fits, subset
from tests.thorough import of_each_kind


@cache
def planned(pitch: float, lattice: str = "bcc", name: str = "paper") -> Plan:
    return plan(load_scene(name).replace(mesh={"pitch": pitch, "lattice": lattice}))


@cache
def whole(pitch: float) -> set[tuple[tuple[float, ...], ...]]:
    """Edges of the graph by their ends."""
    made = planned(pitch)
    assert made.graph is not None
    return by_ends(made.graph.points, made.graph.edges)


def by_ends(points: FloatArray, edges: IntArray) -> set[tuple[tuple[float, ...], ...]]:
    return {tuple(sorted(map(tuple, edge))) for edge in points[edges].tolist()}


def rows(points: np.ndarray) -> set[tuple[float, ...]]:
    return set(map(tuple, points.tolist()))


@pytest.mark.slow
@settings(max_examples=12)
@given(view=st.sampled_from(VIEWS), budget=st.integers(100, 60_000))
def test_what_is_shown_is_in_the_graph_and_keeps_the_budget(view: str, budget: int) -> None:
    made = planned(0.3)
    assert made.free is not None
    assert made.graph is not None
    assert made.path is not None
    shown, edges, excluded = subset(
        made.free, made.graph, made.scene.obstacles, made.path.points, view, budget
    )

    assert len(edges) <= budget
    assert edges_in_all(made.free, made.graph) == len(made.graph.edges)
    points = made.graph.points
    drawn = by_ends(shown, edges)
    assert drawn <= whole(0.3)
    assert len(drawn) == len(edges)
    gone = np.flatnonzero(made.free.excluded)
    assert rows(excluded) <= rows(points[gone])
    assert not rows(shown) & rows(points[gone])


@pytest.mark.parametrize("lattice", LATTICES)
def test_a_mesh_that_fits_is_shown_whole(lattice: str) -> None:
    made = planned(1.0, lattice)
    assert made.free is not None
    assert made.graph is not None
    assert fits(made.free, 30_000)
    _, edges, excluded = subset(
        made.free, made.graph, made.scene.obstacles, made.graph.points[:1], "near", 30_000
    )

    assert len(edges) == edges_in_all(made.free, made.graph) == made.graph.edge_count
    assert len(excluded) == made.free.excluded.sum()


def test_near_shows_the_path_and_leaves_out_what_is_farthest() -> None:
    made = planned(0.3)
    assert made.free is not None
    assert made.graph is not None
    assert made.path is not None
    assert not fits(made.free, 30_000)
    points, edges, _ = subset(
        made.free, made.graph, made.scene.obstacles, made.path.points, "near", 30_000
    )

    assert rows(made.path.points) <= rows(points)
    assert 10_000 < len(edges) < edges_in_all(made.free, made.graph)
    corner = np.array([0.0, 6.0, 6.0])
    assert np.linalg.norm(points - corner, axis=1).min() > 1


@pytest.mark.slow
@pytest.mark.parametrize("budget", of_each_kind([2_000, 10_000, 30_000], 2_000, 30_000))
@pytest.mark.parametrize(
    "obstacles",
    [
        (),
        (Box(size=(1.2, 0.6, 0.8), position=(4.8, 4.5, 5)),),
        (Sphere(radius=0.5, position=(1, 5, 1)), Box(size=(0.5, 2, 0.5), position=(5, 1, 5))),
    ],
    ids=len,
)
def test_near_shows_what_is_nearest_to_path_and_obstacles(
    obstacles: Obstacles, budget: int
) -> None:
    """Nothing shown is farther from both than what is left out, but for the size of a cell."""
    path = np.array([[0.5, 0.5, 0.5], [2.0, 1.0, 0.5]])
    made = plan(
        load_scene("paper").replace(
            obstacles=[obstacle.model_dump(mode="json") for obstacle in obstacles],
            mesh={"pitch": 0.3},
        )
    )
    assert made.free is not None
    assert made.graph is not None
    points, _, _ = subset(made.free, made.graph, obstacles, path, "near", budget)

    samples = path[0] + np.linspace(0, 1, 200)[:, None] * (path[1] - path[0])
    free = made.graph.points[: len(made.free.excluded)][~made.free.excluded]
    away = np.linalg.norm(free[:, None] - samples, axis=2).min(axis=1)
    for obstacle in obstacles:
        away = np.minimum(away, obstacle.signed_distance(free).clip(0))
    drawn = rows(points)
    shown = np.array([tuple(point) in drawn for point in free.tolist()])
    cell = 6 / 40 * np.sqrt(3)

    assert 0 < shown.sum() < len(free)
    assert away[shown].max() <= away[~shown].min() + 1.5 * cell


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_slice_is_thin_and_runs_through_the_obstacle(axis: int) -> None:
    made = planned(0.3)
    assert made.free is not None
    assert made.path is not None
    view = VIEWS[1 + axis]
    points, _, excluded = subset(
        made.free, made.graph, made.scene.obstacles, made.path.points, view, 30_000
    )

    assert np.ptp(points[:, axis]) < 1.0
    assert abs(points[:, axis].mean() - 3) < 0.3
    assert len(excluded) > 0
    assert np.delete(np.ptp(points, axis=0), axis) == pytest.approx([6, 6])


def test_without_a_graph_no_edge_has_an_excluded_end() -> None:
    made = planned(1.0)
    assert made.free is not None
    points, edges, _ = subset(
        made.free, None, made.scene.obstacles, np.zeros((1, 3)), "near", 30_000
    )

    kept = ~made.free.excluded
    assert len(points) == kept.sum()
    assert len(edges) == kept[made.free.mesh.edges].all(axis=1).sum()
