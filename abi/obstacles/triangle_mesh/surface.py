"""Surface of an obstacle: triangles that bound a solid, or an open sheet that nothing may cross."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy

from abi import arguments
from abi.arrays import FloatArray, IntArray, ShortRepr, read_only
from abi.errors import ArgumentError


@dataclass(frozen=True, eq=False, repr=False)
class Surface(ShortRepr):
    """Triangles in the coordinates of their file; compares and hashes by its content.

    Attributes:
        vertices: (n, 3), each used by a triangle.
        faces: (m, 3) ids of the corners; counter-clockwise seen from outside where closed.
        closed: whether it bounds a solid: a point is inside where any layer winds around it.
        notes: sentences about its repair, and on what of the file is left out.
        metres: length of the file's unit, [m]; None if it does not say.
        layers: numbers of the faces of each layer, which follow one another; () where it is one.
        given: vertices and faces before the repair, which gives these again; None where they are
            these. They do not count for equality.
    """

    vertices: FloatArray
    faces: IntArray
    closed: bool
    notes: tuple[str, ...] = ()
    metres: float | None = None
    layers: tuple[int, ...] = ()
    given: tuple[FloatArray, IntArray] | None = None
    digest: str = field(init=False)

    def __post_init__(self) -> None:
        vertices = arguments.points("vertices", self.vertices)
        faces = arguments.ids("faces", self.faces, (-1, 3), len(vertices))
        if self.layers and sum(self.layers) != len(faces):
            raise ArgumentError("layers", self.layers, f"numbers with the sum {len(faces)}")
        arguments.keep(self, vertices=vertices, faces=faces)
        content = hashlib.sha256(self.vertices.tobytes() + self.faces.tobytes())
        content.update(bytes([self.closed]))
        content.update(repr(self.layers).encode() if self.layers else b"")
        content.update(b"" if self.metres is None else repr(self.metres).encode())
        object.__setattr__(self, "digest", content.hexdigest())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Surface) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def of_file(self, metres: float | None, notes: tuple[str, ...]) -> Surface:
        """The surface with the unit of its file, [m], and with notes on the file before its own."""
        return replace(self, metres=metres, notes=(*notes, *self.notes))

    @cached_property
    def extent(self) -> float:
        """Longest side of the bounding box."""
        return float(np.ptp(self.vertices, axis=0).max())

    @cached_property
    def hull(self) -> FloatArray:
        """The vertices (k, 3) that are corners of the convex hull; all where it is flat."""
        try:
            return read_only(self.vertices[scipy.spatial.ConvexHull(self.vertices).vertices])
        except scipy.spatial.QhullError:
            return self.vertices
