"""Positions of a chain's joints with its tip at a point, with which a motion may begin."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from operator import itemgetter

import numpy as np

from abi.arrays import FloatArray, read_only
from abi.obstacles.pose import Vec3
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.closed_forms import closed_positions

REACHED = 1e-6
"""Error, over the arm's reach, up to which a point counts as reached."""
_STARTS, _HELD_STARTS = 48, 16
"""Numbers of random positions from which the tip is brought to the point."""
_ALIKE = 0.3
"""Joint distance below which two poses count as one, [rad] or [m]."""


@lru_cache(maxsize=16)
def first_poses(chain: Chain, point: Vec3) -> tuple[FloatArray, ...]:
    """Different positions (n,) with the tip at a point, those amid the limits first, [rad] or [m].

    They are those of the closed form, if the chain has one, or else those found from random
    positions; if none reaches the point, one that comes near it. Finding them takes a tenth of a
    plan, so the latest are kept.

    Args:
        chain: the chain.
        point: for its tip, [m], world.
    """
    random = np.random.default_rng(0)
    low, high = chain.usual_range().T
    target = np.array(point)[None]
    starts = [(low + high) / 2, *random.uniform(low, high, (_STARTS, len(low)))]
    for some in (closed_positions(chain, target[0]), starts):
        solved = [chain.follow(start, target) for start in some]
        found = [(positions[0], float(error[0])) for positions, error in solved]
        reached = [positions for positions, error in found if error <= REACHED]
        if reached:
            break
    else:
        return (read_only(min(found, key=itemgetter(1))[0]),)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-9)
    reached.sort(key=lambda positions: float(np.abs((positions - middle) / half).max()))
    return tuple(map(read_only, _different(reached)))


@lru_cache(maxsize=16)
def further_poses(chain: Chain, point: Vec3) -> tuple[FloatArray, ...]:
    """Positions as :func:`first_poses` gives, in which one joint is at a random position.

    A short slide otherwise ends at its limit nearly always. Where there are slides one of them is
    held, otherwise any joint.
    """
    random = np.random.default_rng(1)
    low, high = chain.usual_range().T
    target = np.array(point)[None]
    slides = np.flatnonzero(chain.slides)
    ones = slides if len(slides) else np.arange(len(low))
    reached = []
    for number, start in enumerate(random.uniform(low, high, (_HELD_STARTS, len(low)))):
        positions, error = chain.follow(start, target, still=int(ones[number % len(ones)]))
        if error[0] <= REACHED:
            reached.append(positions[0])
    return tuple(map(read_only, _different(reached)))


def _different(positions: Sequence[FloatArray]) -> list[FloatArray]:
    """Positions without near duplicates of earlier ones."""
    kept: list[FloatArray] = []
    for one in positions:
        if all(np.abs(one - other).max() > _ALIKE for other in kept):
            kept.append(one)
    return kept
