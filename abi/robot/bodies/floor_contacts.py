"""Links that may touch the floor: those that stand on it, or that no motion brings nearer to it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from abi.arrays import FloatArray
from abi.robot.bodies.link_bodies import Body
from abi.robot.bodies.link_solids import link_solids as solids_of
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.chain_kernels import POSE

_UPRIGHT = 1e-6
"""Tilt of an axis that counts as none, [rad]: of a link of 20 m a fiftieth of a millimetre."""
_POSES = 64
SUNK = 2e-3
"""Depth below the floor that is told, [m]."""


def on_floor(chain: Chain, bodies: Iterable[Body], floor: float) -> tuple[str, ...]:
    """Names of the links that may touch the floor.

    Those that stand still may, and those that the first joint moves where it turns about an upright
    axis, or slides level, which changes no height. Where it does, those may that touch the floor
    wherever it takes them, as at the foot of an arm that stands beside a wall.

    Args:
        chain: the chain.
        bodies: of its links.
        floor: height of the floor, [m].
    """
    still: dict[str, None] = {}
    first: dict[str, list[Body]] = {}
    for body in bodies:
        if body.frame < 0:
            still[body.link] = None
        elif body.frame == 0:
            first.setdefault(body.link, []).append(body)
    if not first or _keeps_heights(chain):
        return (*still, *first)
    up = chain.poses(_turned(chain))[:, 0, 2]
    lowest = {link: _lowest(chain, link) for link in first}
    for link, of_link in first.items():
        if not chain.robot.links[link].shapes:  # lines stand for it
            heights = [(up[:, :3] @ one.points.T).min(axis=1) - one.rounding for one in of_link]
            lowest[link] = np.min(heights, axis=0) + up[:, 3]
    return (*still, *(link for link in first if (lowest[link] <= floor).all()))


def floor_notes(chain: Chain, links: Iterable[str], floor: float) -> list[str]:
    """Sentences on links that move and are below a floor that they may touch.

    Args:
        chain: the chain.
        links: names of those that may touch the floor.
        floor: its height, [m].
    """
    standing, notes = {*links}, []
    why = ", as it touches the floor in every pose"
    if _keeps_heights(chain):
        why = f": {chain.joints[0].name} brings it no nearer"
    for link in (name for name, number in chain.frames.items() if number == 0 and name in standing):
        lowest = float(_lowest(chain, link).min())
        if floor - lowest > SUNK:
            notes.append(
                f"{link} reaches {floor - lowest:.3g} m below the floor, which is not "
                f"compared{why}."
            )
    return notes


def _lowest(chain: Chain, link: str) -> FloatArray:
    """Heights (k,) of the lowest point of a link that the first joint takes to all positions."""
    turn, origin = chain.places[link][:3, :3], chain.places[link][:3, 3]
    solids = solids_of(chain.robot.links[link], 1.0)
    return np.array(
        [
            solids.lowest(frame[:, :3] @ turn, frame[:, :3] @ origin + frame[:, 3])
            for frame in chain.poses(_turned(chain))[:, 0]
        ]
    )


def _turned(chain: Chain) -> FloatArray:
    """Positions (k, n) of which the first joint takes all, the others near 0."""
    coordinate = int(chain.table.source[0])
    low, high = chain.usual_range().T
    positions = np.tile(np.clip(0.0, low, high), (_POSES, 1))
    positions[:, coordinate] = np.linspace(low[coordinate], high[coordinate], _POSES)
    return positions


def _keeps_heights(chain: Chain) -> bool:
    """Check whether the first joint changes the height of no point."""
    turn = chain.table.origins[: POSE - 3].reshape(3, 3)
    x, y, z = (turn @ chain.joints[0].axis).tolist()
    return bool(abs(z) <= _UPRIGHT if chain.table.slides[0] else np.hypot(x, y) <= _UPRIGHT)
