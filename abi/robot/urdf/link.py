"""A link of a robot: its solids, its mass and how it looks; lengths in [m], masses in [kg]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from abi import arguments
from abi.arrays import ByteArray, FloatArray, IntArray, ShortRepr
from abi.errors import ArgumentError
from abi.obstacles.pose import Vec3

_SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "mesh": 0}
"""Kinds of solids, and how many of their sizes are lengths."""


@dataclass(frozen=True, eq=False, repr=False)
class LinkShape(ShortRepr):
    """A solid of a link.

    Attributes:
        kind: ``box``, ``sphere``, ``cylinder`` or ``mesh``.
        size: edges of a box; radius, 0, 0 of a sphere; radius, length, 0 of a cylinder about its z;
            scale of a mesh.
        pose: link from shape, shape (4, 4).
        vertices: of a mesh, scaled, shape (n, 3) in the shape's frame; empty otherwise.
        faces: of a mesh, shape (m, 3).
        colours: red, green and blue of each face, (m, 3), of all, (1, 3), or (0, 3) if not given.
    """

    kind: Literal["box", "sphere", "cylinder", "mesh"]
    size: Vec3
    pose: FloatArray
    vertices: FloatArray
    faces: IntArray
    colours: ByteArray

    def __post_init__(self) -> None:
        """Check the data that proofs are based on.

        Raises:
            ArgumentError: an array has another shape or type, or makes no sense.
        """
        if self.kind not in _SIZES:
            raise ArgumentError("kind", self.kind, f"one of {', '.join(_SIZES)}")
        size = arguments.numbers("size", self.size, (3,))
        if not (size[: _SIZES[self.kind]] > 0).all():
            raise ArgumentError("size", self.size, "lengths above 0")
        vertices = arguments.points("vertices", self.vertices)
        arguments.keep(
            self,
            pose=arguments.pose("pose", self.pose),
            vertices=vertices,
            faces=arguments.ids("faces", self.faces, (-1, 3), len(vertices)),
        )


@dataclass(frozen=True, eq=False, repr=False)
class Link(ShortRepr):
    """A link: a body of a robot.

    Attributes:
        name: of the link.
        shapes: collision shapes; none for a frame.
        visuals: what it is drawn with; none if it is drawn by its shapes.
        mass: [kg], 0 if the file gives none.
        centre: centre of mass in the link's frame, shape (3,).
        inertia: about that centre along the link's axes, shape (3, 3).
    """

    name: str
    shapes: tuple[LinkShape, ...]
    mass: float
    centre: FloatArray
    inertia: FloatArray
    visuals: tuple[LinkShape, ...] = ()

    def __post_init__(self) -> None:
        """Check the data that torques are computed from.

        Raises:
            ArgumentError: a number makes no sense, or an array has another shape.
        """
        arguments.number("mass", self.mass, 0.0)
        arguments.keep(
            self,
            centre=arguments.numbers("centre", self.centre, (3,)),
            inertia=arguments.numbers("inertia", self.inertia, (3, 3)),
        )

    @property
    def drawn(self) -> tuple[LinkShape, ...]:
        """Shapes with which it is drawn."""
        return self.visuals or self.shapes
