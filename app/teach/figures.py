"""The paper's figures: scene, layers and camera of each."""

from __future__ import annotations

import functools
from typing import Literal

from pydantic import BaseModel, ConfigDict, TypeAdapter

from abi import assets
from abi.scene.scene_file import parse
from app.teach.lesson import Setting


class Figure(BaseModel):
    """One figure.

    Attributes:
        caption: what it shows, and what to look at.
        set: how.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    caption: str
    set: Setting


_FILE = TypeAdapter(dict[Literal["figures"], tuple[Figure, ...]])


@functools.cache
def figures() -> tuple[Figure, ...]:
    """The figures in the paper's order."""
    data = parse(assets.path("lessons", "figures", "paper.yaml"))
    return _FILE.validate_python(data)["figures"]
