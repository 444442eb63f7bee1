"""Check of the directions that keep a part of an arm clear along its whole motion."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from abi.verify.exact import ExactSolid
from abi.verify.exact_mesh import ExactMesh, Side
from abi.verify.fault import Fault

Span = tuple[Fraction, Fraction]
"""First and last parameter of a motion."""


def check_above(sides: Sequence[Side], span: Span, floor: Fraction) -> None:
    """Check that sides, in order, show a part to stay above a height.

    Raises:
        Fault: they do not.
    """
    for start, _, (x, y, z), least in sides:
        if x or y or z <= 0 or least <= z * floor:
            raise Fault(f"the piece from {float(start):g} is not separated")
    check_cover(sides, span)


def check_apart(
    sides: Sequence[Side], span: Span, solid: ExactSolid | ExactMesh, margin: Fraction
) -> None:
    """Check that sides, in order, show a part to stay farther than ``margin`` from a solid.

    Raises:
        Fault: they do not.
    """
    if isinstance(solid, ExactMesh):
        if (at := solid.uncovered(sides, *span, margin)) is not None:
            raise Fault(f"nothing separates a triangle at {float(at):g}")
        return
    for start, _, normal, least in sides:
        if not solid.separated(normal, least, margin):
            raise Fault(f"the piece from {float(start):g} is not separated")
    check_cover(sides, span)


def check_cover(sides: Sequence[Side], span: Span) -> None:
    """Check that pieces, in order, cover the motion.

    Raises:
        Fault: they do not.
    """
    reached, last = span
    for start, end, _, _ in sides:
        if start > reached:
            break
        reached = max(reached, end)
    if reached < last:
        raise Fault(f"no piece covers the curve after {float(reached):g}")
