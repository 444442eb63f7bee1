"""Random mesh files, each read and compared with the surface that its writer knows.

    python -m benchmarks.mesh_files --files 2000

A file must be read into that surface, nothing of it missing, moved or inside out, and what it holds
besides must be noted; or it must be refused. The writers share nothing with the readers: they know
the surfaces from how their solids are made.
"""

from __future__ import annotations

import argparse
import json
import random
import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import trimesh

from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.mesh_files.parts import MeshFile
from abi.obstacles.triangle_mesh.mesh_reader import read_file
from benchmarks.written_3mf import threemf
from benchmarks.written_dae import dae
from benchmarks.written_glb import glb
from benchmarks.written_meshes import obj, off, ply, stl
from benchmarks.written_shapes import Chance, Written

WRITERS: Mapping[str, Callable[[Chance], Written]] = {
    **{"stl": stl, "obj": obj, "glb": glb, "ply": ply, "off": off},
    **{"3mf": threemf, "dae": dae},
}
_TOLERANCE = 1e-5
"""Of lengths, as parts of the surface's size: positions may be single precision."""
_SAMPLES = 200


def campaign(files: int, seed: int = 0) -> dict[str, dict[str, Any]]:
    """Write and read files of every format.

    Returns:
        By format: numbers of files ``read``, read with a ``noted`` rest, and ``refused``; and the
        ``faults``, each with the seed of its file.
    """
    found = {}
    for name, writer in WRITERS.items():
        begin, counts, faults = time.monotonic(), Counter[str](), list[str]()
        for number in range(seed, seed + files):
            written = writer(random.Random(f"{name} {number}"))
            try:
                counts[outcome(written)] += 1
            except AssertionError as error:
                faults.append(f"{number}: {error}")
        found[name] = {
            **{kind: counts[kind] for kind in ("read", "noted", "refused")},
            "faults": faults,
            "seconds": round(time.monotonic() - begin, 1),
        }
    return found


def outcome(written: Written) -> str:
    """Read a file: ``read``, ``noted`` if something of it is left out, or ``refused``.

    Raises:
        AssertionError: the surface is not the true one, or something is not said.
    """
    try:
        file = read_file(written.content, f"part{written.suffix}")
    except SceneError as error:
        if written.refused:
            return "refused"
        raise AssertionError(f"refused: {error.message}") from None
    assert not written.refused, "read, but it holds what cannot be read"
    assert file.metres == written.metres, f"its unit is {file.metres} m, not {written.metres} m"
    noted = any("left out" in note for note in file.notes)
    assert noted == written.left_out, f"notes: {file.notes}"
    _compare(file, written.surface)
    return "noted" if noted else "read"


def _compare(file: MeshFile, true: FloatArray) -> None:
    """Compare triangles (k, 3, 3) with those of a file: area, volume, and points of both.

    Lengths are parts of the surface's size.
    """
    size = float(np.ptp(true.reshape(-1, 3), axis=0).max())
    found = file.parts.vertices[file.parts.faces] * ((file.metres or 1.0) / size)
    true = true / size
    for name, measure in (("area", _area), ("volume", _volume)):
        difference = measure(found) - measure(true)
        assert abs(difference) <= 1e-4, f"its {name} is off by {difference:g}"
    missing = _distances(_points(true), found).max()
    assert missing <= _TOLERANCE, f"a point of it is missing, {missing:g} from what is read"
    added = _distances(_points(found), true).max()
    assert added <= _TOLERANCE, f"there is a point {added:g} off its surface"


def _area(triangles: FloatArray) -> float:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _volume(triangles: FloatArray) -> float:
    """Volume inside closed triangles that face outward, about the middle of their corners."""
    a, b, c = np.moveaxis(triangles - triangles.reshape(-1, 3).mean(axis=0), 1, 0)
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6)


def _points(triangles: FloatArray) -> FloatArray:
    """Points (n, 3) in triangles: of each its middle and one that is nearer to a corner."""
    weights = np.array([[1, 1, 1], [4, 1, 1]]) / [[3], [6]]
    points = np.einsum("wc,kci->kwi", weights, triangles).reshape(-1, 3)
    return np.asarray(points[:: 1 + len(points) // _SAMPLES])


def _distances(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distance (n,) of points to the nearest of triangles."""
    pairs = np.repeat(points, len(triangles), axis=0)
    all_triangles = np.tile(triangles, (len(points), 1, 1))
    nearest = trimesh.triangles.closest_point(all_triangles, pairs)  # type: ignore[no-untyped-call]
    away = np.linalg.norm(np.asarray(nearest) - pairs, axis=1)
    return np.asarray(away.reshape(len(points), -1).min(axis=1))


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=200, help="of each format")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print(json.dumps(campaign(options.files, options.seed), ensure_ascii=False), flush=True)


if __name__ == "__main__":
    main()
