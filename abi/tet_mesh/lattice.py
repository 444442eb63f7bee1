"""Table of the regular lattices, by the names that ``mesh.lattice`` takes."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from abi.tet_mesh.bcc import BCC_LATTICE
from abi.tet_mesh.kuhn import KUHN_LATTICE
from abi.tet_mesh.regular_lattice import RegularLattice

REGULAR: Mapping[str, RegularLattice] = MappingProxyType({"bcc": BCC_LATTICE, "kuhn": KUHN_LATTICE})
