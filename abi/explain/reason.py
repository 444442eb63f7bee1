"""Reason why a scene has no plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from abi.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Reason:
    """Reason why there is no plan.

    Attributes:
        message: one sentence on the cause.
        hint: one sentence on a remedy; every number in it has been tried.
        change: arguments of ``scene.replace(**change)`` for a scene that gets past the stage that
            failed, and that has a plan if ``hint`` does not say otherwise; None when nothing that
            was tried helps.
        points: points to mark in the scene, shape (k, 3), [unit], world.
        obstacle: index of the obstacle that ``change`` removes; None where it removes none.
        moved: index of the obstacle that ``change`` moves; None where it moves none.
        others: further changes that ``hint`` names; the scene has a plan with each of them.
        is_whole: whether the scene has a plan with ``change``, as far as is known.
    """

    message: str
    hint: str
    change: dict[str, Any] | None
    points: FloatArray
    obstacle: int | None = None
    moved: int | None = None
    others: tuple[dict[str, Any], ...] = ()
    is_whole: bool = True

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as under ``error`` in a plan's JSON."""
        return {"message": self.message, "hint": self.hint, "change": self.change}
