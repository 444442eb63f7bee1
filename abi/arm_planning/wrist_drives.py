"""Stage 6, the drives of q4, q5 and q6 under constant forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abi import arguments
from abi.arrays import FloatArray
from abi.scene.arm_settings import ArmSettings


def wrist_positions(drives: ArmSettings, time: ArrayLike) -> FloatArray:
    """Positions of q4, q5 and q6 under constant generalised forces from rest.

    The paper (end of stage 6) prints q = t²·Q / I with I4 = i4²m4 + i5²m5 + i6²m6,
    I5 = i5²m5 + i6²m6, I6 = i6²m6. Lagrange's equation I·q'' = Q has the solution t²·Q / (2·I),
    and what a sliding joint moves is the mass m5 + m6: these are the ``corrected`` functions.
    q5 starts at ``drives.q5``, as if its force pushed from there.

    Args:
        drives: the scene's settings of the arm: forces, masses, radii, ``dynamics`` and ``q5``.
        time: [s], shape (n,).

    Returns:
        Shape (n, 3): q4 [rad], q5 [unit], q6 [rad].
    """
    _, m5, m6 = drives.masses
    i4, i5, i6 = (mass * i**2 for mass, i in zip(drives.masses, drives.radii, strict=True))
    # I4, I5, I6: each drive moves its own link and those after it.
    effective = [i4 + i5 + i6, i5 + i6, i6]
    if drives.dynamics == "corrected":
        effective = [2 * effective[0], 2 * (m5 + m6), 2 * effective[2]]
    rates = np.array(
        [force / inertia for force, inertia in zip(drives.forces, effective, strict=True)]
    )
    positions = arguments.numbers("time", time, (-1,))[:, None] ** 2 * rates
    positions[:, 1] += drives.q5
    return np.asarray(positions)
