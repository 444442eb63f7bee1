"""Hostile meshes, arms and scenes, given to the reader that the server has.

python -m benchmarks.fuzz --files 1000

The reader's process may open files here, unlike the server's, so that an attempt is seen.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import logging
import signal
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app.reading.reader import Reader
from app.reading.reading import ReadingRequest
from benchmarks.hostile_files import hostile
from benchmarks.outside import Outside

_ENDED = (signal.SIGXCPU, signal.SIGKILL)
"""Signals by which a process ends that takes too long."""
HANG = 5
"""Seconds of processor time in which a file must be dealt with."""


def fuzz(files: int, seed: int = 0) -> dict[str, Any]:
    """Read ``files`` hostile files.

    Returns:
        ``files`` by kind; ``taken`` and ``refused``; ``crashes`` of the reader, ``hangs`` over 5 s
        of processor time, ``outside`` files opened and servers called, ``faults``: errors that are
        no refusal, with the seeds of the files; ``slowest_ms``, and the seconds of all.
    """
    found, kinds, faults = Counter[str](), Counter[str](), list[str]()
    slowest, begin = 0.0, time.monotonic()
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.closing(Outside(Path(folder))) as outside,
        contextlib.closing(Reader(open_files=64, seconds=HANG)) as reader,
    ):
        names = (str(outside.file), outside.address)
        for number in range(seed, seed + files):
            job = hostile(number, names[number // 10 % 2])
            kinds[job.kind] += 1
            lost, start = len(reader.lost), time.monotonic()
            try:
                _take(reader, job)
                found["taken"] += 1
            except SceneError:
                found["refused"] += 1
            except Exception as error:  # what must not be, and is counted
                faults.append(f"{number}: {type(error).__name__}: {error}"[:300])
            slowest = max(slowest, time.monotonic() - start)
            for code in reader.lost[lost:]:
                found["hangs" if -code in _ENDED else "crashes"] += 1
                faults.append(f"{number}: ended with {code}")
            faults += [f"{number}: {fault}" for fault in reader.faults]
            reader.faults.clear()
            found["outside"] += outside.asked()
    return {
        "files": dict(kinds),
        **{name: found[name] for name in ("taken", "refused", "crashes", "hangs", "outside")},
        "faults": faults,
        "slowest_ms": round(1e3 * slowest),
        "seconds": round(time.monotonic() - begin, 1),
    }


def _take(reader: Reader, job: ReadingRequest) -> None:
    """Do what a tab does with an uploaded file, and look at what comes of it."""
    if job.kind == "mesh":
        _look_at({job.name: reader.mesh(job.content, job.name)})
    elif job.kind == "arm":
        robot = reader.arm(job.content, job.name)
        numbers = [number for one in robot.joints for number in (one.low, one.high, *one.axis)]
        assert np.isfinite(numbers).all(), "a joint has no finite limits"
    else:
        data, files = reader.scene(job.content, job.name)
        _look_at({name: one for name, one in files.items() if isinstance(one, Surface)})
        scene = Scene.from_dict(data, MeshSource(files))
        assert Scene.from_dict(scene.to_dict(), scene.meshes) == scene, "it does not come back"


def _look_at(surfaces: Mapping[str, Surface]) -> None:
    for surface in surfaces.values():
        assert np.isfinite(surface.vertices).all(), "a vertex is not finite"
        assert 0 <= surface.faces.min() <= surface.faces.max() < len(surface.vertices)


def main() -> None:
    """Read and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    logging.disable()
    warnings.simplefilter("ignore")
    print(json.dumps(fuzz(options.files, options.seed), ensure_ascii=False), flush=True)


if __name__ == "__main__":
    main()
