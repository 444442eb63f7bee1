"""Initial appearance of a tab: scene, dark or light, plain, with or without the demonstration."""

from __future__ import annotations

from dataclasses import dataclass

OPENING = "drag-a-box"
"""Shipped scene that a tab opens with by default."""


@dataclass(frozen=True)
class Appearance:
    """Initial appearance of a tab.

    Attributes:
        plain: whether without shadows and environment map, for slow graphics and tests; None for
            where the browser draws without a graphics card.
        dark: whether it is dark; None for as the system has it.
        demo: whether its first obstacle moves by itself until the first touch.
    """

    plain: bool | None = None
    dark: bool | None = None
    demo: bool = False


PLAIN = Appearance(plain=True)
"""Appearance for slow graphics and for tests."""
