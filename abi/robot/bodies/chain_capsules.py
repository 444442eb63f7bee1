"""Capsules around the links that a chain carries, and bounds of their motion."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import attrgetter

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, flat, read_only
from abi.robot.bodies.capsule_table import Bodies
from abi.robot.bodies.link_bodies import Body, Fit, link_bodies
from abi.robot.bodies.telescopes import open_bodies
from abi.robot.kinematics.chain import Chain
from abi.robot.kinematics.chain_kernels import POSE

_THIN = 1e-3
"""Radius of a line that stands for a link without a shape, [m]."""


def capsules_of(chain: Chain, fits: Mapping[str, Fit]) -> tuple[Body, ...]:
    """Capsules of all links, those that stand still first; of a robot without shapes, of lines.

    Args:
        chain: the chain.
        fits: of the links, by their names, that are to be fitted more closely.
    """
    capsules, beside = list[Body](), open_bodies(chain)
    for link in chain.frames:
        fit = fits.get(link, "quick")
        bodies = beside.get(link) or link_bodies(chain.robot.links[link], fit)
        capsules.extend(carried_bodies(chain, link, bodies))
    if not has_own_shape(chain, capsules):
        capsules += _skeleton(chain)
    return tuple(sorted(capsules, key=attrgetter("frame")))


def has_own_shape(chain: Chain, bodies: Iterable[Body]) -> bool:
    """Check whether a link that moves has a body, other than the object that the robot holds."""
    return any(one.frame >= 0 and one.link != chain.robot.attached for one in bodies)


def carried_bodies(chain: Chain, link: str, bodies: Iterable[Body]) -> Iterator[Body]:
    """Bodies of a link in the frame of the joint that moves it."""
    turn, origin = chain.places[link][:3, :3], chain.places[link][:3, 3]
    for body in bodies:
        ends, points = (read_only(one @ turn.T + origin) for one in (body.ends, body.points))
        yield Body(ends, body.radius, points, body.rounding, link, chain.frames[link])


def _skeleton(chain: Chain) -> list[Body]:
    """Thin capsules from joint to joint, and to the tip, where no link that moves has a shape."""
    table, last = chain.table, chain.table.length - 1
    places = table.origins.reshape(-1, POSE)[:, 9:]
    lines = [
        (int(frame), joint.parent) for frame, joint in zip(table.before, chain.joints, strict=True)
    ]
    lines.append((last, chain.joints[last].child))
    return [
        Body(line, _THIN, line, _THIN, link, frame)
        for (frame, link), line in zip(lines, map(_from_origin, places), strict=True)
        if frame >= 0
    ]


def _from_origin(place: FloatArray) -> FloatArray:
    """Ends (2, 3) of the segment from a frame's origin to a place in it."""
    return read_only(np.stack([np.zeros(3), place]))


def place(capsules: Sequence[Body], poses: FloatArray) -> FloatArray:
    """Ends (k, c, 2, 3) of capsules, by frames, whose poses are (k, m + 1, 3, 4), [m]."""
    ends, done = np.empty((len(poses), len(capsules), 2, 3)), 0
    for frame, of_frame in itertools.groupby(capsules, attrgetter("frame")):
        points = np.concatenate([one.ends for one in of_frame])
        first, done = done, done + len(points) // 2
        if frame >= 0:
            pose = poses[:, frame]
            # one product for all poses: many small ones take far longer
            turned = (pose[..., :3].reshape(-1, 3) @ points.T).reshape(len(poses), 3, -1)
            points = (turned + pose[..., 3:]).swapaxes(1, 2)
        ends[:, first:done] = points.reshape(-1, done - first, 2, 3)
    return ends


def hulls_of(chain: Chain, bodies: Sequence[Body], metres: float) -> Bodies:
    """Hulls of bodies for the kernels, without capsules, levers and pairs.

    Args:
        chain: the chain that moves them.
        bodies: pieces of its links.
        metres: one [unit] in metres.
    """
    corners, none = [one.points for one in bodies], read_only(np.zeros(0))
    return Bodies(
        moving=len(chain.joints),
        frames=read_only(np.array([one.frame for one in bodies], dtype=np.int32)),
        ends=none,
        radii=none,
        levers=none,
        pairs=read_only(np.zeros(0, dtype=np.int32)),
        pair_levers=none,
        points=flat(np.concatenate(corners)),
        first=read_only(np.cumsum([0, *map(len, corners)], dtype=np.int32)),
        roundings=read_only(np.array([one.rounding for one in bodies]) / metres),
        point_levers=none,
        point_pair_levers=none,
        scale=1 / metres,
    )


def lever(chain: Chain, frame: int, points: FloatArray, behind: int) -> FloatArray:
    """Bound of points' motion per unit of each coordinate, by joints behind one, (n,), [m].

    A point turns about a joint at most at the length of the chain between them; a slide moves it as
    far as itself.

    Args:
        chain: the chain.
        frame: number of the joint that moves the points, -1 where they stand still.
        points: in that frame, shape (k, 3), [m].
        behind: number of a joint that moves them, seen from whose frame it is; -1 for the world.
    """
    table, found = chain.table, np.zeros(len(chain.names))
    far = float(np.linalg.norm(points, axis=1).max())
    for k in chain.behind(frame):
        if k == behind:
            break
        coordinate, slides = int(table.source[k]), bool(table.slides[k])
        found[coordinate] += abs(float(table.factor[k])) * (1.0 if slides else far)
        far += float(np.linalg.norm(table.origins[12 * k + 9 : 12 * k + 12]))
        ends = table.factor[k] * chain.limits[coordinate] + table.offset[k]
        far += float(np.abs(ends).max()) if slides else 0.0
    return found


def meeting(chain: Chain, first: int, second: int) -> int:
    """Number of the last joint that moves both of two frames, -1 for the world."""
    others = chain.behind(second)
    return next((k for k in chain.behind(first) if k in others), -1)


def segment_distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Distances (k,) between segments (k, 2, 3) and (k, 2, 3).

    The least distance is at one of the four ends or where the lines come nearest (Ericson,
    Real-Time Collision Detection, section 5.1.9).
    """
    first = arguments.numbers("first", first, (-1, 2, 3))
    second = arguments.numbers("second", second, first.shape)
    p, q = first[:, 0], second[:, 0]
    d, e = first[:, 1] - p, second[:, 1] - q
    a, b, c = (np.einsum("ij,ij->i", u, v) for u, v in ((d, d), (d, e), (e, e)))
    f = np.einsum("ij,ij->i", d, p - q)
    g = np.einsum("ij,ij->i", e, p - q)
    tiny = 1e-300
    inner = np.clip((b * g - c * f) / np.maximum(a * c - b * b, tiny), 0, 1)
    best = np.full(len(p), np.inf)
    for s in (inner, np.zeros_like(a), np.ones_like(a), np.clip(-f / np.maximum(a, tiny), 0, 1),
              np.clip((b - f) / np.maximum(a, tiny), 0, 1)):  # fmt: skip
        t = np.clip((b * s + g) / np.maximum(c, tiny), 0, 1)
        away = p + s[:, None] * d - q - t[:, None] * e
        best = np.minimum(best, np.einsum("ij,ij->i", away, away))
    return np.asarray(np.sqrt(best))
