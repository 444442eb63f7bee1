"""Undo and redo: whatever was done, one gets back, and forward again."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from abi.scene.scene import Scene, load_scene
from app.panels.files.history import History, HistoryStep
from app.tab.session import Session
from tests.app.fake_tab import FakeTab, until


class _Widget:
    def on_click(self, _: object) -> None:
        pass

    on_trigger = on_click


class _Gui:
    def add_button(self, *_: object, **__: object) -> _Widget:
        return _Widget()

    add_command = add_button


def _step(number: int) -> HistoryStep:
    scene = Scene(version=1, motion={"speed": float(number + 1)})
    return HistoryStep(scene, f"scene {number}", scene)


@given(st.lists(st.sampled_from(["undo", "redo", *range(5)]), max_size=30))
def test_history_is_that_of_an_editor(steps: list[str | int]) -> None:
    history = History(_Gui(), _step(0), lambda _: None)  # type: ignore[arg-type]
    before, now, after = list[HistoryStep](), _step(0), list[HistoryStep]()
    for step in steps:
        if isinstance(step, int):
            if _step(step) != now:
                before, now, after = [*before, now], _step(step), []
            history.note(_step(step))
        elif step == "undo":
            history._step(-1, None)
            old = now
            if before:
                before, now, after = before[:-1], before[-1], [now, *after]
            assert history.requested(old) == now
        else:
            history._step(1, None)
            old = now
            if after:
                before, now, after = [*before, now], after[0], after[1:]
            assert history.requested(old) == now
        assert history.noted == now.scene
        assert history.can_undo == bool(before)
        assert history.can_redo == bool(after)
    assert history.requested(now) is None


def test_undo_leads_from_what_a_teacher_shows_back_to_ones_own_work() -> None:
    history = History(_Gui(), _step(0), lambda _: None)  # type: ignore[arg-type]
    shown = _step(1)  # not noted yet: the hand has just let go
    for number in (5, 6, 7):
        history.follow(shown, _step(number))
        shown = _step(number)
        assert history.noted == shown.scene
    history._step(-1, None)
    assert history.requested(shown) == _step(1)
    # what the teacher shows next is a step of its own again
    history.follow(_step(1), _step(8))
    history.note(_step(2))
    history.follow(_step(2), _step(9))
    steps = []
    latest = _step(9)
    for _ in range(5):
        history._step(-1, None)
        latest = history.requested(latest) or latest
        steps.append(latest)
    assert steps == [_step(2), _step(8), _step(1), _step(0), _step(0)]


def test_a_teacher_who_shows_ones_own_scene_takes_nothing_from_it() -> None:
    history = History(_Gui(), _step(0), lambda _: None)  # type: ignore[arg-type]
    history.follow(_step(0), _step(0))
    history.follow(_step(0), _step(3))
    history._step(-1, None)
    assert history.requested(_step(3)) == _step(0)


@pytest.mark.slow
def test_everything_is_undone_and_done_again(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    until(lambda: session.resting)
    panels = session.panels
    scenes = [load_scene("paper")]

    def done() -> None:
        until(lambda: session.frame.plan.scene != scenes[-1])
        until(lambda: panels.history.noted == session.frame.plan.scene)
        scenes.append(session.frame.plan.scene)

    fake.set(panels.stages.fields["spline.degree"], 2)
    done()
    fake.drag(panels.obstacles.gizmos[0], [3.0, 3.0, 2.0])
    done()
    fake.set(panels.editor.buttons, "Add")
    done()
    fake.set(panels.files.choice, "two-boxes")
    done()
    gizmos = panels.obstacles.gizmos
    panels.obstacles.write(scenes[-1])
    assert panels.obstacles.gizmos == gizmos  # those of the same shapes stay in the page
    for scene in scenes[-2::-1]:
        fake.set(panels.history.undo, True)
        until(lambda scene=scene: session.frame.plan.scene == scene)  # type: ignore[misc]
        assert panels.files.choice.value == panels.files.name == "paper"
        assert panels.files.loaded == scenes[0]
    for scene in scenes[1:]:
        fake.set(panels.history.redo, True)
        until(lambda scene=scene: session.frame.plan.scene == scene)  # type: ignore[misc]
    assert panels.files.choice.value == panels.files.name == "two-boxes"
    assert panels.files.loaded == scenes[-1]
    assert len(panels.obstacles.gizmos) == 2


@pytest.mark.slow
def test_a_scene_whose_choice_was_undone_can_be_chosen_again(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    files, paper = session.panels.files, load_scene("paper")
    until(lambda: session.resting)
    for _ in range(2):
        fake.set(files.choice, "two-boxes")
        until(lambda: session.frame.plan.scene == load_scene("two-boxes"))
        until(lambda: session.resting)
        fake.set(session.panels.history.undo, True)
        until(lambda: session.frame.plan.scene == paper)
        until(lambda: session.resting)
    assert session.state().name == "paper"
    fake.drag(session.panels.obstacles.gizmos[0], [3.0, 3.0, 2.0])
    until(lambda: session.frame.plan.scene != paper)
    fake.set(files.reset, True)
    until(lambda: session.frame.plan.scene == paper)


@pytest.mark.slow
def test_what_was_changed_just_before_another_scene_was_opened_is_not_lost(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    panels, paper = session.panels, load_scene("paper")
    until(lambda: session.resting)
    for degree in (2, 3):
        fake.set(panels.stages.fields["spline.degree"], degree)
        until(lambda degree=degree: session.scene.spline.degree == degree)  # type: ignore[misc]
        fake.set(panels.files.choice, "two-boxes")  # not yet at rest
        until(lambda: session.frame.plan.scene == load_scene("two-boxes"))
        fake.set(panels.history.undo, True)
        changed = paper.replace(spline={"degree": degree})
        until(lambda changed=changed: session.frame.plan.scene == changed)  # type: ignore[misc]
        assert (panels.files.choice.value, panels.files.loaded) == ("paper", paper)


def test_changes_of_one_field_soon_after_each_other_are_one_step() -> None:
    history = History(_Gui(), _step(0), lambda _: None)  # type: ignore[arg-type]
    for number, time in ((1, 10.0), (2, 11.0), (3, 12.5), (4, 20.0)):
        history.note(_step(number), time)
    found = [_step(4)]
    for _ in range(2):
        history._step(-1, None)
        found.append(history.requested(found[-1]) or found[-1])
    assert found == [_step(4), _step(3), _step(0)]
    assert not history.can_undo
    history.note(replace(_step(0), scene=Scene(version=1, spline={"degree": 3})), 21.0)
    history.note(_step(1), 21.5)
    assert history.can_undo
    history._step(-1, None)
    before = history.requested(_step(1))
    assert before is not None
    assert before.scene.spline.degree == 3


def test_what_was_changed_just_before_a_drag_is_a_step_of_its_own(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    panels, gizmo = session.panels, session.panels.obstacles.gizmos[0]
    until(lambda: session.resting)
    fake.set(panels.stages.fields["spline.degree"], 2)
    until(lambda: session.scene.spline.degree == 2)
    changed = session.scene
    fake.hold(gizmo)  # not yet at rest
    fake.drag(gizmo, [3.0, 3.0, 2.0])
    until(lambda: session.frame.plan.scene.obstacles[0].position == (3.0, 3.0, 2.0))
    fake.let_go(gizmo)
    until(lambda: not panels.held and session.resting)
    fake.set(panels.history.undo, True)
    until(lambda: session.frame.plan.scene == changed and session.resting)
