"""Counters of references to arrays, and where they are in the values that kernels pass on."""

from __future__ import annotations

from typing import Any

from numba.core import types

COUNTER = types.MemInfoPointer(types.voidptr)  # type: ignore[no-untyped-call]
"""Numba's type of a counter."""


def places_of_counters(models: Any, kind: Any) -> list[tuple[tuple[int, ...], Any]]:
    """Return where values of a type have counters: indices from field to field, and the type there.

    Args:
        models: numba's data models.
        kind: the type.
    """
    if not models[kind].contains_nrt_meminfo():
        return []
    if isinstance(kind, types.Array):
        return [((models[kind].get_field_position("meminfo"),), COUNTER)]
    if not isinstance(kind, types.BaseTuple):
        return [((), kind)]  # left to numba
    return [
        ((k, *place), counted)
        for k, field in enumerate(kind.types)  # type: ignore[attr-defined]
        for place, counted in places_of_counters(models, field)
    ]
