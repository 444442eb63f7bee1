"""Table of closed forms of the inverse kinematics, for arms whose geometry has one.

A new one is a function in a file beside this one, from a chain and a point to joint positions, and
an entry here. Nothing else has to know it: it applies to every chain of its geometry, whoever has
drawn the robot, and what it gives counts only where the chain puts the tip at the point.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from abi.arrays import FloatArray
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.scara import scara_positions

ClosedForm = Callable[[Chain, FloatArray], list[FloatArray]]
"""All positions (n,) of a chain's coordinates, [rad] or [m], with the tip at a point (3,), [m],
world, limits aside; none for a chain of another geometry, or a point out of reach. A turning joint
may be any number of turns away."""

CLOSED_FORMS: tuple[ClosedForm, ...] = (scara_positions,)
"""The first that has an answer is asked."""

_TURN = 2 * np.pi


def closed_positions(chain: Chain, point: FloatArray) -> list[FloatArray]:
    """Positions of a chain by its closed form, within its limits; none where there is none.

    Args:
        chain: the chain.
        point: for its tip, (3,), [m], world.
    """
    answers = (form(chain, point) for form in CLOSED_FORMS)
    found = next((positions for positions in answers if positions), [])
    within = [_within_limits(chain, positions) for positions in found]
    return [positions for positions in within if positions is not None]


def _within_limits(chain: Chain, positions: FloatArray) -> FloatArray | None:
    """The positions with turning joints turned on to within their limits; None if one is beyond."""
    low, high = chain.limits.T
    turned = positions + np.ceil((low - positions) / _TURN) * _TURN
    # of several turns the one nearest to the middle of the limits
    turned += np.round(np.maximum((low + high) / 2 - turned, 0) / _TURN) * _TURN
    moved = np.where(chain.slides, positions, np.where(turned > high, turned - _TURN, turned))
    return moved if ((moved >= low) & (moved <= high)).all() else None
