"""View: where a camera is, what it looks at, and which way is up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from abi.arrays import FloatArray

if TYPE_CHECKING:
    import viser

_FARTHEST = 1e8
"""Largest coordinate of a camera that is kept, [unit]: a hundred times that of a scene."""
_NEAREST = 1e-7
"""Least distance of its position and target, [unit]; about that between two numbers of that size,
so that neither is rounded to the other while a camera moves there."""
_LONGEST_UP = 1e6
"""Largest length of an upward direction; its inverse is the least."""


@dataclass(frozen=True)
class View:
    """Camera of a tab, rounded: position, target, [unit], and the upward direction, world."""

    position: tuple[float, ...]
    target: tuple[float, ...]
    up: tuple[float, ...]

    @classmethod
    def of(cls, numbers: object) -> View | None:
        """Parse nine numbers into a view; None if nothing can be seen from it."""
        try:
            position, target, up = np.asarray(numbers, dtype=float).reshape(3, 3)
        except (ValueError, TypeError, OverflowError):
            return None
        # not a number passes no comparison
        if not np.abs([position, target]).max() <= _FARTHEST:
            return None
        if not np.linalg.norm(position - target) >= _NEAREST:
            return None
        if not 1 / _LONGEST_UP <= math.hypot(*up) <= _LONGEST_UP:
            return None
        return cls(_rounded(position), _rounded(target), _rounded(up))

    @classmethod
    def of_camera(cls, camera: viser.CameraHandle) -> View | None:
        """Read the view of a page's camera; None if the page reports none."""
        return cls.of([camera.position, camera.look_at, camera.up_direction])

    def show(self, camera: viser.CameraHandle) -> None:
        """Move a camera to this view."""
        camera.up_direction = np.array(self.up)
        camera.position = np.array(self.position)
        camera.look_at = np.array(self.target)

    def to_list(self) -> list[float]:
        """The nine numbers."""
        return [*self.position, *self.target, *self.up]


def _rounded(vector: FloatArray) -> tuple[float, ...]:
    return tuple(float(f"{number:.6g}") for number in vector)
