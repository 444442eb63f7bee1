"""The compiled inner loops, one file a family. Each runs uncompiled too until it is ready."""

from __future__ import annotations


def warm() -> None:
    """Compile all kernels, or load what was compiled before: seconds, or a few tenths of one."""
    # here, since numba takes long to import
    from abi.kernels import (
        arc_length,
        arm,
        certify,
        clearance,
        mask,
        pull,
        search,
        segments,
        splines,
    )

    for kernels in (
        mask,
        pull,
        search,
        segments,
        certify,
        clearance,
        splines,
        arc_length,
        arm,
    ):
        kernels.warm()
