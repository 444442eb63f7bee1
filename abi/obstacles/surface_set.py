"""All triangle meshes of a scene as one set of arrays, for the kernels.

Numba compiles a kernel for a fixed number of arrays, so those of several surfaces are concatenated.
A surface that several meshes share is there once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from abi.arrays import FloatArray, IntArray, read_only
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, IDS
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.per_shape import PerShape
from abi.obstacles.triangle_mesh.bvh import Dipoles, TriangleTree
from abi.obstacles.triangle_mesh.distance_grid_kernels import DistanceGrid
from abi.obstacles.triangle_mesh.signed_distance import body_frame
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.surface_tables_kernels import Placement, SurfaceTables
from abi.obstacles.vector_kernels import vec3_at

_IDS, _NUMBERS, _POSE = 8, 15, 13


class SurfaceSet(NamedTuple):
    """All surfaces of a scene and their poses, as flat arrays.

    Attributes:
        boxes, leaves, corners, slabs: of the trees, see ``TriangleTree``.
        centres, radii, normals, areas: of their far fields, see ``Dipoles``.
        values: of the grids, see ``DistanceGrid``.
        begins: (s ``_IDS``,) of each surface where its nodes, leaves, triangles and values begin;
            the counts of its grid, and whether it is closed. One row more ends the last surface.
        numbers: (s ``_NUMBERS``,) the other fields of its tables, one after the other.
        whose: (m,) surface of each mesh.
        poses: (m ``_POSE``,) origin, axes and factor of its placement.
        bounds: (m ``WIDTH``,) the meshes' bounding boxes as rows of a tree, see
            ``primitive_tree_kernels``.
    """

    boxes: FloatArray
    leaves: IntArray
    corners: FloatArray
    slabs: FloatArray
    centres: FloatArray
    radii: FloatArray
    normals: FloatArray
    areas: FloatArray
    values: FloatArray
    begins: IntArray
    numbers: FloatArray
    whose: IntArray
    poses: FloatArray
    bounds: FloatArray


NO_SURFACES = SurfaceSet(*(FLOATS, IDS, *7 * (FLOATS,), IDS, FLOATS, IDS[:0], FLOATS, FLOATS[:0]))
"""The empty set: for scenes without meshes, and as an example to compile with."""


@jitable
def surface_at(surfaces: SurfaceSet, mesh: int) -> tuple[SurfaceTables, Placement]:
    """One mesh of the set, and its pose."""
    boxes, leaves, corners, slabs, centres, radii, normals, areas, values = surfaces[:9]
    begins, numbers, poses = surfaces.begins, surfaces.numbers, surfaces.poses
    k = _IDS * surfaces.whose[mesh]
    a, b, c, d = begins[k], begins[k + 1], begins[k + 2], begins[k + 3]
    e, f = begins[k + _IDS], begins[k + _IDS + 1]
    g, h = begins[k + _IDS + 2], begins[k + _IDS + 3]
    n = _NUMBERS * surfaces.whose[mesh]
    tree = TriangleTree(
        *(boxes[6 * a : 6 * e], leaves[b:f], corners[9 * c : 9 * g], slabs[5 * a : 5 * e]),
        numbers[n],
    )
    far_field = Dipoles(centres[3 * a : 3 * e], radii[a:e], normals[3 * a : 3 * e], areas[a:e])
    counts = (begins[k + 4] + 0, begins[k + 5] + 0, begins[k + 6] + 0)
    box = (vec3_at(numbers, n + 5), vec3_at(numbers, n + 8))
    grid = DistanceGrid(
        values[d:h], counts, vec3_at(numbers, n + 1), numbers[n + 4], box, numbers[n + 11]
    )
    error = (numbers[n + 13], numbers[n + 14])
    closed = begins[k + 7] == 1
    tables = SurfaceTables(tree, far_field, grid, closed, numbers[n + 12], error)
    p = _POSE * mesh
    axes = (vec3_at(poses, p + 3), vec3_at(poses, p + 6), vec3_at(poses, p + 9))
    return tables, Placement(vec3_at(poses, p), axes, poses[p + 12])


def surface_set(meshes: Sequence[MeshShape], bounds: FloatArray) -> SurfaceSet:
    """The meshes as one, given the rows of their bounding boxes."""
    if not meshes:
        return NO_SURFACES
    placed = _placed.of_all(meshes)
    surfaces = tuple(dict.fromkeys(surface for surface, _ in placed))
    number = {surface: k for k, surface in enumerate(surfaces)}
    whose = np.array([number[surface] for surface, _ in placed], dtype=np.int32)
    poses = read_only(np.concatenate([pose for _, pose in placed]))
    return _joined(surfaces)._replace(whose=read_only(whose), poses=poses, bounds=bounds)


@PerShape
def _placed(mesh: MeshShape) -> tuple[Surface, FloatArray]:
    """Surface of a mesh, and its row of ``poses``."""
    origin, axes, factor = mesh.placed[1]
    return mesh.surface, np.array([*origin, *axes[0], *axes[1], *axes[2], factor])


@lru_cache(maxsize=2)
def _joined(surfaces: tuple[Surface, ...]) -> SurfaceSet:
    """Tables of the surfaces, of no mesh yet."""
    all_tables = [body_frame(surface).tables for surface in surfaces]
    at = np.zeros(4, dtype=np.int64)
    begins, numbers = [], []
    for tree, far_field, grid, closed, extent, error in all_tables:
        begins.append([*at, *grid.counts, int(closed)])
        at += len(far_field.radii), len(tree.leaves), len(tree.corners) // 9, len(grid.values)
        (low, high), slack = grid.box, grid.slack
        numbers.append([tree.size, *grid.low, grid.step, *low, *high, slack, extent, *error])
    begins.append([*at, 0, 0, 0, 0])
    columns = zip(
        *((*tables.tree[:4], *tables.dipoles, tables.grid.values) for tables in all_tables),
        strict=True,
    )
    boxes, leaves, corners, slabs, centres, radii, normals, areas, values = map(
        _one_after_another, columns
    )
    return SurfaceSet(
        *(boxes, leaves, corners, slabs, centres, radii, normals, areas, values),
        read_only(np.array(begins, dtype=np.int32).ravel()),
        read_only(np.array(numbers, dtype=float).ravel()),
        *(IDS[:0], FLOATS, FLOATS[:0]),
    )


def _one_after_another(arrays: tuple[NDArray[Any], ...]) -> NDArray[Any]:
    return arrays[0] if len(arrays) == 1 else read_only(np.concatenate(arrays))
