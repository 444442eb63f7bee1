"""A triangle mesh as an obstacle.

A closed mesh is a solid, with a negative distance inside. An open one is a surface that nothing may
cross, with a distance that is never negative. Neither need be convex.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import PrivateAttr, StringConstraints, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from abi import arguments
from abi.arrays import BoolArray, FloatArray, flat, read_only
from abi.errors import SceneError
from abi.obstacles.pose import LARGEST, METRES, Length, Posed, Quaternion, rotation
from abi.obstacles.triangle_mesh import surface_kernels as kernels
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.obstacles.triangle_mesh.signed_distance import placement, surface_tables
from abi.obstacles.triangle_mesh.surface import Surface
from abi.obstacles.triangle_mesh.surface_tables_kernels import (
    Placement,
    SurfaceTables,
    new_room,
)

TOO_LARGE = 20.0
TOO_SMALL = 1 / 500
"""Sizes of a mesh, over the workspace's longest side, that suggest another unit."""
_UNITS = {
    **{1.0: "metres", 0.01: "centimetres", 0.001: "millimetres", 1e-6: "micrometres"},
    **{0.0254: "inches", 0.3048: "feet"},
}


class MeshShape(Posed):
    """A triangle mesh from a file; ``file`` is relative to the scene's folder, with "/".

    Coordinates in the file count in ``unit``, times ``scale``; without ``unit`` in the unit that
    the file gives, or else in the scene's. They are not turned, whichever axis the file says points
    up. Two shapes are equal when their fields, the scene's unit and the content of their files are.

    Every distance rests on the signed distance being 1-Lipschitz: over a distance l it changes by
    no more than l. That holds for any shape, for the open ones too.
    """

    convex: ClassVar[bool] = False

    shape: Literal["mesh"] = "mesh"
    file: Annotated[str, StringConstraints(strict=True, min_length=1, max_length=200)]
    unit: Literal["m", "cm", "mm"] | None = None
    scale: Length = 1.0

    _surface: Surface | None = PrivateAttr(None)
    _factor: float = PrivateAttr(1.0)

    @model_validator(mode="after")
    def _load(self, info: ValidationInfo) -> Self:
        if self._surface is not None:  # a shape taken over from another scene
            return self
        source = (info.context or {}).get("meshes") or MeshSource()
        try:
            self._surface = source.surface(self.file)
        except SceneError as error:
            why = {"file": self.file, "expected": error.expected}
            raise PydanticCustomError("mesh_file", "{expected}", why) from None
        self._factor = self.scale
        return self

    @classmethod
    def of(cls, surface: Surface, file: str = "mesh.stl", **fields: Any) -> Self:
        """Make a shape with ``surface`` in place of the content of ``file``."""
        context = {"meshes": MeshSource({file: surface})}
        return cls.model_validate({"file": file, **fields}, context=context)

    def __hash__(self) -> int:
        fields = (self.file, self.unit, self.scale, self.position, self.wxyz)
        return hash((fields, self.surface, self._factor))

    @property
    def surface(self) -> Surface:
        """The cleaned surface, in the file's coordinates."""
        # not by its name, which pydantic looks up in microseconds
        assert self.__pydantic_private__ is not None
        surface: Surface = self.__pydantic_private__["_surface"]
        return surface

    @property
    def factor(self) -> float:
        """Scene's [unit] per unit of the file, ``scale`` included."""
        return self._factor

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on the file: what is left out, repaired or not flat, and its unit."""
        declared = self.surface.metres
        if declared is None:
            return self.surface.notes
        name = _UNITS.get(declared, f"units of {declared:g} m")
        unit = f"Its numbers count in {name}, the unit of the file."
        if self.unit and not math.isclose(METRES[self.unit], declared, rel_tol=1e-6):
            unit = f"The file counts in {name}; the scene says {self.unit}, and that is taken."
        return (unit, *self.surface.notes)

    @property
    def closed(self) -> bool:
        """Whether the mesh has an inside."""
        return self.surface.closed

    def in_unit(self, unit: str) -> Self:
        """The shape in a scene of this unit.

        Raises:
            SceneError: larger than 1e6 or smaller than 1e-6 [unit], or further than 1e6 [unit] from
                the world's origin; names the field of the shape.
        """
        factor = self.scale * file_factor(self.surface, self.unit, unit)
        if not 1e-6 <= factor * self.surface.extent <= LARGEST:
            raise SceneError("scale", self.scale, _size_limits(factor * self.surface.extent))
        placed = self
        if factor != self._factor:
            placed = self.model_copy()
            placed._factor = factor
        placed._refuse_far()
        return placed

    def prepare(self) -> None:
        """Build trees, grid and hull of the surface: once, about a second for 80,000 triangles.

        Otherwise the first query of a distance, or of the bounds, waits for it.
        """
        surface_tables(self.surface)
        self.bounds()

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corner, each (3,), of the tightest axis-parallel box, [unit], world."""
        return _bounds(self)

    def triangles(self) -> FloatArray:
        """Corners (m, 3, 3) of the triangles, [unit], world."""
        return _triangles(self)

    def signed_distance(self, points: FloatArray) -> FloatArray:
        """Distance (n,) of points (n, 3) to the surface, [unit]; negative inside a closed mesh.

        It is exact or too small, by no more than rounding, or by less than 1e-7 of the mesh's size
        if triangles have no width. Inside a shell that crosses itself, all triangles count.
        """
        points = arguments.points("points", points)
        distances = np.empty(len(points))
        self._measure(kernels.DISTANCES, points, points, distances)
        return distances

    def signed_distance_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distance (n,) of points (n, 3), [unit], and its gradient (n, 3), world.

        The gradient has length 1. If it is not unique, it belongs to one of the nearest points; on
        the surface it is the normal of a triangle there. As a mesh is not convex, it is no
        subgradient.
        """
        points = arguments.points("points", points)
        distances, gradients = np.empty(len(points)), np.empty(3 * len(points))
        self._measure(kernels.GRADIENTS, points, points, distances, gradients)
        return distances, gradients.reshape(-1, 3)

    def segment_distance(
        self, p: FloatArray, q: FloatArray, most: FloatArray | float = math.inf
    ) -> FloatArray:
        """Least signed distance (n,) along the segments from p (n, 3) to q (n, 3), [unit].

        If ``most``, one for all or one for each (n,), is less, it is returned instead.

        Exact up to rounding if a segment stays outside; p may equal q. Rounding is below 1e-8 of
        the mesh's size, and less unless triangles are thin. If a segment enters a closed mesh, the
        value is a lower bound, below the true one by at most 1/64 of the segment's length.
        """
        p = arguments.points("p", p)
        q = arguments.numbers("q", q, p.shape)
        distances = arguments.one_or_each("most", most, len(p), infinite=True).copy()
        self._measure(kernels.LEAST, p, q, distances)
        return distances

    def distance_bounds(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bound (n,) of the signed distance, [unit].

        They cost almost nothing, and differ by some hundredths of the mesh's size.
        """
        points = arguments.points("points", points)
        lower, upper = np.empty(len(points)), np.empty(len(points))
        self._measure(kernels.BOUNDS, points, points, lower, upper)
        return lower, upper

    def blocks(self, p: FloatArray, q: FloatArray, margins: FloatArray) -> BoolArray:
        """Mask (n,) of the segments from p (n, 3) to q (n, 3) nearer than ``margins`` (n,), [unit].

        A segment that touches the surface is blocked even if its margin is 0 or less.
        """
        p = arguments.points("p", p)
        q = arguments.numbers("q", q, p.shape)
        margins = arguments.numbers("margins", margins, p.shape[:1])
        blocked = margins.copy()
        self._measure(kernels.BLOCKED, p, q, blocked)
        return np.asarray(blocked == 1.0)

    def _measure(
        self,
        question: int,
        starts: FloatArray,
        ends: FloatArray,
        found: FloatArray,
        more: FloatArray | None = None,
    ) -> None:
        """Ask the kernel about segments, from ``starts`` (n, 3) to ``ends`` (n, 3)."""
        segments, room = (flat(starts), flat(ends)), new_room()
        more = np.empty(0) if more is None else more
        kernels.measure(*(*self.placed, question, segments, found, more, room))

    @property
    def placed(self) -> tuple[SurfaceTables, Placement]:
        """The mesh in the format of the kernels."""
        where = placement(self.surface, self.position, self.wxyz, self.factor)
        return surface_tables(self.surface), where

    def _refuse_far(self) -> None:
        """Raise a SceneError if the bounds exceed those allowed for any other obstacle."""
        low, high = self.bounds()
        size = float((high - low).max())
        if size > LARGEST:
            raise SceneError("scale", self.scale, f"{_size_limits(size)} as it is turned")
        reached = max(-low.min(), high.max())
        if reached <= LARGEST:
            return
        limit = f"in the scene it reaches {reached:g}, and ±{LARGEST:g} is the limit"
        # with its middle at the origin a mesh of this size is well within the limit
        centred = np.clip(np.array(self.position) - (low + high) / 2, -LARGEST, LARGEST)
        shift = centred - np.array(self.position)
        if max(-(low + shift).min(), (high + shift).max()) <= LARGEST:
            example = "({:g}, {:g}, {:g})".format(*centred.round(6) + 0.0)  # 0, not -0
            raise SceneError("position", self.position, f"one like {example}: {limit}")
        raise SceneError("file", self.file, f"a mesh nearer to 0, or in a smaller unit: {limit}")


@lru_cache(maxsize=256)
def _bounds(shape: MeshShape) -> tuple[FloatArray, FloatArray]:
    low, high = _turned_bounds(shape.surface, shape.wxyz, shape.factor)
    # rounding is monotonic: what is least before the shift is least after
    return read_only(low + np.array(shape.position)), read_only(high + np.array(shape.position))


@lru_cache(maxsize=256)
def _turned_bounds(
    surface: Surface, wxyz: Quaternion, factor: float
) -> tuple[FloatArray, FloatArray]:
    """Bounds of a shape with its file's origin at the world's: of the round ones a hull has many
    corners."""
    corners = surface.hull * factor @ rotation(wxyz).T
    return read_only(corners.min(axis=0)), read_only(corners.max(axis=0))


@lru_cache(maxsize=8)
def _triangles(shape: MeshShape) -> FloatArray:
    turned = shape.surface.vertices * shape.factor @ rotation(shape.wxyz).T
    return read_only((turned + np.array(shape.position))[shape.surface.faces])


def _size_limits(size: float) -> str:
    return f"a mesh between 0.000001 and {LARGEST:,.0f} large, it would be {size:,.6g}"


def file_factor(surface: Surface, unit: str | None, scene_unit: str) -> float:
    """Scene's [unit] that a number in a mesh file stands for, at scale 1.

    Args:
        surface: of the file.
        unit: that the scene gives for the file; None for the file's own, or else the scene's.
        scene_unit: of the scene.
    """
    metres = METRES[unit] if unit else surface.metres or METRES[scene_unit]
    return metres / METRES[scene_unit]


def suggest_unit(extent: float, workspace: Sequence[float], metres: float) -> str | None:
    """Likely unit of a mesh whose size does not fit the workspace.

    Args:
        extent: longest side of the mesh's bounding box, [unit].
        workspace: edge lengths of the workspace, [unit].
        metres: length that a number in the file stands for, [m].

    Returns:
        The unit that brings the mesh nearest to the workspace's size, where the mesh is over 20
        times as large or under 1/500 as large; None where it is not, or where no unit would help.
    """
    ratio = extent / max(workspace)
    if TOO_SMALL <= ratio <= TOO_LARGE:
        return None
    fitting = {
        other: abs(math.log(ratio * METRES[other] / metres))
        for other in METRES
        if TOO_SMALL <= ratio * METRES[other] / metres <= TOO_LARGE
    }
    return min(fitting, key=lambda other: fitting[other], default=None)
