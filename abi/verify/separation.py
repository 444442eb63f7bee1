"""Check of the directions that keep a curve or a part of an arm clear along its whole motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from abi.verify.certificate import CertifiedPlane
from abi.verify.exact.mesh import ExactMesh, Side
from abi.verify.exact.solids import ExactFloor, ExactSolid
from abi.verify.fault import Fault

Span = tuple[Fraction, Fraction]
"""First and last parameter of a motion."""


def check_apart(
    label: str,
    planes: Sequence[CertifiedPlane],
    least: Callable[[CertifiedPlane], Fraction],
    span: Span,
    solid: ExactFloor | ExactSolid | ExactMesh | None,
    margin: Fraction | None = None,
) -> None:
    """Check that planes prove a part to stay farther than a margin from a solid.

    Args:
        label: what both are, for a fault.
        planes: in the order in which their pieces begin.
        least: lower bound of a plane's product with the part all along its piece.
        span: of the motion.
        solid: the solid; None if ``least`` raises where a plane does not separate.
        margin: distance to keep, [unit]; None for 0.

    Raises:
        Fault: they do not.
    """
    keep = Fraction(0) if margin is None else margin
    try:
        sides = [(one.start, one.end, one.normal, least(one)) for one in planes]
        if isinstance(solid, ExactMesh):
            if (at := solid.uncovered(sides, *span, keep)) is not None:
                raise Fault(f"nothing separates a triangle at {float(at):g}")
            return
        for start, _, normal, product in sides:
            if solid is not None and not solid.separated(normal, product, keep):
                raise Fault(f"the piece from {float(start):g} is not separated")
        _check_cover(sides, span)
    except Fault as fault:
        raise Fault(f"{label}: {fault}") from None


def _check_cover(sides: Sequence[Side], span: Span) -> None:
    """Raise unless the pieces, in order, cover the motion."""
    reached, last = span
    for start, end, _, _ in sides:
        if start > reached:
            break
        reached = max(reached, end)
    if reached < last:
        raise Fault(f"no piece covers the curve after {float(reached):g}")
