"""Processor time that each kernel takes to compile, in one process that finds none compiled.

    python -m benchmarks.compile

A ``*`` marks the kernels that the default scene calls.
"""

from __future__ import annotations

import os
import resource
import tempfile
import time


def measure() -> dict[str, float]:
    """Compile all kernels, those of the default scene first.

    Returns:
        Processor time of each kernel, [s], by name.
    """
    from abi import compiler_process, compiling

    spent: dict[str, float] = {}
    begin = time.process_time()
    for kernel in compiler_process.compile_each(sorted(compiling.all_kernels(), key=_is_unneeded)):
        spent[kernel.name] = time.process_time() - begin
        begin = time.process_time()
    return spent


def needed() -> set[str]:
    """Names of the kernels that a plan of the default scene calls."""
    from abi import Planner, compiling, load_scene

    Planner(compile=False)(load_scene("paper"))
    return {kernel.name for kernel in compiling.all_kernels() if kernel.need}


def _is_unneeded(kernel: object) -> bool:
    return not getattr(kernel, "need", 0.0)


def main() -> None:
    """Print the times, the longest first."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        first = needed()
        spent = measure()
    for name, seconds in sorted(spent.items(), key=lambda item: -item[1]):
        print(f"{seconds:7.2f} s {'*' if name in first else ' '} {name.removeprefix('abi.')}")
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{sum(spent.values()):7.2f} s, {len(spent)} kernels, {memory:.2f} GB")
    print(f"{sum(spent[name] for name in first):7.2f} s * of the default scene, {len(first)}")


if __name__ == "__main__":
    main()
