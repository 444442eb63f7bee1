"""Triangle meshes for tests: vertices (n, 3) and faces (m, 3), outward unless said otherwise."""

from __future__ import annotations

import struct

import numpy as np
import trimesh

from abi.arrays import FloatArray, IntArray

Mesh = tuple[FloatArray, IntArray]


def box(
    size: tuple[float, float, float] = (1, 1, 1), at: tuple[float, float, float] = (0, 0, 0)
) -> Mesh:
    return _mesh(trimesh.creation.box(extents=size).apply_translation(at))


def sphere(subdivisions: int = 3, radius: float = 1.0) -> Mesh:
    return _mesh(trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius))


def bumpy(subdivisions: int = 6, seed: int = 0) -> Mesh:
    """A closed, non-convex blob about 2.5 large; 81,920 faces at 6 subdivisions, 4 times less each.

    A sphere pushed in and out by smooth noise: it bulges and folds like a scanned figure, and as
    every ray from the origin meets it once it never crosses itself.
    """
    rng = np.random.default_rng(seed)
    vertices, faces = sphere(subdivisions)
    noise = np.zeros(len(vertices))
    for octave in range(1, 9):
        frequency = rng.normal(size=3) * octave * 1.3
        noise += np.sin(vertices @ frequency + rng.uniform(0, 2 * np.pi)) / octave / 2
    return vertices * (1 + 0.35 * np.tanh(noise))[:, None], faces


def soup(count: int, seed: int = 0, size: float = 0.5) -> Mesh:
    """Triangles at random in the cube from -1 to 1, which share no corner: many open surfaces."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1, 1, (count, 1, 3)) + rng.uniform(-size / 2, size / 2, (count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def knot(count: int, tube: float = 0.16) -> Mesh:
    """A closed tube along a trefoil, about 2.9 large, of about so many faces."""
    around = 8
    t = np.linspace(0, 2 * np.pi, max(24, count // (2 * around)), endpoint=False)
    reach = 1 + 0.45 * np.cos(3 * t)
    spine = np.stack([reach * np.cos(2 * t), reach * np.sin(2 * t), 0.45 * np.sin(3 * t)], axis=1)
    tangent = np.roll(spine, -1, axis=0) - np.roll(spine, 1, axis=0)
    out = np.stack([np.cos(2 * t), np.sin(2 * t), np.zeros_like(t)], axis=1)
    first = (
        out
        - tangent
        * (np.einsum("ij,ij->i", out, tangent) / np.einsum("ij,ij->i", tangent, tangent))[:, None]
    )
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(tangent, first)
    second /= np.linalg.norm(second, axis=1, keepdims=True)
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)[:, None]
    ring = np.cos(angle) * first[:, None] + np.sin(angle) * second[:, None]
    i, j = np.indices((len(t), around))
    k, m = (i + 1) % len(t), (j + 1) % around
    a, b, c, d = i * around + j, i * around + m, k * around + j, k * around + m
    faces = np.concatenate([np.stack([a, c, b], axis=-1), np.stack([b, c, d], axis=-1)])
    vertices = (spine[:, None] + tube * ring).reshape(-1, 3)
    return vertices, faces.reshape(-1, 3).astype(np.int32)


def room(walls: int = 3, seed: int = 0) -> Mesh:
    """A closed block 4 × 4 × 3 large with rooms in it, joined by doors; a wall is 0.15 thick.

    Rooms are cut by walls across x and across y, each with a door between two rooms.
    """
    rng = np.random.default_rng(seed)
    parts = []
    for axis in (0, 1):
        for place in np.linspace(-2, 2, walls + 2):
            middle = [0.0, 0.0, 0.0]
            middle[axis] = float(place)
            door = float(rng.uniform(-1.5, 1.5))
            for side in (-1, 1):
                end = 2.075
                size = [0.15, 0.15, 3.0]
                size[1 - axis] = end - side * door - 0.35
                middle[1 - axis] = side * (end - size[1 - axis] / 2)
                x, y, z = size
                parts.append(box((x, y, z), (middle[0], middle[1], middle[2])))
    return joined(*parts)


def joined(*parts: Mesh) -> Mesh:
    """Several meshes in one file, each with its own corners."""
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    return (
        np.concatenate([vertices for vertices, _ in parts]),
        np.concatenate([f + int(n) for (_, f), n in zip(parts, counts[:-1], strict=True)]),
    )


def inverted(mesh: Mesh) -> Mesh:
    vertices, faces = mesh
    return vertices, faces[:, ::-1].copy()


def stl(mesh: Mesh) -> bytes:
    """A binary STL file."""
    vertices, faces = mesh
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    table = np.zeros(len(faces), record)
    table["corners"] = vertices[faces]
    return b"test".ljust(80, b"\0") + struct.pack("<I", len(faces)) + table.tobytes()


def _mesh(mesh: trimesh.Trimesh) -> Mesh:
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int32)
