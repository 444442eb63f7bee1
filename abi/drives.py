"""Stage 6, the drives: the joints that do not move the tool about, under constant forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abi.arrays import FloatArray
from abi.scene import ArmSettings


def driven(settings: ArmSettings, time: ArrayLike) -> FloatArray:
    """q4, q5 and q6 under constant generalised forces from rest.

    The paper (end of stage 6) prints q = t²·Q / I with I4 = i4²m4 + i5²m5 + i6²m6,
    I5 = i5²m5 + i6²m6, I6 = i6²m6. Lagrange's equation I·q'' = Q has the solution t²·Q / (2·I),
    and what a sliding joint moves is the mass m5 + m6: these are the ``corrected`` functions.
    q5 starts at ``settings.q5``, as if its force pushed from there.

    Args:
        settings: forces, masses > 0, radii > 0, ``dynamics`` and ``q5``.
        time: [s], shape (n,).

    Returns:
        Shape (n, 3): q4 [rad], q5 [unit], q6 [rad].
    """
    masses = np.array(settings.masses)
    # I4, I5, I6: each drive moves its own link and those after it.
    effective = np.cumsum((masses * np.array(settings.radii) ** 2)[::-1])[::-1]
    if settings.dynamics == "corrected":
        effective = 2 * np.array([effective[0], masses[1] + masses[2], effective[2]])
    accelerated = np.asarray(time, dtype=float)[:, None] ** 2 * np.array(settings.forces)
    return np.asarray(accelerated / effective + np.array([0.0, settings.q5, 0.0]))
