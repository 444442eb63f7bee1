from __future__ import annotations

import numpy as np
import pytest

from app.session import Session
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


def test_in_a_lecture_the_scene_stands_higher(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    camera, lecture = session.client.camera, session.panels.lecture
    before, away = camera.look_at, camera.position - camera.look_at
    fake.set(lecture.toggle, True)
    until(lambda: lecture.on and camera.look_at[2] < before[2])
    # moved only, not turned
    np.testing.assert_allclose(camera.position - camera.look_at, away)
    fake.set(lecture.toggle, True)
    until(lambda: not lecture.on and camera.look_at == pytest.approx(before))
