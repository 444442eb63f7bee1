"""The compiled inner loops, one file a family. Each runs uncompiled too until it is ready."""

from __future__ import annotations

import threading

ready = threading.Event()
"""Set once all kernels are compiled."""


def warm() -> None:
    """Compile all kernels, or load what was compiled before: half a minute, or about a second."""
    # here, since numba takes long to import
    from abi.arm import arm_kernels as arm
    from abi.clearance import certify_mesh_kernels as certify_surface
    from abi.clearance import certify_primitives_kernels as certify_solids
    from abi.clearance import curve_clearance_kernels as curve_clearance
    from abi.curves import arc_length_kernels as arc_length
    from abi.curves import bspline_kernels as splines
    from abi.obstacles import obstacle_set_kernels as clearance
    from abi.obstacles.triangle_mesh import segment_kernels as triangles
    from abi.obstacles.triangle_mesh import winding_kernels as winding
    from abi.search import graph_kernels as sight
    from abi.search import search_kernels as search
    from abi.taut import geodesic_kernels as around
    from abi.taut import taut_kernels as pull
    from abi.taut import theta_star_kernels as any_angle
    from abi.tet_mesh import exclusion_kernels as mask

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
