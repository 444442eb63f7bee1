"""A motion's joint positions in exact numbers: polynomials of time between waypoints."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from abi.errors import SceneError
from abi.verify.fault import Fault
from abi.verify.plan_fields import list_of, numbers_of

Row = list[Fraction]


ExactPath = Sequence[tuple[Row, ...]]
"""Bézier points of each piece, rows of n positions, [rad] or [unit]; piece k begins at k."""


def positions_at(path: ExactPath, at: Fraction) -> Row:
    """Positions at a parameter of a path."""
    piece = min(int(at), len(path) - 1)
    return _part(path[piece], Fraction(0), at - piece)[-1]


def rows_around(path: ExactPath, start: Fraction, end: Fraction) -> list[Row]:
    """Rows whose least and largest values bound all positions on a stretch of a path."""
    found: list[Row] = []
    first = min(int(start), len(path) - 1)
    for piece in range(first, max(first + 1, -int(-end // 1))):
        low, high = max(start - piece, Fraction(0)), min(end - piece, Fraction(1))
        found += _part(path[piece], low, high)
    return found


def exact_path(motion: dict[str, Any], scales: Sequence[int]) -> ExactPath:
    """Polynomials of a motion as written.

    Args:
        motion: ``times``, ``positions`` and, if known, ``velocities`` and ``accelerations``.
        scales: factors from [rad] or [m] to [rad] or [unit], (n,).

    Raises:
        SceneError: a field has the wrong form.
        Fault: it is no motion of so many joints.
    """
    times = [Fraction(one) for one in numbers_of("motion.times", motion.get("times"))]
    positions = _rows(motion, "positions", scales)
    if positions is None or len(positions) != len(times) or len(times) < 2:
        raise Fault("its motion has no waypoints")
    if any(after <= before for before, after in itertools.pairwise(times)):
        raise Fault("its times do not increase")
    rates = [_rows(motion, name, scales) for name in ("velocities", "accelerations")]
    if any(rows is not None and len(rows) != len(times) for rows in rates):
        raise Fault("its motion does not say how fast it is at each waypoint")
    if rates[0] is not None and motion.get("timed", True) is not True:
        raise Fault("its motion has velocities but no times")
    pieces: list[tuple[Row, ...]] = []
    for k, (before, after) in enumerate(itertools.pairwise(times)):
        span = after - before
        a, b = positions[k], positions[k + 1]
        if rates[0] is None:
            pieces.append((a, b))
            continue
        u, v = ([span * one for one in rates[0][j]] for j in (k, k + 1))
        if rates[1] is None:
            pieces.append((a, _sum(a, (u, 3, 1)), _sum(b, (v, -3, 1)), b))
            continue
        f, g = ([span * span * one for one in rates[1][j]] for j in (k, k + 1))
        inner = (
            _sum(a, (u, 5, 1)),
            _sum(_sum(a, (u, 5, 2)), (f, 20, 1)),
            _sum(_sum(b, (v, -5, 2)), (g, 20, 1)),
            _sum(b, (v, -5, 1)),
        )
        pieces.append((a, *inner, b))
    return pieces


def _sum(row: Row, added: tuple[Row, int, int]) -> Row:
    """A row divided by a number, plus another one times a number."""
    other, divisor, factor = added
    return [one + factor * two / divisor for one, two in zip(row, other, strict=True)]


def _rows(motion: dict[str, Any], name: str, scales: Sequence[int]) -> list[Row] | None:
    """Rows of a table of the motion, in [rad] or [unit]; None if it is not given."""
    value = motion.get(name)
    if value is None:
        return None
    rows = [numbers_of(f"motion.{name}", row) for row in list_of(f"motion.{name}", value)]
    if any(len(row) != len(scales) for row in rows):
        raise SceneError(f"motion.{name}", value, f"rows of {len(scales)} numbers")
    return [[Fraction(one) * scale for one, scale in zip(row, scales, strict=True)] for row in rows]


def _part(points: Sequence[Row], low: Fraction, high: Fraction) -> list[Row]:
    """Bézier points of the part of a polynomial between two fractions of its time."""
    rows = [list(row) for row in points]
    last = len(rows) - 1
    for level in range(1, last + 1 if high != 1 else 1):
        for i in range(last, level - 1, -1):
            rows[i] = _between(rows[i - 1], rows[i], high)
    inner = low / high if high else Fraction(0)
    if not inner:
        return rows
    for level in range(1, last + 1):
        for i in range(last + 1 - level):
            rows[i] = _between(rows[i], rows[i + 1], inner)
    return rows


def _between(first: Row, second: Row, share: Fraction) -> Row:
    return [a + share * (b - a) for a, b in zip(first, second, strict=True)]
