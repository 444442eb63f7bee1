"""Look of a new tab: its scene, dark or light, plain, and with or without the demonstration."""

from __future__ import annotations

from dataclasses import dataclass

OPENING = "drag-a-box"
"""The shipped scene that a tab opens on where none is named."""


@dataclass(frozen=True)
class Appearance:
    """Look of a new tab.

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
"""For slow graphics and tests."""
