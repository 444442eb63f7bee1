"""Translation of pydantic errors into scene errors: field, value, and what would work."""

from __future__ import annotations

import difflib
import itertools
import typing
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from abi.errors import MISSING, SceneError
from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.primitives import PRIMITIVES
from abi.scene.held_axis import AXIS_TAGS, HeldAxis

_SHAPES: dict[str, type[BaseModel]] = {**PRIMITIVES, "mesh": MeshShape}
_HELD = "attached"
_ANY_SHAPE = f"{', '.join(PRIMITIVES)} or mesh"

_EXPECTED = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "dict_type": "a mapping",
    "finite_number": "a finite number",
    "float_type": "a number",
    "int_type": "a whole number",
    "invalid_key": "names of fields as text",
    "list_type": "a list",
    "model_attributes_type": "a mapping",
    "model_type": "a mapping",
    "string_too_short": "a name",
    "string_type": "text",
    "tuple_type": "a list",
}
"""Expectations by pydantic's kind of error."""
_LIMITS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}
"""Name of the limit in the context of such a kind, and its wording."""
_TINY = 1e-3
"""Positive limits below this only exclude 0."""
_MISSING = {
    "version": "version: 1",
    "shape": f"shape: {_ANY_SHAPE}",
    "size": "three lengths, such as size: [1, 1, 1]",
    "radius": "a length, such as radius: 0.5",
    "height": "a length, such as height: 2",
    "file": "the name of a file of triangles, such as file: bracket.stl",
    "direction": "three numbers, such as direction: [0, 0, -1]",
}
"""Example values for fields without a default."""


def first_error(error: ValidationError, scene: type[BaseModel]) -> SceneError:
    """Scene error for the first of pydantic's errors.

    Args:
        error: raised when plain data were checked.
        scene: the model that they were checked against.
    """
    detail = error.errors(include_url=False)[0]
    # below a shape's field pydantic adds the name of the shape it chose, and so below an axis
    parts = ("", *detail["loc"])
    location = [
        b
        for a, b in itertools.pairwise(parts)
        if b not in AXIS_TAGS and not (_holds_shape(a) and b in _SHAPES)
    ]
    if detail["type"] == "mesh_file":
        location.append("file")
        detail["input"] = detail["ctx"]["file"]
    if detail["type"] in ("union_tag_invalid", "union_tag_not_found") and isinstance(
        detail["input"], dict
    ):
        location.append("shape")
        detail["input"] = detail["input"].get("shape", MISSING)
    field = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in location).lstrip(".")
    missing = detail["type"] == "missing"
    return SceneError(
        field or "scene",
        MISSING if missing else detail["input"],
        _expectation(detail, location, scene),
    )


def _expectation(detail: ErrorDetails, location: list[int | str], scene: type[BaseModel]) -> str:
    """End of the sentence "expected …"."""
    kind = detail["type"]
    if kind == "missing":
        return "a number" if isinstance(location[-1], int) else _MISSING[location[-1]]
    if location == ["version"]:
        return "1"
    if kind == "extra_forbidden":
        names = _fields_at(detail["loc"][:-1], scene)
        close = difflib.get_close_matches(str(location[-1]), names, 1)
        return f"one of the fields {', '.join(names)}" + (
            f" (did you mean {close[0]}?)" if close else ""
        )
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _ANY_SHAPE if location[-1] == "shape" else f"a mapping with shape: {_ANY_SHAPE}"
    if kind == "model_attributes_type" and location[-1] == _HELD:
        return f"a mapping with shape: {_ANY_SHAPE}"
    if kind in ("model_type", "model_attributes_type") and isinstance(location[-1], str):
        return f"the fields {', '.join(_fields_at(detail['loc'], scene))}"
    if kind in _EXPECTED:
        return _EXPECTED[kind]
    if kind == "string_too_long":
        return f"at most {detail['ctx']['max_length']} characters"
    if kind == "too_long":
        return f"a list of {detail['ctx']['max_length']}"
    if kind in _LIMITS:
        name, wording = _LIMITS[kind]
        limit = detail["ctx"][name]
        if (limit == 0 and name == "gt") or (name == "ge" and detail["input"] <= 0 < limit < _TINY):
            return "above 0"
        return f"{wording} {_format_limit(limit)}"
    message = detail["msg"]
    for prefix in ("Input should be ", "Value error, "):
        message = message.removeprefix(prefix)
    return message


def _holds_shape(part: int | str) -> bool:
    """Check whether part of a location is that of an obstacle or of the held object."""
    return isinstance(part, int) or part == _HELD


def _format_limit(limit: float) -> str:
    """Text of a limit, with commas in a large one and no exponent in a small one."""
    return f"{limit:,.10f}".rstrip("0").rstrip(".")


def _fields_at(location: tuple[int | str, ...], scene: type[BaseModel]) -> list[str]:
    """Names of the fields of the section at ``location``."""
    if "obstacles" in location or _HELD in location:
        return list(_SHAPES[str(location[-1])].model_fields)
    model: Any = scene
    for part in location:
        if isinstance(part, int):
            continue
        if part in AXIS_TAGS:
            model = HeldAxis
            continue
        annotation = model.model_fields[part].annotation
        model = next(filter(None, typing.get_args(annotation)), annotation)  # of a section or None
    return [field.alias or name for name, field in model.model_fields.items()]
