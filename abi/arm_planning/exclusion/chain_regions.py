"""Regions of tool positions of a URDF arm as surfaces: its shadow, and the set that it reaches.

Where it may stand at a place depends on where it comes from: here, as in the planner, it comes from
a pose at the start, from place to place of a coarse mesh.
"""

from __future__ import annotations

import numpy as np
import scipy

from abi.arm_planning.exclusion.node_configurations import NodeConfigurations, spread_over
from abi.arm_planning.exclusion.paper_arm_regions import box_above, grid, surface
from abi.arm_planning.exclusion.touching import touching
from abi.arm_planning.world.collision_world import CollisionWorld
from abi.arrays import BoolArray, FloatArray
from abi.obstacles.pose import Vec3
from abi.robot.urdf_arm import UrdfArm
from abi.scene.settings import MeshSettings, Workspace
from abi.tet_mesh.tet_mesh import tetrahedralise

_PLACES = 16
"""Grid points along the longest side of a box."""
_BLUR = 0.7
"""Standard deviation of the smoothing of the border, in cells."""
_LEAST = 0.05
"""Least smoothed value of a point next to the border, over the half that separates inside and
outside."""
_ANYHOW = -1.0
"""Distance between links, which may touch here."""


def configurations_in(
    arm: UrdfArm, first: FloatArray, start: FloatArray, box: tuple[Vec3, Vec3]
) -> NodeConfigurations:
    """Configurations at the nodes of a coarse mesh.

    Args:
        arm: the arm.
        first: its joints at the start, (n,), [rad] or [unit].
        start: the tool's place there, (3,), [unit], world.
        box: low and high corner, [unit].
    """
    low, high = box
    pitch = float(np.subtract(high, low).max()) / (_PLACES - 1)
    mesh = tetrahedralise(
        Workspace(min=low, max=high), MeshSettings(lattice="kuhn", pitch=pitch, max_nodes=10**6)
    )
    return spread_over(arm, mesh, start, first, first)


def reach_box(arm: UrdfArm, floor: float) -> tuple[Vec3, Vec3]:
    """Low and high corner of a box above the floor around all that an arm reaches, [unit]."""
    return box_above(floor, arm.chain.table.origins[9:12] / arm.metres, arm.reach)


def chain_shadow(
    arm: UrdfArm, configurations: NodeConfigurations, collision_world: CollisionWorld
) -> FloatArray:
    """The tool positions at which a link would be in an obstacle, to a cell of the mesh.

    Args:
        arm: the arm.
        configurations: its joints, as :func:`configurations_in` finds them.
        collision_world: the obstacles.

    Returns:
        Triangles (n, 3, 3) of the region's surface, [unit], world.
    """
    around = collision_world.only(collision_world.numbers >= 0).beyond(0.0)
    found = touching(arm, configurations.coordinates, around, _ANYHOW, configurations.reached)
    return _surface_of(configurations, found)


def chain_reach(configurations: NodeConfigurations) -> FloatArray:
    """The tool positions that an arm reaches within its joints' limits, to a cell of the mesh.

    Args:
        configurations: its joints, as :func:`configurations_in` finds them.

    Returns:
        Triangles (n, 3, 3) of the region's surface, [unit], world.
    """
    return _surface_of(configurations, configurations.reached)


def _surface_of(configurations: NodeConfigurations, chosen: BoolArray) -> FloatArray:
    """Surface between the chosen nodes (k,) of a mesh and the others, closed at the mesh's border.

    Smooth, but each place is on its own side.
    """
    low, high = (tuple(corner.tolist()) for corner in configurations.mesh.box)
    points, shape = grid(low, high, _PLACES)
    inner = chosen.reshape([count - 2 for count in shape])
    values = 0.5 - scipy.ndimage.gaussian_filter(inner.astype(float), _BLUR, mode="nearest")
    field = np.ones(shape)
    field[1:-1, 1:-1, 1:-1] = np.where(
        inner, np.minimum(values, -_LEAST), np.maximum(values, _LEAST)
    )
    return surface(points, field.ravel(), shape)
