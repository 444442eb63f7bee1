"""Text of lengths, the same everywhere."""

from __future__ import annotations

import math
from decimal import ROUND_FLOOR, Context

import numpy as np


def format_length(length: float) -> str:
    """Format a length with three decimals, fewer from 100 on, none from 1,000 on."""
    return with_minus(f"{length:,.{_decimals(length)}f}")


def format_lower_bound(distance: float) -> str:
    """Format a lower bound of a length, rounded down."""
    shift = 10.0 ** _decimals(distance)
    return format_length(math.floor(shift * distance + 1e-6) / shift)


def format_proven(distance: float, digits: int = 4) -> str:
    """Format a proven distance to some digits, rounded down so that the text is proven too."""
    rounded = Context(prec=digits, rounding=ROUND_FLOOR).create_decimal(repr(float(distance)))
    return f"{rounded.normalize():f}"


def format_setting(number: float, digits: int = 4) -> str:
    """Format a chosen number without trailing zeros."""
    if abs(number) >= 10_000:
        return with_minus(f"{number:,.0f}")
    # a zero has no sign
    text = np.format_float_positional(number + 0.0, precision=digits, fractional=False, trim="-")
    return with_minus(text)


def with_minus(number: str) -> str:
    """Replace the hyphen of a number by the minus sign U+2212, which is as wide as a plus."""
    return number.replace("-", "−")


def _decimals(length: float) -> int:
    if not abs(length) < 1000:
        return 0
    return 3 if abs(length) < 100 else 1
