"""Links that need more pieces than usual: those that pass each other so closely that it shows.

If the bodies of two links overlap in many random poses, but no longer once they are a little
smaller, what they are larger than the links may decide. Their pieces then have to fit more closely,
and where that is not enough, as closely as they can.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from abi.robot.bodies import body_store, chain_capsules, sampled_bodies, telescopes
from abi.robot.bodies.chain_capsules import capsules_of, place
from abi.robot.bodies.link_bodies import Body, Fit
from abi.robot.bodies.sampled_bodies import near_pairs, overlapping_pairs, sampled_poses
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.robot import Robot

_POSES = 150
_SMALLER = 0.97
"""Size of the smaller bodies, over their own."""
_SHOWS = 0.06
"""Share of the poses in which two links overlap only because of that."""
_FITS: tuple[Fit, ...] = ("quick", "finer", "close")
"""Fits by their numbers in what is kept."""


def fitted_capsules(chain: Chain) -> tuple[Body, ...]:
    """Bodies of all links of a chain, in finer pieces where two links pass each other closely."""
    return capsules_of(chain, _finer_links(chain.robot, chain.names, tuple(chain.held.items())))


@lru_cache(maxsize=32)
def _finer_links(
    robot: Robot, names: tuple[str, ...], held: tuple[tuple[str, float], ...]
) -> Mapping[str, Fit]:
    """Fits of the links that need finer pieces; what is found is kept from one start to the next.

    Args:
        robot: the robot.
        names: of its joints that move by themselves.
        held: positions of all other joints that can move, [rad] or [m].
    """
    followers = {one.name for one in robot.joints if one.follows is not None}
    still = {name: at for name, at in held if name not in followers}
    chain = Chain.moved_by(robot, names, held=still)
    links = [*chain.frames]
    shapes = [shape for link in links for shape in robot.links[link].shapes]
    code = (__file__, chain_capsules.__file__, sampled_bodies.__file__, telescopes.__file__)
    motion = [(one.name, one.origin.tolist(), one.axis.tolist()) for one in robot.joints]
    text = repr((body_store.key_of(shapes, code), motion, chain.limits.tolist(), names, still))
    key = hashlib.sha256(text.encode()).hexdigest()
    kept = body_store.find(key)
    if kept is None:
        found: dict[str, Fit] = dict.fromkeys(_close_links(chain, {}), "finer")
        if found:
            found |= {link: "close" for link in _close_links(chain, found) if link in found}
        kept = [np.array([float(_FITS.index(found.get(link, "quick"))) for link in links])]
        body_store.keep(key, kept)
    fits = {link: _FITS[int(number)] for link, number in zip(links, kept[0], strict=True)}
    return {link: fit for link, fit in fits.items() if fit != "quick"}


def _close_links(chain: Chain, fits: Mapping[str, Fit]) -> frozenset[str]:
    """Links whose bodies overlap those of others only where they are larger than needed."""
    capsules = capsules_of(chain, fits)
    of_link: dict[str, list[int]] = {}
    for number, capsule in enumerate(capsules):
        of_link.setdefault(capsule.link, []).append(number)
    close: set[str] = set()
    poses, smaller = sampled_poses(chain, _POSES), [_smaller(one) for one in capsules]
    ends = place(capsules, chain.unpacked(poses))
    for first, second in itertools.combinations(of_link, 2):
        between = {*chain.behind(capsules[of_link[first][0]].frame)}
        between ^= {*chain.behind(capsules[of_link[second][0]].frame)}
        if len(between) <= 1:
            continue
        pairs = [*itertools.product(of_link[first], of_link[second])]
        near = near_pairs(capsules, ends, pairs)
        if near.any(axis=1).mean() < _SHOWS:
            continue
        overlap = overlapping_pairs(chain, capsules, poses, pairs, near)
        if overlap.any(axis=1).mean() < _SHOWS:
            continue
        still = overlapping_pairs(chain, smaller, poses, pairs, overlap)
        if (overlap.any(axis=1) & ~still.any(axis=1)).mean() >= _SHOWS:
            close |= {first, second}
    return frozenset(close)


def _smaller(capsule: Body) -> Body:
    middle = capsule.points.mean(axis=0)
    points = middle + _SMALLER * (capsule.points - middle)
    return capsule._replace(points=points, rounding=_SMALLER * capsule.rounding)
