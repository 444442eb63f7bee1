from __future__ import annotations

import numpy as np
import pytest
import trimesh

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.bodies.bounding_capsules import BoundingCapsule, bounding_capsules
from abi.robot.urdf.robot import Link
from abi.robot.urdf.robot_files import SHIPPED, load_robot, robot_from_archive
from tests.abi.robot.robots import arm, packed


def lacks(capsules: tuple[BoundingCapsule, ...], points: FloatArray) -> float:
    """Largest distance by which the points stick out of all capsules."""
    away = np.full(len(points), np.inf)
    for low, high, radius in capsules:
        way = high - low
        share = np.clip((points - low) @ way / max(float(way @ way), 1e-300), 0, 1)
        away = np.minimum(
            away, np.linalg.norm(points - low - share[:, None] * way, axis=1) - radius
        )
    return float(away.max())


def surface(link: Link) -> FloatArray:
    """Points on a link's shapes, made by another way than ours."""
    parts = []
    for shape in link.shapes:
        radius, length, _ = shape.size
        if shape.kind == "mesh":
            solid = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
        elif shape.kind == "box":
            solid = trimesh.creation.box(shape.size)
        elif shape.kind == "sphere":
            solid = trimesh.creation.icosphere(4, radius)
        else:
            solid = trimesh.creation.cylinder(radius, length, sections=97)
        points = np.concatenate([solid.sample(2000, seed=1), solid.vertices])
        parts.append(points @ shape.pose[:3, :3].T + shape.pose[:3, 3])
    return np.concatenate(parts)


@pytest.mark.parametrize("name", SHIPPED)
def test_capsules_contain_the_links(name: str) -> None:
    for link in load_robot(name, MeshSource()).links.values():
        capsules = bounding_capsules(link)
        assert bool(capsules) == bool(link.shapes)
        if capsules:
            assert lacks(capsules, surface(link)) <= 0


@pytest.mark.parametrize(
    "shape",
    ['<sphere radius="0.2"/>', '<cylinder radius="0.1" length="0.5"/>', '<box size="1 0.1 0.2"/>'],
)
def test_capsules_contain_primitives_and_are_not_much_larger(shape: str) -> None:
    text = arm(
        ('<box size="0.1 0.1 0.3"/>', shape), ("<geometry>", "<origin rpy='1 2 3'/><geometry>")
    )
    link = robot_from_archive(packed({"a.urdf": text})).links["a"]
    capsules = bounding_capsules(link)
    size = {"s": 4 / 3 * np.pi * 0.2**3, "c": np.pi * 0.01 * 0.5, "b": 0.02}[shape[1]]

    assert lacks(capsules, surface(link)) <= 0
    assert sum(part.volume for part in capsules) < 2.5 * size
