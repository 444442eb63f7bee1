"""Number boxes step by a round part of the workspace, whatever its unit."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.scene.scene import Scene, load_scene
from app.panels.length_step import fine_step, length_step
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until


@given(st.floats(1e-3, 1e5))
def test_a_step_is_round_and_a_small_part_of_the_longest_side(longest: float) -> None:
    workspace = {"min": [0, 0, 0], "max": [longest, longest / 2, longest / 3]}
    scene = Scene(version=1).model_copy(
        update={"workspace": Scene(version=1).workspace.model_validate(workspace)}
    )
    for step, parts in ((length_step(scene), 60), (fine_step(scene), 120)):
        assert parts * (1 - 1e-6) <= longest / step <= 2.5 * parts * (1 + 1e-6)
        digits = f"{step:.12e}".partition("e")[0].rstrip("0.")
        assert digits in ("1", "2", "5")


@pytest.mark.parametrize(("name", "step"), [("paper", 0.1), ("kitchen-ur5e", 0.01)])
def test_boxes_of_a_scene_step_by_it(tab: tuple[FakeTab, Session], name: str, step: float) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, name)
    scene = load_scene(name)
    until(lambda: session.frame.plan.scene == scene and session.resting)
    stages, editor = session.panels.stages, session.panels.editor
    sizes, region = editor.sizes, stages.bases
    boxes: tuple[Any, ...] = (
        *(sizes.size, sizes.radius, sizes.height, editor._position.handle),
        *(box.handle for box in editor._end_boxes.values()),
        *(stages.arm.base, stages.arm.links, stages.arm.extension),
        *(
            stages.fields["motion.speed"],
            stages.fields["motion.acceleration"],
            region.middle.handle,
            region.sides.handle,
        ),
    )
    assert {box.step for box in boxes} == {step}
    assert math.isclose(stages.arm.clearance.step, step / 2)
    assert math.isclose(stages.fields["motion.jerk"].step, 10 * step)
