"""The hybrid ABI method: an optimal, smooth path for a robot's tool around obstacles.

The stages, in order: :mod:`abi.mesh`, :mod:`abi.graph`, :mod:`abi.search`, :mod:`abi.bspline`,
:mod:`abi.quadratic` with :mod:`abi.timing`, and :mod:`abi.ik` with :mod:`abi.trajectory`;
:mod:`abi.plan` runs them.
"""

from abi.errors import AbiError, SceneError, StageError
from abi.plan import Plan, Planner, plan
from abi.scene import Scene, load_scene, scene_names

__all__ = [
    "AbiError",
    "Plan",
    "Planner",
    "Scene",
    "SceneError",
    "StageError",
    "load_scene",
    "plan",
    "scene_names",
]
