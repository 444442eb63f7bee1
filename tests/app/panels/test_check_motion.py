"""A motion from elsewhere on the page: its verdict takes the plan's place, and can be left."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.tab.session import Session
from tests.abi.certification.test_bags import POSITIONS, mcap, sqlite
from tests.app.fake_tab import FakeTab, notified, send_file, texts_in, until

pytestmark = pytest.mark.slow
JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)


def csv(*rows: tuple[float, ...]) -> bytes:
    lines = [",".join(("time", *JOINTS)), *(",".join(map(str, row)) for row in rows)]
    return "\n".join(lines).encode()


SWING = csv((0, 2.0, -1.6, 1.2, -1.2, -1.57, 0), (2, 0.8, -1.6, 1.2, -1.2, -1.57, 0))


def press(fake: FakeTab, button: Any) -> None:
    fake.set(button, True)


def test_a_verdict_is_shown_in_place_of_the_plan(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fake, session = tab
    check = session.panels.check
    told = notified(monkeypatch, session)
    send_file(session, check.upload, "swing.csv", SWING)
    until(lambda: bool(told))
    assert "Choose a robot" in told[-1][1]

    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: session.frame.plan.scene.arm.model == "urdf" and session.resting)
    own = session.frame.plan
    wrong = SWING.replace(b"\n2,0.8", b"\n2,80")
    send_file(session, check.upload, "wrong.csv", wrong)
    until(lambda: len(told) > 1)
    assert "row 2" in told[-1][1]
    assert "shoulder_pan_joint" in told[-1][1]
    assert "degrees" in told[-1][1]
    assert session.frame.checked is None

    send_file(session, check.upload, "swing.csv", SWING)
    until(lambda: session.frame.checked is not None)
    verdict, plan = session.frame.checked, session.frame.plan
    assert verdict is not None
    assert verdict.state == "touches"
    assert plan.motion is not None
    assert plan.motion.joints == JOINTS
    assert session.frame.duration == 2.0
    overlay = session.panels.layout.overlay.shown
    assert verdict.touches[0].link in overlay["message"]
    assert "touching" in overlay["message"]
    assert "linear-gradient" in overlay["marks"]

    layout = session.panels.layout
    until(lambda: "from elsewhere: 2.00" in "".join(texts_in(layout.result)))
    assert "straight in the joints" in "".join(texts_in(layout.folders["arm"]))

    send_file(session, check.upload, "two.mcap", mcap("/plan", "/other"))
    until(lambda: bool(check.uploads.choice.visible) or len(told) > 2)
    assert not told[2:], told
    assert session.frame.checked is verdict
    fake.set(check.uploads.choice, "/other")
    until(lambda: session.frame.checked is not verdict and session.resting)
    assert session.frame.checked is not None
    other = session.frame.checked.problem.motion.motion
    np.testing.assert_array_equal(other.positions, POSITIONS + 1)
    assert check.uploads.choice.visible

    (bag,) = sqlite(tmp_path / "bag").glob("*.db3")
    send_file(session, check.upload, "plan.db3", bag.read_bytes())
    until(lambda: not check.uploads.choice.visible and session.resting)
    until(lambda: session.frame.checked.problem.motion.motion.positions[0, 0] == POSITIONS[0, 0])

    over = csv((0, -1, -1.2, 1.2, -1.2, -1.57, 0), (3, 3, -1.2, 1.2, -1.2, -1.57, 0))
    send_file(session, check.upload, "over.csv", over)
    until(lambda: session.frame.duration == 3.0 and session.resting)
    assert session.frame.checked.state == "touches"
    press(fake, check.repair)
    until(lambda: session.frame.checked.state == "clear" and session.resting)
    assert "Repaired from 0 s to 3 s" in session.panels.layout.overlay.shown["message"]
    saved = list[bytes]()
    monkeypatch.setattr(
        session.client, "send_file_download", lambda name, content, **_: saved.append(content)
    )
    fake.set(check.save, True)
    until(lambda: bool(saved))
    assert json.loads(saved[0]) == json.loads(json.dumps(session.frame.checked.to_dict()))

    press(fake, check.back)
    until(lambda: session.frame.checked is None and session.resting)
    assert session.frame.plan.path is not None
    assert own.scene == session.frame.plan.scene
