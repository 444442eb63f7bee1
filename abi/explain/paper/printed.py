"""The paper's numbers and formulas as printed, misprints included.

No plan depends on them; :mod:`abi.explain.paper.reproduction` compares them with the method's.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Literal

import numpy as np

from abi.arrays import FloatArray
from abi.curves.quadratic import Quadratic
from abi.robot.paper_arm.paper_arm import PaperArm

LENGTHS = MappingProxyType({"dijkstra": 13.695, "bellman_ford": 13.496, "a_star": 13.295})
"""Table I: length of the path by each algorithm, [cm]."""

VERTICES = 9
"""Table I: vertices of each path."""

BSPLINE_LENGTH = 11.98
"""Section III, stage 4: length of the spline of degree 4, [cm]."""

QUADRATIC_LENGTH = 11.358
"""Section III, stage 5: length of the quadratic, [cm]."""

QUADRATIC = Quadratic.single(
    np.array([[0.0, 0.0, 0.0], [12.397, 1.145, 7.892], [-6.397, 4.855, -1.892]])
)
"""Section III, stage 5: Px, Py and Pz, [cm]."""


def q1(tool: FloatArray) -> FloatArray:
    """Stage 6: q1 = ½·arccos((Py² − Px²) / (Px² + Py²)).

    Args:
        tool: positions (n, 3) from the arm's base, [unit].

    Returns:
        Shape (n,), [rad].
    """
    x, y, _ = tool.T
    return np.asarray(0.5 * np.arccos((y**2 - x**2) / (x**2 + y**2)))


def cos_q2(arm: PaperArm, tool: FloatArray, lead: Literal["printed", "corrected"]) -> FloatArray:
    """Stage 6: the cosine of q2, with both signs of the root in it.

    The printed first term, a3²·Pza, is a cube of lengths among fourth powers; solving for q2 again
    gives a3³·Pza. Pxy is taken as the root of Px² + Py², since it is squared wherever it is used.

    Args:
        arm: the arm, q5 = 0.
        tool: positions (n, 3) from the arm's base, [unit].
        lead: the first term to use.

    Returns:
        Shape (2, n).
    """
    x, y, z = tool.T
    a3, a6 = arm.a3, arm.a4 + arm.a5
    pza = z - arm.a1 - arm.a2
    pxy = np.hypot(x, y)
    squared = pxy**2 + pza**2  # distance from the shoulder
    inside = -(a3**2 * pxy**2) * (a3**4 + (squared - a6**2) ** 2 - 2 * a3**2 * (a6**2 + squared))
    root = np.sqrt(np.maximum(inside, 0.0))
    first = a3 ** (2 if lead == "printed" else 3) * pza
    sums = first + a3 * pza * (squared - a6**2) + np.stack([root, -root])
    return np.asarray(sums / (2 * a3**2 * squared))
