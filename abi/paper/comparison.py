"""One statement of the paper beside what we find."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["holds", "depends on the mesh", "does not hold"]


@dataclass(frozen=True)
class Comparison:
    """One statement of the paper beside what we find.

    Attributes:
        where: the part of the paper.
        what: the statement's subject.
        printed: what the paper says.
        ours: what the method gives.
        verdict: whether what is printed holds. The mesh is not printed: of figures that depend on
            it only order and size can be compared.
    """

    where: str
    what: str
    printed: str
    ours: str
    verdict: Verdict
