"""Hidden scenes of exercises: the paper's, and random boxes, with their graphs."""

from __future__ import annotations

import contextlib
import functools
import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from abi.errors import StageError
from abi.obstacles.box import Box
from abi.obstacles.obstacle_set import ObstacleSet
from abi.scene.scene import Scene
from abi.search.build_graph import build_graph
from abi.search.graph import Graph
from abi.search.search import search
from abi.tet_mesh.exclusion import exclude
from abi.tet_mesh.tet_mesh import tetrahedralise

SCENES = 20
"""Number of hidden scenes of an exercise."""
_SIDE, _PITCH, _CLEARANCE = 6.0, 1.3, 0.2
_MOST_BOXES = 4


@functools.lru_cache(maxsize=8)
def hidden_scenes(seed: int) -> tuple[Scene, ...]:
    """The scenes of a seed, in each of which start and goal are joined.

    A box in the middle first, then one to four boxes at random.
    """
    random, found = np.random.default_rng(seed), list[Scene]()
    middle = [_box((2.0,) * 3, (3.0,) * 3)]
    for boxes in itertools.chain([middle], _random_boxes(random)):
        scene = _scene(boxes)
        with contextlib.suppress(StageError):
            graph_of(scene)
            found.append(scene)
        if len(found) == SCENES:
            break
    return tuple(found)


@functools.lru_cache(maxsize=8 * SCENES)
def graph_of(scene: Scene) -> Graph:
    """Graph of a scene.

    Raises:
        StageError: start and goal are not joined.
    """
    margin = scene.spline.clearance + scene.workspace.slack
    obstacles = ObstacleSet(scene.obstacles)
    free = exclude(tetrahedralise(scene.workspace, scene.mesh), obstacles, margin)
    ends = scene.start, scene.goal
    graph = build_graph(free, obstacles, margin, *ends, scene.spline.clearance)
    search("dijkstra", graph, "length")
    return graph


def boxes_of(scene: Scene) -> tuple[tuple[list[float], list[float]], ...]:
    """Lower and upper corners of a scene's obstacles, which are boxes."""
    found = []
    for box in scene.obstacles:
        assert isinstance(box, Box)
        centre, half = np.array(box.position), np.array(box.size) / 2
        found.append(((centre - half).tolist(), (centre + half).tolist()))
    return tuple(found)


def rows_of(graph: Graph) -> dict[str, Any]:
    """A graph as plain data."""
    return {
        "indptr": graph.indptr.tolist(),
        "indices": graph.indices.tolist(),
        "lengths": graph.lengths.tolist(),
        "points": graph.points.tolist(),
        "start": graph.start,
        "goal": graph.goal,
    }


def _random_boxes(random: np.random.Generator) -> Iterator[list[dict[str, Any]]]:
    """Endless sequence of random boxes, which may overlap but leave start and goal free."""
    while True:
        boxes = []
        for _ in range(int(random.integers(1, _MOST_BOXES + 1))):
            size = random.uniform(1.0, 2.6, 3).round(2)
            low = random.uniform(0.4, _SIDE - 0.4 - size).round(2)
            boxes.append(_box(size, low + size / 2))
        yield boxes


def _box(size: Any, position: Any) -> dict[str, Any]:
    return {"shape": "box", "size": list(map(float, size)), "position": list(map(float, position))}


def _scene(boxes: list[dict[str, Any]]) -> Scene:
    return Scene.from_dict(
        {
            "version": 1,
            "workspace": {"min": [0, 0, 0], "max": [_SIDE] * 3},
            "start": [0, 0, 0],
            "goal": [_SIDE] * 3,
            "obstacles": boxes,
            "mesh": {"pitch": _PITCH},
            "search": {"taut": False},
            "spline": {"clearance": _CLEARANCE},
            "arm": {"avoid": False},
        }
    )
