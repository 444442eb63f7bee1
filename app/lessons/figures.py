"""The paper's figures: scene, layers and camera of each."""

from __future__ import annotations

import functools

from pydantic import BaseModel, ConfigDict

from abi import assets
from abi.scene.scene_file import parse
from app.lessons.lesson import Setting


class Figure(BaseModel):
    """One figure.

    Attributes:
        caption: what it shows, and what to look at.
        set: how.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    caption: str
    set: Setting


class _Figures(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    figures: tuple[Figure, ...]


@functools.cache
def figures() -> tuple[Figure, ...]:
    """The figures in the paper's order."""
    return _Figures.model_validate(parse(assets.path("lessons", "figures", "paper.yaml"))).figures
