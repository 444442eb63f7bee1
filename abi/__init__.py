"""The hybrid ABI method: an optimal, smooth path for a robot's tool around obstacles.

The six stages, in order; :mod:`abi.plan` runs them, :mod:`abi.scene` holds what each is told:

1. :mod:`abi.mesh`, on the points of :mod:`abi.lattice`
2. :mod:`abi.graph`
3. :mod:`abi.search`, and :mod:`abi.taut` pulls what it finds tight
4. :mod:`abi.bspline`
5. :mod:`abi.quadratic` or one of :mod:`abi.quadratic_modes`, and :mod:`abi.timing`
6. :mod:`abi.ik` and :mod:`abi.trajectory`, for the arm of :mod:`abi.arm`

Below them: :mod:`abi.shapes` and :mod:`abi.surfaces` are the obstacles, :mod:`abi.clearance` and
:mod:`abi.polyline` how far curves and paths are from them, :mod:`abi.proof` the proof of it,
:mod:`abi.shortest` the optimum, and :mod:`abi.kernels` the compiled inner loops.
:mod:`abi.reasons` says why there is no plan, :mod:`abi.paper` what the paper prints beside what we
find.
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
