from __future__ import annotations

import math
import time
from typing import Any, cast

import numpy as np
import pytest
import viser
from hypothesis import assume, given
from hypothesis import strategies as st

from abi import load_scene
from app.camera.camera import Viewpoint
from app.camera.extent import extent
from app.camera.framing import Window, axes, covered, holds, stand, widest
from app.camera.view import View
from app.drawing.box import box_corners
from app.stages.catalogue import SHOWN_STAGES
from app.tab.session import Session
from app.ui.page_area import PageArea
from tests.app.fake_tab import FakeTab, until


def distance(session: Session) -> float:
    camera = session.client.camera
    return float(np.linalg.norm(camera.position - camera.look_at))


@pytest.mark.slow
@pytest.mark.parametrize("width", [300, 200])
def test_in_a_narrow_picture_the_camera_steps_back_and_near_again(
    tab: tuple[FakeTab, Session], width: int
) -> None:
    fake, session = tab
    session.playback.playing = True
    near = distance(session)
    fake.look(session.client.camera, width)
    until(lambda: distance(session) > 1.2 * near)
    fake.look(session.client.camera, 900)
    until(lambda: distance(session) == pytest.approx(near))


def test_a_camera_that_the_hand_has_moved_stays(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    session.playback.playing = True
    fake.look(session.client.camera, 300, position=[1.0, -9.0, 2.0])
    until(lambda: session._view.viewpoint._distance_factor > 1)

    np.testing.assert_allclose(session.client.camera.position, [1.0, -9.0, 2.0])


def test_an_arm_that_is_far_too_large_is_seen_whole(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    model = session.panels.stages.arm.model.model
    until(lambda: session.resting)
    near = distance(session)
    fake.set(model, "UR5e")
    until(lambda: distance(session) > 8 * near)
    fake.set(model, "the paper's arm")
    until(lambda: distance(session) == pytest.approx(near))


def test_in_a_lecture_all_is_seen_from_the_same_side(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    camera, lecture = session.client.camera, session.panels.lecture
    before, away = camera.position, camera.position - camera.look_at
    fake.set(lecture.toggle, True)
    until(lambda: lecture.on and not np.allclose(camera.position, before))
    away_now = camera.position - camera.look_at
    np.testing.assert_allclose(np.cross(away_now, away), 0, atol=1e-6)
    assert session.plan is not None
    right, up, forward = axes(away)
    seen = extent(session.plan) - camera.position
    half = np.tan(camera.fov / 2)
    assert (np.abs(seen @ up) < half * (seen @ forward)).all()
    assert (np.abs(seen @ right) < half * camera.aspect * (seen @ forward)).all()
    fake.set(lecture.toggle, True)
    until(lambda: not lecture.on and np.allclose(camera.position, before))


@pytest.mark.parametrize("above", [0.06, 0.08])
@pytest.mark.parametrize("size", [(6, 6, 6), (15, 6, 6), (1.6, 1.6, 1), (3, 8, 4)])
def test_a_workspace_alone_fills_a_lecture_hall_s_screen(
    size: tuple[float, float, float], above: float
) -> None:
    corners = box_corners((0, 0, 0), size)
    window = Window(math.radians(75), 1920 / 1080, above, 0.18)
    for angle in np.linspace(0, 2 * np.pi, 13):
        usual = np.array([np.cos(angle), np.sin(angle), 0.38])
        place = stand(corners, widest(corners, usual, window), window)
        width, height = covered(corners, *place, window)
        assert width >= 0.45
        assert height >= 0.55 or width > 0.85  # a flat one cannot be high as well
        assert holds(corners, *place, window)


def test_a_lecture_turns_to_the_workspace_alone_until_the_arm_is_shown(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    camera, lecture = session.client.camera, session.panels.lecture
    fake.set(lecture.toggle, True)
    until(lambda: lecture.on and session.resting)
    whole = camera.position
    for stage in SHOWN_STAGES:
        fake.set(lecture._forward, True)
        until(lambda: session.frame.stage == stage and session.resting)  # noqa: B023
        assert np.allclose(camera.position, whole) == (stage == "arm")


def test_a_view_that_is_chosen_follows_the_picture(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    camera, lecture = session.client.camera, session.panels.lecture
    fake.set(lecture.toggle, True)
    until(lambda: lecture.on)
    fake.set(lecture._views["Front"], True)
    until(lambda: session.resting and bool(camera.position[1] > camera.look_at[1]))
    near = distance(session)
    fake.look(camera, 300)
    until(lambda: distance(session) > 1.2 * near)
    assert camera.position[1] > camera.look_at[1]


def test_undo_leaves_the_camera_where_the_hand_has_put_it(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    until(lambda: session.resting)
    speed = session.panels.stages.fields["motion.speed"]
    fake.look(session.client.camera, 900, position=[1.0, -9.0, 2.0])
    fake.set(speed, 3.0)
    until(lambda: session.resting and session.panels.history.can_undo)
    fake.set(session.panels.history.undo, True)
    until(lambda: session.resting and session.frame.plan.scene.motion.speed != 3.0)
    assert session.frame.plan.scene is session.panels.files.loaded
    np.testing.assert_allclose(session.client.camera.position, [1.0, -9.0, 2.0])


def test_in_a_lecture_the_camera_follows_what_the_hand_has_let_go(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    camera, lecture, goal = session.client.camera, session.panels.lecture, _goal(session)
    before = camera.position
    fake.set(lecture.toggle, True)
    until(lambda: lecture.on and session.resting and not np.allclose(camera.position, before))
    before, plans = camera.position, session.plans
    fake.hold(goal)
    fake.set(session.panels.stages.arm.base, [0.0, -12.0, 0.0])
    until(lambda: session.plans > plans and session.resting)
    assert not _sees_all(session)
    np.testing.assert_array_equal(camera.position, before)
    fake.let_go(goal)
    until(lambda: _sees_all(session))


def test_in_a_lecture_a_camera_that_the_hand_has_turned_does_not_follow(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    camera, lecture = session.client.camera, session.panels.lecture
    fake.set(lecture.toggle, True)
    until(lambda: lecture.on and session.resting)
    fake.look(camera, 900, position=[12.0, -6.0, 3.0])
    until(lambda: bool(camera.position[0] == 12))
    plans = session.plans
    fake.set(session.panels.stages.arm.base, [0.0, -12.0, 0.0])
    until(lambda: session.plans > plans and session.resting)
    np.testing.assert_array_equal(camera.position, [12.0, -6.0, 3.0])


def test_a_picture_without_area_is_none_to_follow(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    camera = session.client.camera
    session.playback.playing = True
    near = distance(session)
    fake.look(camera, 0)
    until(lambda: camera.image_width == 0)
    plans = session.plans
    fake.set(session.panels.stages.arm.base, [0.0, -12.0, 0.0])
    until(lambda: session.plans > plans and session.resting)
    assert session._fault is None
    assert distance(session) == near


def test_a_page_that_tells_of_the_place_before_has_not_moved_its_camera(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    camera, lecture = session.client.camera, session.panels.lecture
    before = camera.position
    fake.set(lecture.toggle, True)
    until(lambda: lecture.on and session.resting and not np.allclose(camera.position, before))
    fake.look(camera, 300, position=list(before))
    until(lambda: camera.image_width == 300 and _sees_all(session))


@pytest.mark.parametrize("same", [True, False])
def test_text_counts_only_where_it_was_measured_in_a_picture_of_this_shape(
    tab: tuple[FakeTab, Session], same: bool
) -> None:
    _, session = tab
    viewpoint, camera = session._view.viewpoint, session.client.camera
    width, height = float(camera.image_width), float(camera.image_height)
    # with a panel still open the scene beside it had half the width
    area = PageArea(width=width, height=height, left=0.0 if same else width / 2, below=0.3)
    assert viewpoint._free(area).below == (0.3 if same else viewpoint._free(None).below)
    assert viewpoint._free(None).below < 0.3


@pytest.mark.parametrize("arrives", [True, False])
def test_text_about_a_scene_hides_none_of_the_arm_that_has_just_come(
    tab: tuple[FakeTab, Session], arrives: bool
) -> None:
    _, session = tab
    until(lambda: session.resting)
    viewpoint, camera, plan = session._view.viewpoint, session.client.camera, session.plan
    assert plan is not None
    viewpoint.face(plan)
    height = float(camera.image_height)
    viewpoint.fit(PageArea(camera.image_width, height, above=0.35), arrives=arrives)
    window = Window(camera.fov, camera.aspect, above=0.35)
    assert holds(extent(plan), camera.position, camera.look_at, window) == arrives


def test_text_hides_none_of_the_arm_in_a_picture_of_another_shape(
    tab: tuple[FakeTab, Session],
) -> None:
    _, session = tab
    until(lambda: session.resting)
    viewpoint, camera, plan = session._view.viewpoint, session.client.camera, session.plan
    assert plan is not None
    viewpoint.face(plan)
    wide = PageArea(camera.image_width, camera.image_height, above=0.35)
    viewpoint.fit(wide)
    window = Window(camera.fov, camera.aspect, above=0.35)
    assert not holds(extent(plan), camera.position, camera.look_at, window)
    camera._state.image_width, camera._state.image_height = 700, 900
    viewpoint.fit(wide)  # what the page tells comes later
    viewpoint.fit(PageArea(700.0, 900.0, above=0.35))
    window = Window(camera.fov, 700 / 900, above=0.35)
    assert holds(extent(plan), camera.position, camera.look_at, window)


def test_late_words_of_the_page_neither_move_a_given_view_nor_keep_an_old_place() -> None:
    camera = camera_at(USUAL)
    camera._state.fov = math.radians(75)
    camera._state.image_width, camera._state.image_height = 900, 900
    opened = camera.position
    viewpoint = Viewpoint(camera, load_scene("drag-a-box"))
    begun = camera.position
    camera._state.position = opened  # what the page told of itself, again
    viewpoint.fit(PageArea(900.0, 900.0))
    np.testing.assert_allclose(camera.position, begun)
    first = camera.position
    camera._state.image_width = 300
    viewpoint.fit(PageArea(300.0, 900.0))
    second = camera.position
    assert not np.allclose(first, second)
    camera._state.position = first  # what the page told before it heard of the second
    viewpoint.fit(PageArea(300.0, 900.0))
    np.testing.assert_allclose(camera.position, second)

    viewpoint.take(View((1.0, -9.0, 2.0), (3.0, 3.0, 3.0), (0.0, 0.0, 1.0)))
    camera._state.position = second
    camera._state.image_width = 900
    viewpoint.fit(PageArea(900.0, 900.0))
    np.testing.assert_allclose(camera.position, second)  # nothing was sent


def test_a_view_that_is_brought_back_stays_also_where_the_page_has_it_already() -> None:
    camera = camera_at(USUAL)
    camera._state.fov = math.radians(75)
    camera._state.image_width, camera._state.image_height = 900, 900
    viewpoint = Viewpoint(camera, load_scene("drag-a-box"))
    viewpoint.take(USUAL)
    camera._state.image_width = 300
    viewpoint.fit(PageArea(300.0, 900.0))
    np.testing.assert_allclose(camera.position, USUAL.position)


def test_what_the_page_remembers_is_no_hand_and_any_widget_is(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    until(lambda: session.resting and not session._worker.is_woken())
    session._view._faced = session.plan
    before = session._memory._read
    fake.set(session._memory._box, '{"student": "a"}')
    until(lambda: session._memory._read != before and session.resting)
    assert session._view._faced is session.plan
    fake.set(session.panels.layer_switches.dark, True)
    until(lambda: session._view._faced is None)


def _goal(session: Session) -> Any:
    return session.panels.ends.gizmos["goal"]


def _sees_all(session: Session) -> bool:
    assert session.plan is not None
    camera = session.client.camera
    window = Window(camera.fov, camera.aspect)
    return holds(extent(session.plan), camera.position, camera.look_at, window)


class Page:
    """Client of a camera, which sends nothing."""

    @property
    def _websock_connection(self) -> Page:
        return self

    def queue_message(self, message: object) -> None:
        """Drop it."""


def camera_at(view: View) -> viser.CameraHandle:
    """Camera of a page that stands where the view says."""
    camera = viser.CameraHandle(cast(viser.ClientHandle, Page()))
    state = camera._state
    state.position, state.look_at, state.up_direction = map(
        np.array, (view.position, view.target, view.up)
    )
    state.wxyz, state.update_timestamp = np.array([1.0, 0.0, 0.0, 0.0]), time.time()
    return camera


_PLACES = st.floats(-1e8, 1e8) | st.sampled_from([0.0, 1.0, 3.0, 1e8, -1e8, 1e-7, 1e-300, 1e-320])
_PARTS = st.floats(-1e6, 1e6) | st.sampled_from([0.0, 1.0, 1e-6, 1e-300, 1e-320])
_VIEWS = st.tuples(*[_PLACES] * 6, *[_PARTS] * 3).map(View.of)
USUAL = View((3.0, -3.0, 4.0), (3.0, 3.0, 3.0), (0.0, 0.0, 1.0))


@given(_VIEWS, _VIEWS)
def test_every_view_that_is_kept_can_be_shown_from_wherever_one_looks(
    view: View | None, before: View | None
) -> None:
    assume(view is not None)
    assert view is not None
    camera = camera_at(before or USUAL)
    view.show(camera)
    shown = View.of_camera(camera)
    assert shown is not None
    np.testing.assert_allclose(shown.position, view.position, rtol=1e-5, atol=1e-7)
    assert np.isfinite(camera.wxyz).all()
    assert np.linalg.norm(camera.wxyz) == pytest.approx(1)


@pytest.mark.parametrize(
    "numbers",
    [
        None,
        "nine",
        [1.0] * 8,
        [1e30, 0, 0, 0, 0, 0, 0, 0, 1],
        [1e-300, 0, 0, 0, 0, 0, 0, 0, 1],
        [3, 3, 3, 0, 0, 0, 0, 0, 1e-320],
        [3, 3, 3, 0, 0, 0, 0, 0, 1e300],
        [3, 3, 3, 3, 3, 3, 0, 0, 1],
        [float("nan"), 3, 3, 0, 0, 0, 0, 0, 1],
        [10**400, 3, 3, 0, 0, 0, 0, 0, 1],
    ],
)
def test_a_view_of_nothing_is_none(numbers: object) -> None:
    assert View.of(numbers) is None
