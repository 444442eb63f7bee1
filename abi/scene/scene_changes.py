"""Changes of a scene's fields, held against what the scene has: only what differs is checked again.

What a scene holds is checked already, and the checker takes it as it is. So a change is made of
the scene's own objects wherever these say the same.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping

from pydantic import BaseModel

from abi.obstacles.primitives import MeshShape


def changed_value(held: object, change: object) -> object:
    """The value of a field after a change; ``held`` itself where that says the same already.

    Args:
        held: what the scene has there: a section, a tuple of obstacles, numbers or text.
        change: plain data. A dict changes fields of a section; a list replaces all obstacles, and
            may have some of ``held`` in it as they are.
    """
    if isinstance(held, BaseModel) and isinstance(change, dict):
        return held if _says(change, held) else {**vars(held), **change}
    if isinstance(held, tuple) and isinstance(change, list | tuple):
        values = list(map(_kept, held, change))
        same = len(held) == len(change) and all(map(operator.is_, held, values))
        return held if same else [*values, *change[len(values) :]]
    return _kept(held, change)


def without_stale_meshes(obstacles: object, files: Mapping[str, object]) -> object:
    """The obstacles, with plain data for meshes whose file has another content in ``files``."""
    if not isinstance(obstacles, list | tuple):
        return obstacles
    stale = [isinstance(one, MeshShape) and _is_stale(one, files) for one in obstacles]
    if not any(stale):
        return obstacles
    return [one.model_dump() if old else one for one, old in zip(obstacles, stale, strict=True)]


def _is_stale(shape: MeshShape, files: Mapping[str, object]) -> bool:
    return files.get(shape.file, shape.surface) is not shape.surface


def _kept(held: object, given: object) -> object:
    """``held`` where ``given`` says the same; of an obstacle no field is left out."""
    if isinstance(held, BaseModel) and isinstance(given, dict):
        return held if len(given) == len(vars(held)) and _says(given, held) else given
    return held if _same(given, held) else given


def _says(given: dict[str, object], held: BaseModel) -> bool:
    """Whether all the fields given are what ``held`` has."""
    fields = vars(held)
    return all(name in fields and _same(value, fields[name]) for name, value in given.items())


def _same(given: object, held: object) -> bool:
    """Whether plain data say what a checked field holds; 1, 1.0 and True differ."""
    if given is held:
        return True
    if isinstance(held, tuple) and isinstance(given, list | tuple):
        return len(given) == len(held) and all(map(_same, given, held))
    return type(given) is type(held) and given == held
