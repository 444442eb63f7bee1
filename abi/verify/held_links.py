"""Links that held joints carry, by their own triangles: what of them no proof compares."""

from __future__ import annotations

import itertools
from collections.abc import Collection

import numpy as np

from abi.scene.scene import Scene
from abi.verify.exact.chain import ExactChain
from abi.verify.link_contact import LinkTriangles, link_triangles, touch

_SUNK = 2e-3
"""Depth below the floor that is told, [m]."""
_MOST_TRIANGLES = 20_000
_MOST = 6


def held_below_floor(scene: Scene, chain: ExactChain) -> list[str]:
    """Links that stand still below the floor because a joint holds them there, in order."""
    floor = min(scene.arm.base[2], scene.workspace.min[2]) - _SUNK * float(chain.units)
    carried = _carriers(scene, chain)
    found = []
    for name, one in _still(scene, chain).items():
        lowest = (one.corners[..., 2].min(axis=1) - one.radii).min()
        if carried[name] and lowest < floor:
            found.append(name)
    return sorted(found)


def held_in_each_other(
    scene: Scene, chain: ExactChain, allowed: Collection[Collection[str | int]] = ()
) -> str:
    """What is said of links that stand still in each other, as a sentence's end.

    Those that one joint joins are no such links, nor are ``allowed`` pairs and those of the SRDF.
    """
    carried, still = _carriers(scene, chain), _still(scene, chain)
    # one joint counts where anything that is fixed behind it has a shape
    shaped = {carried[name][-1:] for name in still}
    may_touch = {*scene.robot.may_touch, *map(frozenset, allowed)}
    may_touch |= {frozenset(one.ends) for one in scene.robot.couplings}
    found = []
    for first, second in itertools.combinations(still, 2):
        between = {*carried[first]} ^ {*carried[second]}
        if sum((name,) in shaped for name in between) < 2 or {first, second} in may_touch:
            continue
        one, other = still[first], still[second]
        if max(len(one.corners), len(other.corners)) > _MOST_TRIANGLES:
            continue
        if _near(one, other) and touch(one, other):
            found.append(f"{second} and {first}")
    more = f" and {len(found) - _MOST} more" if len(found) > _MOST else ""
    return f"; held in each other: {', '.join(found[:_MOST])}{more}" if found else ""


def _carriers(scene: Scene, chain: ExactChain) -> dict[str, tuple[str, ...]]:
    """Names of the joints, but for fixed ones, between the root and each link."""
    found: dict[str, tuple[str, ...]] = {scene.robot.root: ()}
    for joint in scene.robot.joints:
        own = () if joint.kind == "fixed" else (joint.name,)
        found[joint.child] = found[joint.parent] + own
    return {name: found[name] for name in chain.frames}


def _still(scene: Scene, chain: ExactChain) -> dict[str, LinkTriangles]:
    """Triangles of each link that stands still, world, [unit]."""
    found = {}
    for name, frame in chain.frames.items():
        link = scene.robot.links[name]
        if frame < 0 and link.shapes:
            pose = chain.places[name].astype(np.float64)
            turn, origin = pose[:3, :3], pose[:3, 3]
            found[name] = link_triangles(link, float(chain.units)).placed(turn, origin)
    return found


def _near(first: LinkTriangles, second: LinkTriangles) -> bool:
    """Check whether the boxes around two links overlap."""
    (low, high), (others_low, others_high) = (
        (
            (one.corners.min(axis=1) - one.radii[:, None]).min(axis=0),
            (one.corners.max(axis=1) + one.radii[:, None]).max(axis=0),
        )
        for one in (first, second)
    )
    return bool((low <= others_high).all() and (others_low <= high).all())
