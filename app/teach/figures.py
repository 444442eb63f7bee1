"""The paper's figures: scene, layers and camera of each."""

from __future__ import annotations

import functools

from abi import assets
from abi.scene.scene_file import parse
from app.teach.lesson import Lesson, Step


@functools.cache
def figures() -> tuple[Step, ...]:
    """The figures in the paper's order: pages of a lesson whose text is the caption."""
    return Lesson.model_validate(parse(assets.path("lessons", "figures", "paper.yaml"))).steps
