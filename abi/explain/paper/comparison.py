"""A statement of the paper beside our figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["holds", "depends on the mesh", "does not hold"]


@dataclass(frozen=True)
class PaperComparison:
    """One statement of the paper beside what we find.

    Attributes:
        section: of the paper.
        subject: of the statement.
        printed: the paper's figure or claim.
        ours: the method's.
        verdict: whether the paper's statement holds. The paper does not print its mesh, so figures
            that depend on it can be compared only in order and size.
    """

    section: str
    subject: str
    printed: str
    ours: str
    verdict: Verdict
