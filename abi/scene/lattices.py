"""Table of the lattices that a scene can name.

What they are made of is in :mod:`abi.tet_mesh`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from types import MappingProxyType
from typing import Literal

Lattice = Literal["bcc", "kuhn", "delaunay"]


@dataclass(frozen=True)
class LatticeKind:
    """A lattice as its settings and the page need it.

    Attributes:
        label: its name on the page.
        cube: edges of its cubes for each pitch, the distance between nearest neighbours.
        centred: whether there is a node in the centre of each cube, too.
        seeded: whether it is random, repeatably by a seed.
        memory: bytes that a plan takes for each node, with room to spare; those of a lattice that
            is random stand in tables.
    """

    label: str
    cube: float = 1.0
    centred: bool = False
    seeded: bool = False
    memory: int = 250


LATTICES: Mapping[Lattice, LatticeKind] = MappingProxyType(
    {
        # half a cube's diagonal between nearest neighbours
        "bcc": LatticeKind("BCC (14 neighbours)", cube=2 / sqrt(3), centred=True),
        "kuhn": LatticeKind("Kuhn (cube cut in 6)"),
        "delaunay": LatticeKind("Delaunay (irregular)", seeded=True, memory=4_000),
    }
)
