"""Fields of a plan's JSON, checked one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeGuard

from abi.errors import SceneError
from abi.verify.exact.solids import Vec3, vector


def number_of(value: object) -> Fraction | None:
    """The exact number; None if it is not a number."""
    return Fraction(value) if _is_number(value) else None


def finite(field: str, value: object) -> float:
    """A number; anything else, or one far too large, is refused."""
    if not _is_number(value) or abs(value) > 10**15:
        raise SceneError(field, value, "a number up to 1e15")
    return float(value)


def _is_number(value: object) -> TypeGuard[int | float]:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < math.inf


def numbers_of(field: str, value: object) -> list[float]:
    """A list of numbers."""
    return [finite(field, number) for number in list_of(field, value)]


def vector_of(field: str, value: object) -> Vec3:
    """Three numbers, exactly."""
    numbers = numbers_of(field, value)
    if len(numbers) != 3:
        raise SceneError(field, value, "three numbers")
    return vector(numbers)


def list_of(field: str, value: object) -> Sequence[Any]:
    """A list."""
    if not isinstance(value, list | tuple):
        raise SceneError(field, value, "a list")
    return value


def mapping(field: str, value: object) -> dict[str, Any]:
    """A mapping."""
    if not isinstance(value, dict):
        raise SceneError(field, value, "a mapping")
    return value
