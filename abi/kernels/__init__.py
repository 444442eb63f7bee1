"""The compiled inner loops, one file a family. Each runs uncompiled too until it is ready."""

from __future__ import annotations

import threading

ready = threading.Event()
"""Set once all kernels are compiled."""


def warm() -> None:
    """Compile all kernels, or load what was compiled before: half a minute, or about a second."""
    # here, since numba takes long to import
    from abi.kernels import (
        any_angle,
        arc_length,
        arm,
        around,
        certify_solids,
        certify_surface,
        clearance,
        curve_clearance,
        mask,
        pull,
        search,
        sight,
        splines,
        triangles,
        winding,
    )

    in_order_of_use = (
        mask,
        sight,
        search,
        any_angle,
        pull,
        around,
        clearance,
        splines,
        curve_clearance,
        arc_length,
        certify_solids,
        certify_surface,
        arm,
        # for triangle meshes only
        triangles,
        winding,
    )
    for kernels in in_order_of_use:
        kernels.warm()
    ready.set()
