"""A scene without some of its obstacles, with contacts still referring to the same ones."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from abi.scene.scene import Scene

Contact = tuple[str, str | int]


def without_obstacles(scene: Scene, numbers: Collection[int]) -> dict[str, Any]:
    """Change of a scene, for :meth:`Scene.replace`, that removes obstacles.

    Contacts that the scene allows with obstacles after them get their new numbers.

    Args:
        scene: the scene.
        numbers: of the obstacles to leave out, from 0.
    """
    left = [one for number, one in enumerate(scene.obstacles) if number not in numbers]
    allowed = contacts_without(scene.arm.allowed, numbers)
    change: dict[str, Any] = {"obstacles": left}
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


def _renumbered(other: str | int, numbers: Collection[int]) -> str | int:
    return other if isinstance(other, str) else other - sum(one < other for one in numbers)
