"""Points that an arm hides from an eye during its motion: lines of sight that meet a capsule."""

from __future__ import annotations

import numpy as np

from abi.arrays import BoolArray, FloatArray

_SMALL = 1e-12


def hidden(
    eyes: FloatArray, points: FloatArray, ends: FloatArray, radii: FloatArray, near: float
) -> BoolArray:
    """Check which points an arm hides from which eyes in which of its poses.

    Args:
        eyes: (e, 3), [unit], world.
        points: (p, 3).
        ends: of the segments of the arm's capsules, (t, c, 2, 3).
        radii: of the capsules, (c,).
        near: length of the last part of each way that does not count: what is so near before a
            point, as the gripper on the curve, belongs to it.

    Returns:
        Shape (e, t, p).
    """
    ways = points - eyes[:, None]
    lengths = np.linalg.norm(ways, axis=-1, keepdims=True)
    ways = ways * np.maximum(1 - near / np.maximum(lengths, _SMALL), 0.0)
    found = np.zeros((len(eyes), len(ends), len(points)), bool)
    for (a, b), radius in zip(ends.transpose(1, 2, 0, 3), radii.tolist(), strict=True):
        away = _distances(
            eyes[:, None, None], ways[:, None], a[None, :, None], (b - a)[None, :, None]
        )
        found |= away < radius
    return found


def _distances(p: FloatArray, d: FloatArray, q: FloatArray, e: FloatArray) -> FloatArray:
    """Distances of segments from p to p + d to those from q to q + e, (..., 3) each.

    Where one of the two nearest points is an end of its segment the other is nearest to that end;
    clamping one, then the other, then the first again finds both (Ericson, Real-Time Collision
    Detection, 5.1.9).
    """
    r = p - q
    dd, ee, de = (d * d).sum(-1), (e * e).sum(-1), (d * e).sum(-1)
    dr, er = (d * r).sum(-1), (e * r).sum(-1)
    dd, ee = np.maximum(dd, _SMALL), np.maximum(ee, _SMALL)
    s = np.clip((de * er - dr * ee) / np.maximum(dd * ee - de * de, _SMALL), 0.0, 1.0)
    t = np.clip((de * s + er) / ee, 0.0, 1.0)
    s = np.clip((de * t - dr) / dd, 0.0, 1.0)
    between = r + s[..., None] * d - t[..., None] * e
    return np.asarray(np.linalg.norm(between, axis=-1))
