"""Cards of the scenes, described by the comment at the head of each file."""

from __future__ import annotations

import functools
import re

import viser

from abi import assets
from abi.scene.scene import scene_names
from app.ui.cards import card

_SENTENCE = re.compile(r"(?<=[.!?]) ")


def scene_cards(widget: viser.GuiDropdownHandle[str], chosen: str) -> list[str]:
    """A card of each shipped scene that sets ``widget``, as HTML, the ``chosen`` one first."""
    return [
        card(
            widget,
            name,
            about(name),
            assets.path("pictures", "scenes", f"{name}.webp"),
            name == chosen,
        )
        for name in sorted(scene_names(), key=lambda name: name != chosen)
    ]


@functools.cache
def about(name: str) -> str:
    """The first sentence of the comment at the head of a shipped scene's file."""
    text = assets.path("scenes", f"{name}.yaml").read_text(encoding="utf-8")
    comment = re.match(r"(#.*\n)*", text)
    assert comment is not None
    lines = (line.removeprefix("#").strip() for line in comment[0].splitlines())
    return _SENTENCE.split(" ".join(lines))[0]
