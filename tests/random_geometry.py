"""Random curves and solids for tests and benchmarks."""

from __future__ import annotations

from typing import Any

import numpy as np

from abi.curves.bspline import BSpline, clamped
from abi.curves.quadratic import Quadratic
from abi.obstacles.obstacle_set import Obstacle, Obstacles
from abi.obstacles.primitives import Box, Capsule, Cylinder, Sphere

SIZE = 6.0
"""Edge of the cube that curves and solids are in, [unit]."""


def random_curve(random: np.random.Generator) -> BSpline | Quadratic:
    """A spline of degree 2 to 5 or a quadratic in a cube; some on a grid, some with repeats."""
    degree = int(random.integers(2, 6))
    points = random.uniform(0, SIZE, (int(random.integers(degree + 1, 13)), 3))
    kind = random.integers(6)
    if kind == 0:
        points = points.round()
    if kind == 1:
        points = points[np.sort(random.integers(0, len(points), len(points)))]
    if kind == 2:
        first, middle, last = points[:3]
        rows = np.stack([first, 2 * (middle - first), first - 2 * middle + last])
        return Quadratic.single(rows)
    return clamped(points, degree)


def random_obstacle(random: np.random.Generator) -> Obstacle:
    """A solid of any shape in any pose; some on a grid, some flat as a plate."""
    x, y, z = (random.uniform(0, SIZE, 3)).tolist()
    a, b, c = (10 ** random.uniform(-1.3, 0.1, 3)).tolist()
    turn = random.normal(size=4) if random.random() < 0.7 else np.array([1.0, 0, 0, 0])
    w, i, j, k = turn.tolist()
    if random.random() < 0.2:
        x, y, z, a, b = round(x), round(y), round(z), 1.0, 1.0
    pose = {"position": (float(x), float(y), float(z)), "wxyz": (w, i, j, k)}
    match random.integers(5):
        case 0:
            return Box(size=(a, b, c), **pose)
        case 1:
            return Box(size=(2 * a, 2 * b, 0.01), **pose)
        case 2:
            return Sphere(radius=a, **pose)
        case 3:
            return Cylinder(radius=a, height=b, **pose)
        case _:
            return Capsule(radius=a / 2, height=b, **pose)


def random_obstacles(
    random: np.random.Generator, count: int, side: float, widest: float
) -> Obstacles:
    """Solids of every shape in any pose, up to ``widest``, with centres in a cube at the origin."""
    made: list[Obstacle] = []
    for _ in range(count):
        pose: Any = {
            "position": tuple(random.uniform(0, side, 3).tolist()),
            "wxyz": tuple(random.normal(size=4).tolist()),
        }
        x, y, z = random.uniform(0.03, 1, 3).tolist()
        radius, height = widest * x / 3, widest * y / 3
        shapes = (
            Box(size=(widest * x, widest * y, widest * z), **pose),
            Sphere(radius=radius, **pose),
            Cylinder(radius=radius, height=height, **pose),
            Capsule(radius=radius, height=height, **pose),
        )
        made.append(shapes[random.integers(4)])
    return tuple(made)
