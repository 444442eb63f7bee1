"""Colours of an arm's links, muted so that orange stands for obstacles and red for touching."""

from __future__ import annotations

import numpy as np

from abi.arrays import ByteArray, FloatArray

_WARM = (-45.0, 62.0)
"""Hues from and to which colours could be taken for an obstacle's or for red, [degrees]."""
_WARM_CHROMA, _CHROMA = 38.0, 110.0
"""Largest difference between the parts of such a colour, and of any other."""
_DARKEST, _LIGHTEST = 52.0, 236.0
"""Brightness that every colour is brought into, so that its shape shows on both grounds."""
_SECOND = 0.8
"""Brightness of every other link, so that one sees where they meet."""


def muted(colours: ByteArray, second: bool) -> ByteArray:
    """Colours (m, 3) as links are drawn with them.

    Args:
        colours: of the file, (m, 3).
        second: whether the link is every other one.
    """
    rgb = colours.astype(np.float64)
    grey = rgb @ (0.299, 0.587, 0.114)
    chroma = np.ptp(rgb, axis=1)
    low, high = _WARM
    warm = (_hue(rgb) - low) % 360 < high - low
    share = np.where(warm, _WARM_CHROMA, _CHROMA) / np.maximum(chroma, 1e-9)
    rgb = grey[:, None] + np.minimum(share, 1.0)[:, None] * (rgb - grey[:, None])
    rgb += (np.clip(grey, _DARKEST, _LIGHTEST) - grey)[:, None]
    return np.asarray(np.clip(np.rint(rgb * (_SECOND if second else 1.0)), 0, 255).astype(np.uint8))


def _hue(rgb: FloatArray) -> FloatArray:
    """Hue of colours (m, 3), (m,), [degrees]."""
    red, green, blue = rgb.T
    return np.asarray(np.degrees(np.arctan2(np.sqrt(3) * (green - blue), 2 * red - green - blue)))
