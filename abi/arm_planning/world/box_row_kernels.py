"""Boxes that contain a triangle mesh, as rows in the format of convex primitives."""

from __future__ import annotations

from abi.arrays import FloatArray
from abi.compiled import FLOATS, NEW_FLOATS, compiled
from abi.obstacles.primitive_kernels import BOUNDS, WIDTH, Axes, in_world
from abi.obstacles.vector_kernels import Vec3, add, vec3_at

_ROUNDING = 1e-12

_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@compiled(example=(FLOATS, FLOATS, FLOATS, _AXES, (0.0, 0.0, 0.0), 1.0, NEW_FLOATS), fallback=False)
def box_rows(
    middles: FloatArray,
    halves: FloatArray,
    axes: FloatArray,
    turned: Axes,
    position: Vec3,
    factor: float,
    rows: FloatArray,
) -> None:
    """Write the rows of boxes that are placed in the world, a little larger, for rounding.

    Args:
        middles: of the boxes, in the file's unit, flat (3 n,).
        halves: half sizes, flat (3 n,).
        axes: their axes as columns, flat (9 n,).
        turned: axes of the file in the world.
        position: its origin, [unit], world.
        factor: [unit] per unit of the file.
        rows: flat (n WIDTH,), 0 at first; written.
    """
    count = len(rows) // WIDTH
    largest, farthest = 0.0, 0.0
    for i in range(count):
        x, y, z = in_world(turned, vec3_at(middles, 3 * i))
        centre = add(position, (factor * x, factor * y, factor * z))
        for k in range(3):
            rows[WIDTH * i + k] = centre[k]
            farthest = max(farthest, abs(centre[k]))
            largest = max(largest, factor * halves[3 * i + k])
    pad = _ROUNDING * (largest + farthest)
    for i in range(count):
        row = WIDTH * i
        x = y = z = 0.0
        for k in range(3):
            j = 9 * i + k
            u, v, w = in_world(turned, (axes[j], axes[j + 3], axes[j + 6]))
            half = factor * halves[3 * i + k] + pad
            rows[row + 3 + 3 * k], rows[row + 4 + 3 * k], rows[row + 5 + 3 * k] = u, v, w
            rows[row + 12 + k] = half
            x, y, z = x + abs(u) * half, y + abs(v) * half, z + abs(w) * half
        for k in range(3):
            reach = x if k == 0 else y if k == 1 else z
            rows[row + BOUNDS + k] = rows[row + k] - reach
            rows[row + BOUNDS + 3 + k] = rows[row + k] + reach
