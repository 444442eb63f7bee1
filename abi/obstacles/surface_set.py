"""All triangle meshes of a scene as one set of arrays, for the kernels.

Numba compiles a kernel for a fixed number of arrays, so those of several surfaces are concatenated.
A surface that several meshes share is there once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray, read_only
from abi.compiled import FLOATS, IDS
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.per_shape import per_shape
from abi.obstacles.triangle_mesh.signed_distance import is_fine_quick, surface_tables
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.surface_kernels import NO_SURFACES, SurfaceSet


def surface_set(meshes: Sequence[MeshShape], bounds: FloatArray) -> SurfaceSet:
    """The meshes as one, given the rows of their bounding boxes."""
    if not meshes:
        return NO_SURFACES
    placed = _placed(meshes)
    surfaces = tuple(dict.fromkeys(surface for surface, _ in placed))
    number = {surface: k for k, surface in enumerate(surfaces)}
    whose = np.array([number[surface] for surface, _ in placed], dtype=np.int32)
    poses = read_only(np.concatenate([pose for _, pose in placed]))
    joined = _joined(surfaces, is_fine_quick())
    return joined._replace(whose=read_only(whose), poses=poses, bounds=bounds)


@per_shape
def _placed(mesh: MeshShape) -> tuple[Surface, FloatArray]:
    """Surface of a mesh, and its row of ``poses``."""
    origin, axes, factor = mesh.placed[1]
    return mesh.surface, np.array([*origin, *axes[0], *axes[1], *axes[2], factor])


_COUNTED = ((0, 6), (1, 1), (2, 9), (8, 1), (9, 1), (10, 9), (11, 1), (5, 1))
"""Arrays of a surface whose rows are counted in ``begins``, and their widths."""


@lru_cache(maxsize=2)
def _joined(surfaces: tuple[Surface, ...], fine: bool) -> SurfaceSet:
    """Join the tables of the surfaces, with fine grids or coarse ones, without poses yet."""
    all_tables = [surface_tables(surface, fine) for surface in surfaces]
    at = np.zeros(8, dtype=np.int64)
    begins, numbers, every = [], [], list[tuple[NDArray[Any], ...]]()
    for tree, far_field, grid, closed, extent, error in all_tables:
        begins.append([*at, *grid.counts, int(closed)])
        is_shared = far_field.corners is tree.corners
        own = (IDS[:0], FLOATS[:0]) if is_shared else (far_field.leaves, far_field.corners)
        arrays = (*tree[:4], *far_field[:4], grid.values, *own, far_field.layers)
        at += [len(arrays[k]) // width for k, width in _COUNTED]
        every.append(arrays)
        (low, high), slack = grid.box, grid.slack
        numbers.append([tree.size, *grid.low, grid.step, *low, *high, slack, extent, *error])
    begins.append([*at, 0, 0, 0, 0])
    joined = map(_one_after_another, zip(*every, strict=True))
    rows = (np.array(begins, dtype=np.int32).ravel(), np.array(numbers, dtype=float).ravel())
    return SurfaceSet._make((*joined, *map(read_only, rows), IDS[:0], FLOATS, FLOATS[:0]))


def _one_after_another(arrays: tuple[NDArray[Any], ...]) -> NDArray[Any]:
    return arrays[0] if len(arrays) == 1 else read_only(np.concatenate(arrays))
