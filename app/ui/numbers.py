"""Formatting of numbers on the page, the same everywhere."""

from __future__ import annotations

import math
import re

from abi.curves.clearance.curve_clearance import Clearance
from abi.length_text import format_length as format_length
from abi.length_text import format_lower_bound as format_lower_bound
from abi.length_text import format_setting as format_setting
from abi.length_text import with_minus as with_minus

_MILLION = 1_000_000
_UNIT = re.compile(r"(?<=\d) (?=(?:[cm]?m|[mµ]?s|%)(?![a-zA-Z])(?![^<>]*>))")
"""Space between a number and its unit, outside of tags."""


def format_excess(length: float, shortest: float, exact: bool) -> str:
    """Excess over the optimum, [%]; rounded up if the optimum is only a lower bound."""
    tenths = 1000 * max(length / shortest - 1, 0)
    return f"{(tenths if exact else math.ceil(tenths - 1e-6)) / 10:.1f} %"


def format_count(count: int) -> str:
    """Format a count in full, or in millions from one million on."""
    return f"{count:,}" if count < _MILLION else f"{count / _MILLION:.3g} M"


def format_time(ms: float) -> str:
    """Format a time given in [ms]: below 1 ms in [µs], from 1 s on in [s]."""
    if ms < 0.995:
        return f"{1000 * ms:.0f} µs" if ms < 0.0995 else f"{100 * ms:.0f}0 µs"
    return f"{ms:.0f} ms" if ms < 999.5 else f"{ms / 1000:.1f} s"


def unbroken(text: str) -> str:
    """HTML without line breaks between a number and its unit."""
    return _UNIT.sub("\N{NO-BREAK SPACE}", text)


def distance_to_show(clearance: Clearance) -> float:
    """Distance of a curve to the obstacles as shown on page and headings, [unit]."""
    return clearance.distance if clearance.certified else clearance.nearest
