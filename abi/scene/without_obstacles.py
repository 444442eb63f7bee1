"""A scene without some of its obstacles, with contacts still referring to the same ones."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from abi.scene.scene import Scene

Contact = tuple[str, str | int]


def without_obstacles(scene: Scene, numbers: Collection[int]) -> dict[str, Any]:
    """Change of a scene, for :meth:`Scene.replace`, that removes obstacles.

    Contacts that the scene allows with obstacles after them, and what legs attach, get their new
    numbers; a leg that would attach one of them attaches nothing.

    Args:
        scene: the scene.
        numbers: of the obstacles to leave out, from 0.
    """
    left = [one for number, one in enumerate(scene.obstacles) if number not in numbers]
    allowed = contacts_without(scene.arm.allowed, numbers)
    change: dict[str, Any] = {"obstacles": left}
    legs = legs_without([leg.model_dump(mode="json") for leg in scene.tasks], numbers)
    taken = [one.attach for one in scene.tasks if one.attach is not None]
    if taken and max(taken) >= min(numbers, default=max(taken) + 1):
        change["tasks"] = legs
    return change if allowed == scene.arm.allowed else {**change, "arm": {"allowed": allowed}}


def contacts_without(contacts: Iterable[Contact], numbers: Collection[int]) -> tuple[Contact, ...]:
    """Contacts that remain without some obstacles, with the remaining obstacles' new numbers.

    Args:
        contacts: pairs of links, or of a link and the number of an obstacle from 0.
        numbers: of the obstacles that are left out.
    """
    return tuple(
        (link, _renumbered(other, numbers)) for link, other in contacts if other not in numbers
    )


def legs_without(
    legs: Iterable[Mapping[str, Any]], numbers: Collection[int], holds_it: bool = False
) -> list[dict[str, Any]]:
    """Legs of which none attaches, and then releases, an obstacle that is not there.

    Args:
        legs: fields of each.
        numbers: of the obstacles that are left out, from 0.
        holds_it: whether the object is left out that is held before the first leg.
    """
    found = []
    for leg in map(dict, legs):
        attach = leg.get("attach")
        if leg.get("release") is True and holds_it:
            leg, holds_it = {**leg, "release": False}, False
        elif type(attach) is int:
            holds_it = attach in numbers
            leg["attach"] = None if holds_it else _renumbered(attach, numbers)
        found.append(leg)
    return found


def _renumbered(other: str | int, numbers: Collection[int]) -> str | int:
    return other if isinstance(other, str) else other - sum(one < other for one in numbers)
