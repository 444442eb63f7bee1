"""Types of numbers, points and rotations in a scene, and the pose of an obstacle.

Lengths are in the scene's [unit].
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from abi.arrays import FloatArray, read_only

LARGEST = 1e6
METRES: Mapping[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Metres in one of each unit."""

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Length = Annotated[Number, Field(gt=0, le=LARGEST)]
Coordinate = Annotated[Number, Field(ge=-LARGEST, le=LARGEST)]
Vec3 = tuple[Coordinate, Coordinate, Coordinate]


def _normalised(
    wxyz: tuple[float, float, float, float],
) -> tuple[float, float, float, float]:
    largest = max(map(abs, wxyz))
    if largest == 0:
        raise ValueError("a rotation: four numbers, not all of them zero")
    w, x, y, z = (part / largest for part in wxyz)
    norm = math.hypot(w, x, y, z)
    # A unit quaternion stays as it is, to the last bit: a saved scene must load equal to itself.
    if abs(norm * largest - 1) <= 1e-14:
        return wxyz
    return w / norm, x / norm, y / norm, z / norm


Quaternion = Annotated[tuple[Number, Number, Number, Number], AfterValidator(_normalised)]

UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)


@lru_cache(maxsize=1024)
def rotation(wxyz: tuple[float, float, float, float]) -> FloatArray:
    """Rotation matrix (3, 3) of a quaternion: its columns are the body's axes in the world."""
    w, x, y, z = wxyz
    s = 2 / (w * w + x * x + y * y + z * z)
    return read_only(
        np.array(
            [
                [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
                [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
                [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
            ]
        )
    )


class Posed(BaseModel):
    """Pose in the world: an origin, [unit], and a rotation as a quaternion."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    position: Vec3 = (0.0, 0.0, 0.0)
    wxyz: Quaternion = (1.0, 0.0, 0.0, 0.0)
