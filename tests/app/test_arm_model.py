"""Another arm in a tab: chosen, drawn, uploaded, refused."""

from __future__ import annotations

import numpy as np
import pytest

from abi.arm.arm import Arm
from abi.arm.urdf_arm import UrdfArm
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.robot_files import robot_from_archive
from abi.scene.scene import Scene, load_scene
from app.layers.urdf_arm import UrdfArmLayer, link_mesh
from app.panels.arm import ArmPanel
from app.session import Session
from tests.abi.robot.robots import arm, packed
from tests.abi.robot.test_visuals import dae, looking
from tests.app.fake_tab import FakeTab, layer, send_file, until


def panel(session: Session) -> ArmPanel:
    return session.panels.stages.arm


def planned_arm(session: Session) -> object:
    return None if session.plan is None else session.plan.arm


def upload(session: Session, name: str, content: bytes) -> None:
    """What viser does with an uploaded file."""
    send_file(session, panel(session).model.upload, name, content)


@pytest.mark.slow
def test_an_arm_is_chosen_drawn_and_left(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: isinstance(planned_arm(session), UrdfArm))
    until(lambda: session.resting)
    drawn = layer(session, UrdfArmLayer)

    assert session.plan is not None
    assert session.plan.scene == load_scene("kitchen-ur5e")
    assert session.panels.read(session.plan.scene) == session.plan.scene
    assert panel(session).model.model.value == "UR5e"
    assert panel(session).model.tip.value == "tool0"
    assert panel(session).model.axis.value == "down"
    assert not panel(session).links.visible
    assert drawn._root.visible
    assert len(drawn._frames) == 7

    fake.set(panel(session).model.model, "xArm7")
    until(lambda: session.plan is not None and session.plan.scene.arm.urdf == "xarm7")
    until(lambda: len(drawn._frames) == 8)
    assert panel(session).model.tip.value == "link_eef"

    fake.set(panel(session).model.model, "the paper's arm")
    until(lambda: isinstance(planned_arm(session), Arm))
    until(lambda: not drawn._root.visible)
    assert panel(session).links.visible


@pytest.mark.slow
def test_an_upload_is_an_arm_or_a_sentence(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, session = tab
    told: list[str] = []
    monkeypatch.setattr(
        session.client, "add_notification", lambda title, body, **_: told.append(body)
    )
    upload(session, "bad.zip", b"PK\x03\x04")
    until(lambda: any("zip" in sentence for sentence in told))
    assert isinstance(planned_arm(session), Arm)

    upload(session, "own arm.zip", packed({"x/own.urdf": arm()}))
    until(lambda: isinstance(planned_arm(session), UrdfArm))
    assert session.plan is not None
    assert session.plan.scene.arm.urdf == "own arm.zip"
    assert panel(session).model.tip.value == "d"

    damaged = packed({"own.urdf": looking("a.dae"), "a.dae": b"<COLLADA>"})
    upload(session, "damaged.zip", damaged)
    until(lambda: any("visuals cannot be read: a." in sentence for sentence in told))

    upload(session, "plain.urdf", arm().encode())
    until(lambda: session.plan is not None and session.plan.scene.arm.urdf == "plain.zip")
    fake.set(panel(session).model.tip, "c")
    until(lambda: session.plan is not None and session.plan.scene.arm.tip == "c")


@pytest.mark.slow
def test_a_scene_that_is_opened_tells_what_is_left_out_of_its_arm(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, session = tab
    told: list[str] = []
    monkeypatch.setattr(
        session.client, "add_notification", lambda title, body, **_: told.append(body)
    )
    damaged = packed({"own.urdf": looking("a.dae"), "a.dae": b"<COLLADA>"})
    data = {"version": 1, "arm": {"model": "urdf", "urdf": "damaged.zip"}}
    scene = Scene.from_dict(data, MeshSource({"damaged.zip": damaged}))
    until(lambda: session.resting)
    for _ in range(2):  # once for an arm
        panel(session).model.write(scene)
        assert told == ["Drawn by collision shapes, as visuals cannot be read: a."]


def test_a_link_is_drawn_with_the_triangles_of_its_visual() -> None:
    robot = robot_from_archive(packed({"r.urdf": looking("a.dae"), "a.dae": dae(0.3)}))
    meshes = [link_mesh(robot.links[name], np.eye(4), 100.0, (0, 0, 0)) for name in "ab"]

    assert [len(mesh.faces) for mesh in meshes] == [320, 12]
    np.testing.assert_allclose(meshes[0].bounds, [[-30, -28, -30], [30, 32, 30]], atol=1e-3)
