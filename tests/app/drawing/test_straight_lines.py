"""Straight lines draw exactly the edges that they replace, and none goes on another."""

from __future__ import annotations

import numpy as np
import pytest

from abi.arrays import FloatArray, IntArray
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.lattice import REGULAR
from abi.tet_mesh.tet_mesh import TetMesh, tetrahedralise
from app.drawing.straight_lines import straight_lines

_BOX = Workspace(min=(-1.0, 0.0, 2.0), max=(2.0, 2.2, 3.7))
_NODE = 20


def _mesh(lattice: str) -> TetMesh:
    return tetrahedralise(_BOX, MeshSettings(lattice=lattice, pitch=0.3))


def _lines(mesh: TetMesh, points: FloatArray, edges: IntArray) -> FloatArray:
    """Both ends of each line (m, 2, 3)."""
    assert mesh.stencil is not None
    ends, lines = straight_lines(points, edges, mesh.stencil)
    return ends[lines]


def _lengths(lines: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1))


def _is_drawn(lines: FloatArray, point: FloatArray) -> bool:
    starts, along = lines[:, 0], lines[:, 1] - lines[:, 0]
    part = ((point - starts) * along).sum(axis=1) / _lengths(lines) ** 2
    away = np.linalg.norm(starts + part[:, None] * along - point, axis=1)
    return bool(((away < 1e-6) & (part > 0) & (part < 1)).any())


@pytest.mark.parametrize("lattice", REGULAR)
@pytest.mark.parametrize("share", [0.02, 0.5, 0.9, 1.0])
def test_lines_draw_the_edges(lattice: str, share: float) -> None:
    mesh, random = _mesh(lattice), np.random.default_rng(int(100 * share))
    edges = mesh.edges[random.random(len(mesh.edges)) < share]
    flipped = random.random(len(edges)) < 0.5
    edges[flipped] = edges[flipped, ::-1]
    beside = len(mesh.points)
    edges = np.concatenate([edges, [(beside, node) for node in range(3)]])
    points = np.concatenate([mesh.points, mesh.points[:1] + 0.04])

    lines = _lines(mesh, points, edges)
    assert _lengths(lines).sum() == pytest.approx(_lengths(points[edges]).sum())
    some = edges[random.permutation(len(edges))[:300]]  # of all it takes as long as they are many
    assert all(_is_drawn(lines, middle) for middle in points[some].mean(axis=1))


@pytest.mark.parametrize("lattice", REGULAR)
def test_edges_to_a_point_that_is_on_a_node_are_drawn(lattice: str) -> None:
    mesh = _mesh(lattice)
    beside = mesh.edges[(mesh.edges == _NODE).any(axis=1)].sum(axis=1) - _NODE
    joined = [(len(mesh.points), node) for node in beside]
    edges = np.concatenate([mesh.edges, joined])
    points = np.concatenate([mesh.points, mesh.points[_NODE : _NODE + 1] + 1e-9])
    lines = _lines(mesh, points, edges)
    some = np.concatenate([edges[::10], joined])
    assert all(_is_drawn(lines, middle) for middle in points[some].mean(axis=1))


@pytest.mark.parametrize("lattice", REGULAR)
def test_lines_of_a_whole_lattice_go_from_side_to_side(lattice: str) -> None:
    mesh = _mesh(lattice)
    lines = _lines(mesh, mesh.points, mesh.edges)
    low, high = mesh.box
    # one through centres ends half a cell before the sides
    half = (high - low) / mesh.cells / 2
    assert ((lines < low + 1.1 * half) | (lines > high - 1.1 * half)).any(axis=2).all()
    assert len(lines) < 0.3 * len(mesh.edges)
