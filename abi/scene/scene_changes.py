"""Changes of a scene's fields that reuse the scene's own objects wherever values are equal.

A scene's own values have been checked, and pydantic accepts them as they are, so only values that
differ are checked again.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.robot_files import file_of
from abi.scene.arm_settings import ArmSettings


def changed_value(current: object, change: object) -> object:
    """The value of a field after a change; ``current`` itself if it is equal.

    Args:
        current: the scene's value: a section, a tuple of obstacles, numbers or text.
        change: plain data. A dict changes fields of a section; a list replaces all obstacles, and
            may contain objects of ``current``.
    """
    if isinstance(current, BaseModel) and isinstance(change, dict):
        return current if _fields_equal(change, current) else {**vars(current), **change}
    if isinstance(current, tuple) and isinstance(change, list | tuple):
        values = list(map(_reused, current, change))
        same = len(current) == len(change) and all(map(operator.is_, current, values))
        return current if same else [*values, *change[len(values) :]]
    return _reused(current, change)


def without_stale_meshes(obstacles: object, files: MeshSource) -> object:
    """The obstacles, with plain data for meshes whose file has new content in ``files``."""
    if not isinstance(obstacles, list | tuple) or not files.files:
        return obstacles
    names = {obstacle.file for obstacle in obstacles if isinstance(obstacle, MeshShape)}
    given = {name: files.given(name) for name in names}
    stale = [
        isinstance(obstacle, MeshShape) and _is_new(given[obstacle.file], obstacle)
        for obstacle in obstacles
    ]
    if not any(stale):
        return obstacles
    return [
        obstacle.model_dump() if is_stale else obstacle
        for obstacle, is_stale in zip(obstacles, stale, strict=True)
    ]


def without_stale_grasp(
    data: Mapping[str, Any], changes: Mapping[str, Any], tasks: Sequence[object]
) -> object:
    """The arm, which takes or sets down nothing more where the tasks that asked for it are gone.

    Args:
        data: a changed scene's fields.
        changes: those that were given.
        tasks: those of the scene that is changed.
    """
    arm, given = data["arm"], changes.get("arm")
    asked = isinstance(given, Mapping) and "grasping" in given
    if not tasks or data["tasks"] or asked:
        return arm
    nothing = {"grasping": False}
    return {**arm, **nothing} if isinstance(arm, dict) else changed_value(arm, nothing)


def without_stale_arm(arm: object, files: MeshSource, source: MeshSource) -> object:
    """The arm, as its fields where one of its files has new content in ``files``.

    Args:
        arm: the arm, or its fields.
        files: what is given anew.
        source: this, and the files that the scene has.
    """
    fields = vars(arm) if isinstance(arm, ArmSettings) else arm
    if not isinstance(fields, dict):
        return arm
    held = fields.get("attached")
    if isinstance(held, MeshShape) and _is_new(files.given(held.file), held):
        return {**fields, "attached": held.model_dump()}
    is_stale = isinstance(arm, ArmSettings) and arm.is_read_anew(files, source)
    return {**fields} if is_stale else arm


def with_files(before: MeshSource, files: MeshSource) -> MeshSource:
    """The files of a scene with others in place of those that they are given for."""
    kept = {
        name: file
        for name, file in before.files.items()
        if files.given(name) is None and files.given(file_of(name)) is None
    }
    return MeshSource({**kept, **files.files})


def _is_new(given: object, mesh: MeshShape) -> bool:
    """Check whether a file is given that is not the very surface of a mesh."""
    return given is not None and given is not mesh.surface


def _reused(current: object, change: object) -> object:
    """``current`` if ``change`` equals it, with all fields of an obstacle."""
    if isinstance(current, BaseModel) and isinstance(change, dict):
        equal = len(change) == len(vars(current)) and _fields_equal(change, current)
    else:
        equal = _equal(change, current)
    return current if equal else change


def _fields_equal(change: dict[str, object], current: BaseModel) -> bool:
    """Check whether all the fields in ``change`` equal those of ``current``."""
    fields = vars(current)
    return all(name in fields and _equal(value, fields[name]) for name, value in change.items())


def _equal(change: object, current: object) -> bool:
    """Check whether plain data equal a checked value; 1, 1.0 and True differ."""
    if change is current:
        return True
    if isinstance(current, tuple) and isinstance(change, list | tuple):
        return len(change) == len(current) and all(map(_equal, change, current))
    if isinstance(current, BaseModel) and isinstance(change, dict):
        return bool(change == current.model_dump(mode="json"))
    return type(change) is type(current) and change == current
