"""Kernels that a scene's first plan waits for, or runs for long, in the order of their calls.

What a plan has not come to yet does not tell how urgent it is. So where much is to be compiled,
this says it beforehand, and the compiler is done with each about when the plan comes to it.
"""

from __future__ import annotations

from typing import Any

from abi.arm_planning.certificates.separate_chain_kernels import separate_chain
from abi.arm_planning.exclusion.node_configuration_kernels import (
    bound_configurations,
    spread,
    touching_configurations,
)
from abi.compiled import Kernel
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.surface_tables_kernels import grid_values
from abi.robot.kinematics.follow_path_kernels import follow_path
from abi.scene.scene import Scene

_NEAR_MESHES: tuple[Kernel[..., Any], ...] = (grid_values,)
_OF_URDF_ARMS: tuple[Kernel[..., Any], ...] = (
    spread,
    touching_configurations,
    follow_path,
    bound_configurations,
    separate_chain,
)


def kernels_foreseen(scene: Scene) -> tuple[Kernel[..., Any], ...]:
    """Return them for a scene; none where a first plan in plain Python is quick."""
    meshes = any(isinstance(shape, MeshShape) for shape in scene.obstacles)
    return (_NEAR_MESHES if meshes else ()) + (_OF_URDF_ARMS if scene.arm.model == "urdf" else ())
