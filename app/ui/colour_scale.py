"""Interpolation of colours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abi.arrays import ByteArray, FloatArray
from app.ui.style import Colour


def scale_colours(stops: Sequence[Colour], shares: FloatArray) -> ByteArray:
    """Colours (n, 3) at fractions (n,) of a scale with equally spaced stops."""
    places = np.linspace(0, 1, len(stops))
    channels = zip(*stops, strict=True)
    return np.stack([np.interp(shares, places, one) for one in channels], axis=1).astype(np.uint8)
