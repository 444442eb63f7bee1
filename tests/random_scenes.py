"""Random scenes for tests and benchmarks, each the same for the same number or generator."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import trimesh

from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.repair import clean
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.lattices import LATTICES
from abi.scene.scene import Scene
from abi_sweep.random_boxes import random_boxes

SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")


def random_scene(seed: int) -> Scene:
    """A scene from its number: workspace 6 × 6 × 6, obstacles of every shape in any pose.

    Every fourth scene may have triangle meshes: closed, inside out, or open.
    """
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 21))
    reach = 0.3 + 1.2 / np.sqrt(count)
    data: dict[str, Any] = {
        "version": 1,
        "start": random.uniform(0, 1, 3).tolist(),
        "goal": random.uniform(5, 6, 3).tolist(),
        "obstacles": _wall(random) * (seed % 5 == 1)
        + [_obstacle(random, reach, SHAPES[: 5 if seed % 4 == 0 else 4]) for _ in range(count)],
        "mesh": {
            "lattice": str(random.choice(list(LATTICES))),
            "pitch": float(random.uniform(0.45, 1.5)),
            "seed": seed,
        },
        "search": {"weight": str(random.choice(["length", "hops"]))},
        "spline": {
            "degree": int(random.integers(2, 6)),
            "clearance": float(random.choice([0.0, 0.02, 0.1, 0.2, 0.6])),
        },
        "quadratic": {"mode": str(random.choice(["least_squares", "clear", "pieces"]))},
    }
    if random.random() < 0.5:
        data["search"]["taut"] = False
    return Scene.from_dict(data, mesh_source())


def scattered(rng: np.random.Generator, most: int = 4) -> Scene:
    """One to ``most`` obstacles of all shapes between start and goal."""
    obstacles: list[dict[str, Any]] = []
    for _ in range(rng.integers(1, most + 1)):
        shape = str(rng.choice(["box", "sphere", "cylinder", "capsule"]))
        a, b, c = rng.uniform(0.6, 2.6, 3).tolist()
        sizes: dict[str, dict[str, Any]] = {
            "box": {"size": [a, b, c]},
            "sphere": {"radius": a / 2},
            "cylinder": {"radius": a / 2, "height": b},
            "capsule": {"radius": a / 3, "height": b},
        }
        pose = {"position": rng.uniform(1.2, 4.8, 3).tolist(), "wxyz": rng.normal(size=4).tolist()}
        obstacles.append({"shape": shape, **sizes[shape], **pose})
    return _diagonal_scene(rng, obstacles)


def slalom(rng: np.random.Generator) -> Scene:
    """Two to four walls across the workspace and far beyond, open on alternate sides."""
    count = int(rng.integers(2, 5))
    obstacles = []
    for k in range(count):
        end = float(rng.uniform(2.2, 4.2))
        y = end - 20 if k % 2 else end + 20
        x = 1.2 + 3.6 * (k + 0.5) / count + float(rng.uniform(-0.2, 0.2))
        obstacles.append({"shape": "box", "size": [0.2, 40, 40], "position": [x, y, 3]})
    return _diagonal_scene(rng, obstacles)


def box_scene(seed: int, pitch: float) -> Scene:
    """Eight boxes at random, as many as fit between the start's and the goal's corners."""
    return random_boxes(seed).replace(mesh={"lattice": "bcc", "pitch": pitch})


def crowd(count: int, seed: int, nodes: int, meshes: float = 0.0, fill: float = 0.12) -> Scene:
    """A scene of many small obstacles of all shapes, apart from start and goal.

    There is room for the tool alone: the arm does not avoid them.

    Args:
        count: number of obstacles.
        seed: of the generator.
        nodes: of the body-centred mesh, about.
        meshes: part of the obstacles that are triangle meshes.
        fill: part of the workspace that their bounding boxes would fill side by side.
    """
    random = np.random.default_rng([seed, count])
    side = (fill * 6**3 / count) ** (1 / 3)
    clearance = 0.02
    obstacles: list[dict[str, Any]] = []
    while len(obstacles) < count:
        sizes, place = side * random.uniform(0.6, 1.4, 3), random.uniform(0, 6, 3)
        room = float(np.linalg.norm(sizes)) / 2 + 4 * clearance + 0.05
        if min(np.linalg.norm(place), np.linalg.norm(place - 6)) < room:
            continue
        pose = {"position": place.tolist(), "wxyz": random.normal(size=4).tolist()}
        a, b, c = sizes.tolist()
        choices: list[dict[str, Any]] = [
            {"shape": "box", "size": [a, b, c]},
            {"shape": "sphere", "radius": 0.62 * a},
            {"shape": "cylinder", "radius": 0.5 * a, "height": b},
            {"shape": "capsule", "radius": 0.4 * a, "height": b},
        ]
        chosen = choices[random.integers(4)]
        if random.random() < meshes:
            chosen = {"shape": "mesh", "file": "ring.stl", "scale": a / 2}
        obstacles.append({**chosen, **pose})
    pitch = float((2 * 6**3 / nodes) ** (1 / 3) * np.sqrt(3) / 2)
    return Scene.from_dict(
        {
            "version": 1,
            "obstacles": obstacles,
            "mesh": {"lattice": "bcc", "pitch": pitch},
            "spline": {"clearance": clearance},
            "arm": {"avoid": False},
        },
        mesh_source(),
    )


def _wall(random: np.random.Generator) -> list[dict[str, Any]]:
    """Two boxes across the workspace with a slit between them, or none."""
    slit = float(random.choice([0.0, random.uniform(0.01, 1)]))
    middle = float(random.uniform(1.5, 4.5))
    return [
        {"shape": "box", "size": [0.2, 10, 8], "position": [3, middle + side * (slit / 2 + 5), 3]}
        for side in (-1, 1)
    ]


@functools.cache
def mesh_source() -> MeshSource:
    """A closed mesh that is not convex, the same inside out, and triangles that close nothing."""
    torus = trimesh.creation.torus(0.7, 0.3, major_sections=24, minor_sections=12)
    random = np.random.default_rng(0)
    soup = random.uniform(-0.7, 0.7, (20, 1, 3)) + random.uniform(-0.3, 0.3, (20, 3, 3))
    shapes = {
        "ring.stl": (torus.vertices, torus.faces),
        "inverted.stl": (torus.vertices, torus.faces[:, ::-1]),
        "soup.stl": (soup.reshape(-1, 3), np.arange(60).reshape(-1, 3)),
    }
    surfaces: dict[str, bytes | Surface] = {
        name: clean(np.asarray(vertices, float), np.asarray(faces, np.int32), name)
        for name, (vertices, faces) in shapes.items()
    }
    return MeshSource(surfaces)


def _obstacle(random: np.random.Generator, reach: float, shapes: tuple[str, ...]) -> dict[str, Any]:
    shape = str(random.choice(shapes))
    sizes = random.uniform(0.1, reach, 3)
    data: dict[str, Any] = {
        "shape": shape,
        "position": random.uniform(0.5, 5.5, 3).tolist(),
        "wxyz": random.normal(size=4).tolist(),
    }
    if shape == "box":
        data["size"] = (2 * sizes).tolist()
    elif shape == "mesh":
        data["file"] = str(random.choice(list(mesh_source().files)))
        data["scale"] = float(sizes[0])
    else:
        data["radius"] = float(sizes[0])
        if shape != "sphere":
            data["height"] = float(2 * sizes[1])
    return data


def _diagonal_scene(rng: np.random.Generator, obstacles: list[dict[str, Any]]) -> Scene:
    return Scene.from_dict(
        {
            "version": 1,
            "start": rng.uniform(0, [1, 6, 6]).tolist(),
            "goal": rng.uniform([5, 0, 0], 6).tolist(),
            "obstacles": obstacles,
            "mesh": {"pitch": 0.6},
            "spline": {"clearance": 0.1},
        }
    )
