from __future__ import annotations

import importlib
import os
import pkgutil
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from numba.core.dispatcher import Dispatcher

import abi
from abi import kernels, load_scene, plan
from abi.kernels import warm


def all_kernels() -> Iterator[Dispatcher]:
    for entry in pkgutil.iter_modules(kernels.__path__, f"{kernels.__name__}."):
        module = importlib.import_module(entry.name)
        for value in vars(module).values():
            if isinstance(value, Dispatcher) and value.py_func.__module__ == module.__name__:
                yield value


def test_a_plan_compiles_nothing_that_is_not_warmed() -> None:
    warm()
    before = {kernel: set(kernel.signatures) for kernel in all_kernels()}
    assert len(before) > 25
    assert [kernel.py_func.__name__ for kernel, versions in before.items() if not versions] == []
    for name in ("paper", "forest", "sculpture", "thin-plate", "wall-with-window"):
        for mode in ("least_squares", "pieces"):
            assert plan(load_scene(name).replace(quadratic={"mode": mode})).motion
    assert {kernel: set(kernel.signatures) for kernel in all_kernels()} == before


DISTANCE = """
import numpy as np
from abi.obstacles.triangle_mesh import segment_kernels as triangles
triangles.warm()
distances = triangles.segment_distances
low, leaves, corners = np.zeros(3), np.array([0, 1], dtype=np.int32), np.zeros(9)
for array in (low, leaves, corners):
    array.setflags(write=False)
point, most = np.array([[2.0, 3.0, 6.0]]), np.full(1, np.inf)
(distance,) = distances(low, low, leaves, corners, point, point, np.zeros(1), most)
print(distance, *(sum(count.values()) for count in (distances.stats.cache_hits,
                                                    distances.stats.cache_misses)))
"""


def test_what_was_compiled_is_used_until_a_source_changes(tmp_path: Path) -> None:
    ours = shutil.copytree(
        Path(abi.__file__).parent, tmp_path / "abi", ignore=shutil.ignore_patterns("__pycache__")
    )
    cache = tmp_path / "cache"

    def run() -> list[float]:
        there = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(cache)}
        out = subprocess.run(
            [sys.executable, "-c", DISTANCE],
            env=os.environ | there,
            cwd=tmp_path,
            check=True,
            capture_output=True,
        )
        return [float(word) for word in out.stdout.split()]

    assert run() == [7, 0, 1]
    assert list(cache.rglob("*.nbi"))
    assert not list(ours.rglob("*.nbi"))

    # unchanged, if newer
    for source in ours.rglob("*.py"):
        os.utime(source, (1e9, 1e9))
    assert run() == [7, 1, 0]

    # in a file that the kernel takes a function from
    helper = ours / "kernels" / "vectors.py"
    product = "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]"
    before = helper.read_text()
    assert product in before
    helper.write_text(before.replace(product, f"4 * ({product})"))
    assert run() == [14, 0, 1]
