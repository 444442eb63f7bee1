"""Settings of every stage, one class per section of a scene file."""

import functools
import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    Strict,
    model_validator,
)

from abi.errors import SceneError
from abi.length_text import with_minus
from abi.obstacles.pose import LARGEST, Vec3
from abi.scene.lattices import LATTICES, Lattice
from abi.scene.section import Settings

SAMPLES, MOST_SAMPLES = 401, 20_000
"""Samples of a motion, uniform in time, unless a scene asks for others, and at most."""

Algorithm = Literal["a_star", "dijkstra", "bellman_ford"]
Law = Literal["three_phase", "slowed", "time_optimal", "jerk_limited"]


def as_python(value: object) -> object:
    """Convert numpy's integers and booleans to Python's, as strict fields require."""
    return value.item() if isinstance(value, np.integer | np.bool_) else value


Count = Annotated[int, Strict(), BeforeValidator(as_python)]
Flag = Annotated[bool, Strict(), BeforeValidator(as_python)]
Number = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Rate = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=1e-6, le=1e6)]
Rates = tuple[Rate, Rate, Rate]
FINEST_PITCH = 1e-6
"""Smallest pitch, [unit]; also the shortest side that a workspace may have."""


_SLACK = 1e-3
"""Relative distance, over the workspace's longest side, see :attr:`Workspace.slack`."""


class Workspace(Settings):
    """The box that is meshed, axis-aligned; corners ``min`` and ``max`` in [unit], world."""

    min: Vec3 = (0.0, 0.0, 0.0)
    max: Vec3 = (6.0, 6.0, 6.0)

    @model_validator(mode="after")
    def _has_volume(self) -> Self:
        if any(high - low < 1e-6 for low, high in zip(self.min, self.max, strict=True)):
            raise SceneError("workspace.max", self.max, f"every number above min {self.min}")
        return self

    @property
    def size(self) -> Vec3:
        """Edge lengths, [unit]."""
        x, y, z = (high - low for low, high in zip(self.min, self.max, strict=True))
        return (x, y, z)

    def left_bounds(self, place: Vec3, unit: str) -> str:
        """Between what numbers it lies, in words, where a place is outside; empty inside."""
        for axis, number, low, high in zip("xyz", place, self.min, self.max, strict=True):
            if not low <= number <= high:
                return f"{axis} between {with_minus(f'{low:g} and {high:g}')} {unit}"
        return ""

    @property
    def slack(self) -> float:
        """Distance that mesh edges keep from the obstacles beyond the clearance, [unit].

        It leaves room for a smooth curve to round the corners of the path.
        """
        return _SLACK * max(self.size)


class MeshSettings(Settings):
    """Stage 1. ``pitch`` is the distance between neighbouring nodes, [unit]."""

    lattice: Lattice = "bcc"
    pitch: Annotated[Number, Field(ge=FINEST_PITCH)] = 1.2
    seed: Annotated[Count, Field(ge=0, le=2**32 - 1)] = 0
    max_nodes: Annotated[Count, Field(ge=8, le=20_000_000)] = 1_000_000

    def cells(self, workspace: Workspace) -> tuple[int, int, int]:
        """Cells along each axis, as nearly cubes as the box allows."""
        cube = self.pitch * LATTICES[self.lattice].cube
        x, y, z = (max(1, round(size / cube)) for size in workspace.size)
        return (x, y, z)

    def node_count(self, workspace: Workspace) -> int:
        """Number of mesh nodes that this pitch gives, without building the mesh."""
        x, y, z = self.cells(workspace)
        return (x + 1) * (y + 1) * (z + 1) + (x * y * z if LATTICES[self.lattice].centred else 0)

    def finest_pitch(self, workspace: Workspace) -> float:
        """Smallest pitch, to three digits, whose mesh has at most ``max_nodes`` nodes.

        If no mesh has, it is the largest pitch.
        """
        return _finest_pitch(self.lattice, self.max_nodes, workspace)


@functools.lru_cache(64)
def _finest_pitch(lattice: Lattice, max_nodes: int, workspace: Workspace) -> float:
    settings = MeshSettings(lattice=lattice)
    low, high = FINEST_PITCH, min(max(workspace.size) * 2, LARGEST)
    for _ in range(80):
        middle = math.sqrt(low * high)
        fits = settings.model_copy(update={"pitch": middle}).node_count(workspace) <= max_nodes
        low, high = (low, middle) if fits else (middle, high)
    digits = 2 - math.floor(math.log10(high))
    return float(math.ceil(high * 10**digits) / 10**digits)


class SearchSettings(Settings):
    """Stage 3. All algorithms run; later stages use the path of ``algorithm``.

    ``taut`` pulls that path taut before curves are fitted (stage 3½); the paper does not.
    """

    algorithm: Algorithm = "a_star"
    weight: Literal["length", "hops"] = "length"
    taut: Flag = True


class SplineSettings(Settings):
    """Stage 4. ``clearance`` is the distance to keep from every obstacle, [unit]."""

    degree: Annotated[Count, Field(ge=2, le=5)] = 4
    clearance: Annotated[Number, Field(ge=0)] = 0.2


class QuadraticSettings(Settings):
    """Stage 5, the curve: the least-squares quadratic, the nearest clear one, or clear pieces."""

    mode: Literal["least_squares", "clear", "pieces"] = "least_squares"


class MotionSettings(Settings):
    """Stage 5, the motion: cruise speed [unit/s], acceleration and deceleration [unit/s²].

    ``curve`` is the one that the tool follows; ``auto`` means the quadratic if it keeps the
    clearance, the B-spline otherwise. ``law`` is the paper's three phases, the same slowed down
    until the joints' limits hold, the fastest motion within these limits, or one of limited
    ``jerk`` [unit/s³]. ``joint_acceleration`` limits each planned joint, [rad/s²], sliding ones
    [m/s²], and not what follows it by a factor. The motion is sampled ``samples`` times, or every
    ``time_step`` [s]: it is then made so much longer that it ends with a step.
    """

    speed: Rate = 4.0
    acceleration: Rate = 6.0
    deceleration: Rate = 6.0
    curve: Literal["auto", "quadratic", "bspline"] = "auto"
    law: Law = "three_phase"
    joint_acceleration: Rate = 8.0
    jerk: Rate = 40.0
    samples: Annotated[Count, Field(ge=3, le=MOST_SAMPLES)] | None = None
    time_step: Annotated[Number, Field(ge=1e-5, le=1e6)] | None = None

    @model_validator(mode="after")
    def _samples_or_step(self) -> Self:
        if self.samples is not None and self.time_step is not None:
            raise SceneError("motion.time_step", self.time_step, "none beside motion.samples")
        return self
