"""An uploaded mesh from when it is read until it is planned with, without a browser."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import viser

from abi.obstacles.mesh_shape import MeshShape
from app.tab.session import Session
from tests.abi import meshes
from tests.app.fake_tab import FakeTab, send_file, until

KNOT = meshes.stl(meshes.knot(800))


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Holds back the preparation of meshes until it is set."""
    event, prepare = threading.Event(), MeshShape.prepare

    def wait(shape: MeshShape) -> None:
        assert event.wait(60)
        prepare(shape)

    monkeypatch.setattr(MeshShape, "prepare", wait)
    return event


def upload(session: Session, name: str, content: bytes) -> None:
    handles = session.client.gui._gui_input_handle_from_uuid.values()
    (button,) = (
        handle
        for handle in handles
        if isinstance(handle, viser.GuiUploadButtonHandle) and handle.label.startswith("Add a mesh")
    )
    send_file(session, button, name, content)


@pytest.fixture
def arriving(tab: tuple[FakeTab, Session], held: threading.Event) -> tuple[FakeTab, Session]:
    """A tab with a mesh that is read, and drawn, but not prepared yet."""
    _, session = tab
    upload(session, "knot.stl", KNOT)
    until(lambda: session.panels.obstacles.foreseen is not None, patience=60)
    return tab


def is_added(session: Session) -> bool:
    assert session.plan is not None
    return len(session.plan.scene.obstacles) == 2 and session.resting


def test_a_mesh_is_drawn_and_planning_goes_on_while_it_is_prepared(
    arriving: tuple[FakeTab, Session], held: threading.Event
) -> None:
    fake, session = arriving
    obstacles = session.panels.obstacles
    foreseen = obstacles.foreseen
    assert foreseen is not None
    until(lambda: foreseen.body is not None)
    assert foreseen.body is not None
    faint = foreseen.body.opacity

    fake.set(session.panels.stages.fields["spline.degree"], 3)
    until(lambda: session.plan.scene.spline.degree == 3)  # type: ignore[union-attr]
    assert session.plan is not None
    assert len(session.plan.scene.obstacles) == 1
    assert obstacles.foreseen is foreseen

    held.set()
    until(lambda: is_added(session), patience=60)
    assert obstacles.foreseen is None
    # what is drawn already is not sent again
    assert obstacles.gizmos[1] is foreseen.gizmo
    assert obstacles.shown[1].body is foreseen.body
    assert faint is not None
    assert foreseen.body.opacity is not None
    assert foreseen.body.opacity > 2 * faint
    added = session.plan.scene.obstacles[1]
    assert isinstance(added, MeshShape)
    assert added.file == "knot.stl"
    np.testing.assert_array_equal(foreseen.gizmo.position, added.position)


def test_what_is_stopped_while_it_is_prepared_goes_at_once(
    arriving: tuple[FakeTab, Session], held: threading.Event
) -> None:
    fake, session = arriving
    obstacles, uploads = session.panels.obstacles, session.panels.editor.uploads
    assert uploads._stop.visible
    fake.set(uploads._stop, True)
    until(lambda: obstacles.foreseen is None)
    assert not uploads._stop.visible

    held.set()
    until(lambda: uploads._pending == 0)
    upload(session, "other.stl", KNOT)
    until(lambda: is_added(session), patience=60)
    assert session.plan is not None
    assert session.plan.scene.obstacles[1].model_dump()["file"] == "other.stl"


def test_another_scene_does_not_keep_what_is_not_added(
    arriving: tuple[FakeTab, Session], held: threading.Event
) -> None:
    fake, session = arriving
    obstacles = session.panels.obstacles
    fake.set(session.panels.files.choice, "no-way")
    until(lambda: session.plan is not None and session.plan.error is not None)
    assert obstacles.foreseen is None
    count = len(obstacles.gizmos)

    held.set()  # it comes all the same, as it would have a moment before
    until(lambda: len(obstacles.gizmos) == count + 1, patience=60)
