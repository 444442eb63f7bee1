"""A task of a study: some settings of one scene, planned by whichever process takes it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from abi import compiling
from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.mesh_source import Files, MeshSource
from abi.planner.planner import Planner
from abi.scene.scene import Scene, load_scene
from abi_sweep.row import Row, plan_row, versions
from abi_sweep.study import Study, plan_key, varied

PLANS = 20
"""Largest number of plans of a task, which take some tenths of a second."""


@dataclass(frozen=True)
class SweepTask:
    """Settings of one scene, as plain data that any process can read.

    Attributes:
        scene: the scene before anything is varied.
        files: the files that it names.
        plans: key and settings of each plan.
    """

    scene: Mapping[str, Any]
    files: Files
    plans: tuple[tuple[str, Mapping[str, Any]], ...]


def tasks(study: Study, is_done: Callable[[str], bool]) -> tuple[list[Row], list[SweepTask]]:
    """First columns of all rows of a study, and tasks for the plans still to be made.

    Raises:
        AbiError: a scene cannot be read, or a setting does not fit it.
    """
    heads: list[Row] = []
    found: list[SweepTask] = []
    for name, seed in study.scenes:
        scene, waiting = study.scene(name, seed), []
        for settings in study.settings():
            try:
                key = plan_key(varied(scene, settings))
            except SceneError as error:
                raise AbiError(f"With the scene {name}, {error.message}") from None
            heads.append({"key": key, "scene": name, "seed": seed, **settings})
            if not is_done(key):
                waiting.append((key, settings))
        plain, files = scene.to_dict(), scene.meshes.files
        batches = [waiting[k : k + PLANS] for k in range(0, len(waiting), PLANS)]
        found += [SweepTask(plain, files, tuple(plans)) for plans in batches]
    return heads, found


def run(task: SweepTask) -> list[Row]:
    """Make the plans of a task: one row per plan.

    Each plan has a new planner without any memory, so neither results nor times depend on what the
    process did before.
    """
    _warm_up()
    scene = Scene.from_dict(task.scene, MeshSource(task.files))
    rows: list[Row] = []
    for key, settings in task.plans:
        try:
            found = plan_row(Planner(compile=False)(varied(scene, settings)))
        except Exception as error:  # one plan that fails does not end the study
            found = {"complete": False, "error": type(error).__name__}
        rows.append({"key": key, **found, **versions()})
    return rows


@functools.cache
def _warm_up() -> None:
    """Compile, and load what the first plans load."""
    compiling.compile()
    for lattice in ("bcc", "delaunay"):
        Planner(compile=False)(load_scene("paper").replace(mesh={"lattice": lattice}))
