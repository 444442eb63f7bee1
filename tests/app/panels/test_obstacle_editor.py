"""Obstacles, points and scenes by number, driven through the wire, without a browser."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import viser

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.primitives import PRIMITIVES
from abi.scene.scene import Scene, load_scene
from abi.scene.scene_file import dump
from app.layers.arm.arm import ArmLayer
from app.layers.result.plots import PlotsLayer
from app.server.server import start
from app.state.appearance import PLAIN
from app.state.named_obstacles import numbers_of
from app.tab.session import Session
from tests.abi import meshes
from tests.app.fake_tab import FakeTab, layer, notified, open_plots, opened, send_file, until

MILLIMETRES = {
    "version": 1,
    "unit": "mm",
    "workspace": {"min": [0, 0, 0], "max": [60, 60, 60]},
    "start": [0, 0, 0],
    "goal": [60, 60, 60],
    "obstacles": [{"shape": "sphere", "radius": 9, "position": [30, 30, 30]}],
    "mesh": {"pitch": 12},
    "arm": {"base": [30, -30, 0], "a1": 10, "a2": 20, "a3": 60, "a4": 30, "a5": 25},
}


@contextmanager
def served(path: Path) -> Iterator[tuple[FakeTab, Session]]:
    """A tab on a scene file."""
    running = start(port=0, scene=str(path), look=PLAIN)
    # what measures a mesh may have to be compiled first
    fake, session = opened(running, patience=90)
    yield fake, session
    fake.close()
    until(lambda: not running.sessions)
    running.stop()


def shows(session: Session, scene: Scene) -> bool:
    """Check whether the tab has planned ``scene``, and nothing waits."""
    return session.plan is not None and session.plan.scene == scene and session.resting


def boxes(session: Session) -> dict[str, list[float]]:
    editor = session.panels.editor
    numbers = {name: box.handle.value for name, box in editor._end_boxes.items()}
    numbers |= {"position": editor._position.handle.value, "turned": editor._angles.handle.value}
    return {name: list(value) for name, value in numbers.items()}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two-boxes", "forest", "no-way"])
def test_another_scene_is_in_the_numbers(tab: tuple[FakeTab, Session], name: str) -> None:
    fake, session = tab
    scene = load_scene(name)
    fake.set(session.panels.editor._end_boxes["start"].handle, [0.5, 0.25, 0.0])
    until(lambda: session.plan.scene.start == (0.5, 0.25, 0.0))  # type: ignore[union-attr]
    fake.set(session.panels.files.choice, name)
    until(lambda: shows(session, scene))

    assert len(session.panels.editor.choice.options) == len(scene.obstacles)
    shown = boxes(session)
    np.testing.assert_allclose(shown["start"], scene.start, atol=1e-3)
    np.testing.assert_allclose(shown["goal"], scene.goal, atol=1e-3)
    np.testing.assert_allclose(shown["position"], scene.obstacles[0].position, atol=1e-3)

    # one typed number moves one thing, along one axis
    x, y, z = scene.start
    fake.set(session.panels.editor._end_boxes["start"].handle, [x + 0.125, *shown["start"][1:]])
    until(lambda: shows(session, scene.replace(start=(x + 0.125, y, z))))


@pytest.mark.parametrize("kind", PRIMITIVES)
def test_each_shape_is_added_with_a_body_and_a_box_for_every_size(
    tab: tuple[FakeTab, Session], kind: str
) -> None:
    fake, session = tab
    editor = session.panels.editor
    count = len(session.frame.plan.scene.obstacles)
    fake.set(editor.kind, kind)
    fake.set(editor.buttons, "Add")
    until(lambda: session.resting and len(session.frame.plan.scene.obstacles) == count + 1)
    added = session.frame.plan.scene.obstacles[-1]
    assert added.shape == kind
    assert editor._obstacles.shown[-1].body is not None
    sizes = set(type(added).model_fields) - {"shape", "position", "wxyz"}
    shown = {name for name in ("size", "radius", "height") if getattr(editor.sizes, name).visible}
    assert shown == sizes


@pytest.mark.slow
def test_contacts_are_with_the_same_obstacles_after_one_is_deleted(tmp_path: Path) -> None:
    path = tmp_path / "contacts.yaml"
    asked = [["forearm_link", 2], ["forearm_link", 1], ["upper_arm_link", 0]]
    arm = {"avoid": False, "allowed": asked}
    load_scene("kitchen-ur5e").replace(arm=arm, mesh={"pitch": 0.2}).save(path)
    with served(path) as (fake, session):
        until(lambda: session.resting)
        before = session.frame.plan.scene
        session.panels.obstacles.point_out(1)
        fake.set(session.panels.editor.buttons, "Delete")
        until(lambda: session.resting and len(session.frame.plan.scene.obstacles) == 3)
        after = session.frame.plan.scene
        assert after.arm.allowed == (("forearm_link", 1), ("upper_arm_link", 0))
        assert after.obstacles[1] == before.obstacles[2]
        fake.set(session.panels.history.undo, True)
        until(lambda: session.resting and session.frame.plan.scene == before)


def test_without_obstacles_there_is_nothing_to_edit(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    editor = session.panels.editor
    fake.set(editor.buttons, "Delete")
    until(lambda: session.plan.scene.obstacles == ())  # type: ignore[union-attr]
    assert editor._position.handle.disabled
    assert editor._angles.handle.disabled
    assert not editor.sizes.size.visible

    fake.set(editor.buttons, "Add")
    until(lambda: len(session.plan.scene.obstacles) == 1)  # type: ignore[union-attr]
    assert not editor._position.handle.disabled
    assert not editor._angles.handle.disabled
    np.testing.assert_allclose(boxes(session)["position"], (3, 3, 4.5))
    np.testing.assert_allclose(session.panels.obstacles.gizmos[0].position, (3, 3, 4.5))


def test_while_a_number_is_wrong_the_rest_goes_on(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    sent: list[tuple[str, bytes]] = []

    def keep(name: str, content: bytes, save_immediately: bool) -> None:
        sent.append((name, content))

    monkeypatch.setattr(session.client, "send_file_download", keep)
    good = session.plan
    fake.set(session.panels.stages.fields["motion.speed"], 0.0)
    shown = session.panels.layout.overlay.shown
    until(lambda: "The cruise speed must be above 0; it is 0." in shown["message"])

    fake.set(session.panels.layer_switches.boxes["arm"], False)
    until(lambda: not layer(session, ArmLayer)._nodes.root.visible)
    fake.set(session.panels.files.save, True)
    until(lambda: len(sent) == 1)
    assert good is not None
    assert sent[0] == ("paper.yaml", dump(good.scene.to_dict(), "scene.yaml").encode())

    fake.set(session.panels.stages.fields["motion.speed"], 2.0)
    until(lambda: session.plan.scene.motion.speed == 2.0)  # type: ignore[union-attr]
    assert len(sent) == 1


@pytest.mark.slow
def test_a_wrong_number_is_told_of_until_it_is_mended(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    shown = session.panels.layout.overlay.shown
    until(lambda: session.resting)
    fake.set(session.panels.stages.fields["motion.speed"], 0.0)
    until(lambda: "The cruise speed must be" in shown["message"])

    # at rest the good scene is planned in full, where that had to wait
    plans = session.plans
    session.frame = replace(session.frame, plan=replace(session.frame.plan, partial=True))
    until(lambda: session.plans > plans and session.resting)
    assert "The cruise speed must be" in shown["message"]
    assert session.frame.refused is not None

    fake.set(session.panels.stages.fields["motion.speed"], 4.0)
    until(lambda: "✗" not in shown["message"] and session.frame.current)


def test_an_obstacle_that_is_refused_stays_and_all_others_follow(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    editor, obstacles = session.panels.editor, session.panels.obstacles
    fake.set(editor.buttons, "Add")
    until(lambda: session.resting and len(session.frame.plan.scene.obstacles) == 2)
    fake.set(editor.choice, editor.choice.options[0])
    until(lambda: session.resting and obstacles.chosen == 0)
    before = session.frame.plan.scene.obstacles
    fake.set(editor.sizes.size, (2.0, -1.0, 2.0))
    shown = session.panels.layout.overlay.shown
    until(lambda: "must be above 0" in shown["message"])
    message = shown["message"]
    assert "The size of obstacle 1 must be above 0; it is −1." in message
    assert "Still using 2; other changes take effect." in message
    assert session.frame.plan.scene.obstacles == before

    # the other one is dragged, and then itself
    fake.drag(obstacles.gizmos[1], [1.0, 4.0, 5.0])
    until(lambda: _places(session)[1:] == [(1.0, 4.0, 5.0)])
    fake.drag(obstacles.gizmos[0], [4.0, 3.0, 3.0])
    until(lambda: _places(session)[0] == (4.0, 3.0, 3.0))
    assert session.frame.refused is not None
    assert _sizes(session)[0] == [2.0, 2.0, 2.0]

    # others come with their bodies, and go
    fake.set(editor.buttons, "Add")
    until(lambda: len(_places(session)) == 3 and obstacles.shown[2].body is not None)
    fake.set(editor.buttons, "Delete")
    until(lambda: len(_places(session)) == 2)
    assert session.frame.refused is not None

    fake.set(editor.choice, editor.choice.options[0])
    until(lambda: editor.sizes.size.value == (2.0, -1.0, 2.0))
    fake.set(editor.sizes.size, (2.0, 1.0, 2.0))
    until(lambda: session.frame.refused is None and _sizes(session)[0] == [2.0, 1.0, 2.0])
    assert obstacles.shown[0].drawn == obstacles.shown[0].data


def _places(session: Session) -> list[tuple[float, ...]]:
    return [obstacle.position for obstacle in session.frame.plan.scene.obstacles]


def _sizes(session: Session) -> list[list[float]]:
    return [one.model_dump(mode="json")["size"] for one in session.frame.plan.scene.obstacles]


def test_a_point_that_is_too_far_stops_no_obstacle(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.editor._end_boxes["goal"].handle, (6.0, 6.0, 1e9))
    until(lambda: session.frame.refused is not None)
    fake.drag(session.panels.obstacles.gizmos[0], [4.0, 3.0, 3.0])
    until(lambda: _places(session) == [(4.0, 3.0, 3.0)])
    assert session.frame.refused is not None
    assert session.frame.plan.scene.goal == (6.0, 6.0, 6.0)
    shown = session.panels.layout.overlay.shown
    assert "Still using (6, 6, 6)" in shown["message"]


@pytest.mark.slow
def test_the_arm_is_as_large_as_the_scenes_unit_says(tmp_path: Path) -> None:
    path = tmp_path / "mm.yaml"
    Scene.from_dict(MILLIMETRES).save(path)

    def size(session: Session) -> float:
        """Size of the drawn arm over that of the workspace."""
        assert session.plan is not None
        offsets = [
            float(np.linalg.norm(node.frame.position))
            for node in layer(session, ArmLayer)._nodes.joint_nodes
        ]
        return sum(offsets) / max(session.plan.scene.workspace.size)

    with served(path) as (fake, session):
        until(lambda: len(layer(session, ArmLayer)._nodes.joint_nodes) > 0)
        same = size(session)
        editor = session.panels.editor
        lengths = (editor._position.handle, editor.sizes.radius, editor._end_boxes["goal"].handle)
        assert {handle.label[-4:] for handle in lengths} == {"[mm]"}
        # the same arm in the same room, ten times as many of a unit a tenth as long
        for name in ("paper", str(path)):
            fake.set(session.panels.files.choice, name)
            scene = load_scene(name)
            until(lambda scene=scene: shows(session, scene))  # type: ignore[misc]
            until(lambda: size(session) == pytest.approx(same, rel=1e-6))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"workspace: [1, 2]", "workspace is [1, 2]; expected the fields min, max."),
        (
            b"obstacles: [{shape: mesh, file: nut.glb, position: [3, 3, 3]}]",
            "obstacles[0].file is 'nut.glb'; expected it to be added here first (Add a mesh), or "
            "to be in one zip with the scene.",
        ),
    ],
    ids=["no scene", "without its mesh"],
)
def test_a_file_that_is_no_scene_is_named_and_changes_nothing(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch, content: bytes, reason: str
) -> None:
    _, session = tab
    notices = notified(monkeypatch, session)
    good = session.plan
    send_file(session, session.panels.files.upload, "my scene.yaml", b"version: 1\n" + content)
    until(lambda: bool(notices))

    assert notices == [("my scene.yaml is not opened", reason)]
    assert session.plan is good
    assert session.frame.current
    assert "✗" not in session.panels.layout.overlay.shown["message"]


def test_what_is_not_listed_is_not_opened(tab: tuple[FakeTab, Session], tmp_path: Path) -> None:
    fake, session = tab
    path = tmp_path / "other.yaml"
    Scene.from_dict(MILLIMETRES).save(path)
    fake.set(session.panels.files.choice, str(path))
    fake.set(session.panels.stages.fields["spline.degree"], 3)
    until(lambda: session.plan.scene.spline.degree == 3)  # type: ignore[union-attr]
    assert session.plan is not None
    assert session.plan.scene == load_scene("paper").replace(spline={"degree": 3})


@pytest.mark.slow
def test_a_mesh_shrinks_about_its_middle(tmp_path: Path) -> None:
    vertices, faces = meshes.box((2.0, 2.0, 2.0))
    vertices = vertices - vertices.min(axis=0)  # a corner at the file's origin, as from CAD
    (tmp_path / "part.stl").write_bytes(meshes.stl((vertices, faces)))
    obstacle = {"shape": "mesh", "file": "part.stl", "unit": "cm", "position": [2, 2, 2]}
    turned = {**obstacle, "wxyz": [1.0, 0.0, 0.0, 1.0]}
    path = tmp_path / "part.yaml"
    path.write_text(dump({"version": 1, "obstacles": [turned]}, path.name), encoding="utf-8")
    with served(path) as (fake, session):
        for widget, value, factor in (("unit", "mm", 0.1), ("scale", 0.5, 0.5)):
            assert session.plan is not None
            before = session.plan.scene.obstacles[0].bounds()
            fake.set(getattr(session.panels.editor.sizes, widget), value)
            until(lambda: session.plan.scene.obstacles[0].bounds()[1][0] != before[1][0])  # type: ignore[union-attr]  # noqa: B023
            after = session.plan.scene.obstacles[0].bounds()
            np.testing.assert_allclose(np.add(*after), np.add(*before), atol=1e-9)
            np.testing.assert_allclose(
                np.subtract(*after), factor * np.subtract(*before), atol=1e-6
            )


@pytest.mark.slow
def test_a_fitted_mesh_fits_in_any_unit_of_its_file(tmp_path: Path) -> None:
    (tmp_path / "part.stl").write_bytes(meshes.stl(meshes.box((95.0, 40.0, 40.0))))
    obstacle = {"shape": "mesh", "file": "part.stl", "scale": 0.0211, "position": [3, 3, 3]}
    path = tmp_path / "part.yaml"
    path.write_text(dump({"version": 1, "obstacles": [obstacle]}, path.name), encoding="utf-8")
    with served(path) as (fake, session):
        for unit, scale in (("mm", 0.211), ("m", 2.11e-4)):
            fake.set(session.panels.editor.sizes.unit, unit)
            until(lambda: session.plan.scene.obstacles[0].unit == unit)  # type: ignore[union-attr]  # noqa: B023
            mesh = session.plan.scene.obstacles[0]  # type: ignore[union-attr]
            assert isinstance(mesh, MeshShape)
            assert mesh.scale == session.panels.editor.sizes.scale.value == scale
            assert np.ptp(mesh.bounds(), axis=0).max() == pytest.approx(2.0, rel=5e-3)


@pytest.mark.slow
def test_plots_are_there_when_there_is_motion(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    plots: list[viser.GuiUplotHandle] = list(layer(session, PlotsLayer)._plots.values())
    until(lambda: session.resting)
    assert [plot.visible for plot in plots] == [True] + 5 * [False]
    open_plots(fake, session)
    until(lambda: all(plot.visible for plot in plots))
    fake.set(session.panels.files.choice, "no-way")
    until(lambda: not any(plot.visible for plot in plots))
    fake.set(session.panels.files.choice, "paper")
    until(lambda: all(plot.visible for plot in plots))
    # also around the joint that does not move there is a scale
    until(lambda: all(np.ptp(np.concatenate(plot.data[1:])) > 0 for plot in plots))


def _numbered(session: Session) -> set[int]:
    return {k for k, one in enumerate(session.panels.obstacles.shown) if one.label.visible}


@pytest.mark.slow
def test_of_very_many_obstacles_those_that_a_message_names_are_numbered(tmp_path: Path) -> None:
    balls = [
        {"shape": "sphere", "radius": 0.1, "position": [0.5 + x, 5.5 - 0.1 * y, 0.5 + y]}
        for x in range(6)
        for y in range(6)
    ]
    balls += [{"shape": "sphere", "radius": 0.1, "position": [5.5, 0.3, z]} for z in range(1, 7)]
    path = tmp_path / "many.yaml"
    Scene.from_dict({"version": 1, "obstacles": balls, "mesh": {"pitch": 0.8}}).save(path)
    with served(path) as (fake, session):
        until(lambda: session.resting)
        # one into which the start is put
        fake.set(session.panels.editor._end_boxes["start"].handle, [5.5, 0.3, 3.0])
        until(lambda: session.frame.reason is not None)
        reason = session.frame.reason
        assert reason is not None
        assert "obstacle 39" in reason.message
        assert 38 in _numbered(session)
        assert len(_numbered(session)) < 10
        fake.set(session.panels.history.undo, True)
        until(lambda: session.resting and session.frame.plan.error is None)
        assert 38 not in _numbered(session)


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("cuts 0.2 cm into obstacle 7 ✗", [6]),
        ("The arm touches obstacles 1, 2 and 5, and the floor.", [0, 1, 4]),
        ("Without obstacles 3–5 there is a motion.", [2, 3, 4]),
        ("Without obstacles 1, 12 and 30 more there is one.", [0, 11]),
        ("the forearm comes nearest to obstacle 1 at 1.25 s; obstacle 20, by 3 cm", [0, 19]),
        ("Every link keeps 0.1 cm from the obstacles; 4 of 5", []),
    ],
)
def test_the_numbers_of_a_sentence_are_found(text: str, numbers: list[int]) -> None:
    assert numbers_of(text) == numbers


def test_a_click_on_an_obstacle_means_a_node_behind_it_while_a_search_is_stepped_through(
    tab: tuple[FakeTab, Session],
) -> None:
    _, session = tab
    until(lambda: session.resting)
    gizmos = session.panels.obstacles
    clicked: Any = SimpleNamespace(target=gizmos.shown[0].body, client=session.client)
    for searching in (True, False):
        gizmos._faded, gizmos._touched = searching, False
        gizmos._choose_clicked(clicked)
        assert gizmos._touched == (not searching)
