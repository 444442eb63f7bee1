"""The hybrid ABI method: an optimal, smooth path for a robot's tool around obstacles.

:mod:`abi.planner` runs the six stages in order; :mod:`abi.scene` is their input:

1. :mod:`abi.tet_mesh`: tetrahedral mesh of the workspace, without the nodes in obstacles
2. :mod:`abi.search`: graph of the free mesh
3. :mod:`abi.search`: A*, Dijkstra and Bellman-Ford; :mod:`abi.search.taut` pulls their path taut
4. :mod:`abi.curves`: B-spline, kept clear of the obstacles
5. :mod:`abi.curves`: quadratic with exact ends, and a motion in three phases
6. :mod:`abi.arm_planning`: inverse kinematics of the arm, and its motion

They build on :mod:`abi.obstacles` (shapes and distances), :mod:`abi.curves.clearance` (clearance of
curves and its certificates) and :mod:`abi.robot` (URDF files). :mod:`abi.explain` says why there is
no plan and what would help, and compares our results with those printed in the paper,
:mod:`abi.verify` checks certificates in exact arithmetic, :mod:`abi.export` writes plans for other
programs, :mod:`abi.teach` checks what students have written, and :mod:`abi.certification` proves
motions that were planned elsewhere. :mod:`abi_sweep`, beside it, makes tables of many plans.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from abi import teach
    from abi.certification.certify import certify
    from abi.compiling import compile
    from abi.errors import AbiError, SceneError, StageError
    from abi.explain.find_base import find_base
    from abi.export.show import show
    from abi.planner.plan import Plan
    from abi.planner.planner import Planner, plan
    from abi.planner.task_plan import TaskPlan, plan_tasks
    from abi.scene.scene import Scene, load_scene, scene_names

__all__ = [
    "AbiError",
    "Plan",
    "Planner",
    "Scene",
    "SceneError",
    "StageError",
    "TaskPlan",
    "certify",
    "compile",
    "find_base",
    "load_scene",
    "plan",
    "plan_tasks",
    "scene_names",
    "show",
    "teach",
]

_MODULES = {
    "AbiError": "abi.errors",
    "Plan": "abi.planner.plan",
    "Planner": "abi.planner.planner",
    "Scene": "abi.scene.scene",
    "SceneError": "abi.errors",
    "StageError": "abi.errors",
    "TaskPlan": "abi.planner.task_plan",
    "certify": "abi.certification.certify",
    "compile": "abi.compiling",
    "find_base": "abi.explain.find_base",
    "load_scene": "abi.scene.scene",
    "plan": "abi.planner.planner",
    "plan_tasks": "abi.planner.task_plan",
    "scene_names": "abi.scene.scene",
    "show": "abi.export.show",
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first used.

    A program that needs only an error class, say, does not wait for the whole package.
    """
    if name == "teach":
        return import_module("abi.teach")
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(_MODULES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, whether imported or not."""
    return sorted({*globals(), *__all__})
