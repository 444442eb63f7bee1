"""Directions of an arm's certificate, grouped by capsule and by what they keep it from."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

from abi.verify.exact import Vec3
from abi.verify.fault import Fault
from abi.verify.plan_fields import finite, list_of, mapping, vector_of

FIELD = "arm.certificate"

Key = tuple[int, int | str]
"""A capsule, and what it must keep clear of."""


class Plane(NamedTuple):
    """A direction that keeps a capsule from something on a piece of the motion.

    Attributes:
        start, end: parameters of the piece.
        at: parameter of the pose around which it holds.
        normal: the direction.
    """

    start: Fraction
    end: Fraction
    at: Fraction
    normal: Vec3


def planes_of(
    certificate: dict[str, Any],
    capsules: int,
    obstacle_of: Callable[[dict[str, Any], int], int | str],
) -> dict[Key, list[Plane]]:
    """Planes by capsule and obstacle, in the order in which their pieces begin.

    Args:
        certificate: as in a plan's JSON.
        capsules: number of capsules.
        obstacle_of: function from an entry and the number of capsules to what it keeps clear of.

    Raises:
        Fault: an entry names an unknown capsule, or nothing that ``obstacle_of`` knows.
    """
    planes: dict[Key, list[Plane]] = {}
    for entry in list_of(f"{FIELD}.planes", certificate.get("planes")):
        data = mapping(f"{FIELD}.planes", entry)
        capsule = data.get("capsule")
        if type(capsule) is not int or not 0 <= capsule < capsules:
            raise Fault("a direction belongs to no capsule")
        obstacle = obstacle_of(data, capsules)
        start, end, at = (
            Fraction(finite(f"{FIELD}.planes.{key}", data.get(key))) for key in ("t0", "t1", "at")
        )
        normal = vector_of(f"{FIELD}.planes.direction", data.get("direction"))
        planes.setdefault((capsule, obstacle), []).append(Plane(start, end, at, normal))
    for group in planes.values():
        group.sort(key=_start)
    return planes


def _start(plane: Plane) -> Fraction:
    return plane.start
