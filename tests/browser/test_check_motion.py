"""A motion from elsewhere on the page: its time bar, its repair, a drag, and the saved verdict."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from abi.certification.verdict import MotionVerdict
from abi.verify.verify import verify
from app.tab.session import Session
from tests.browser import drawn
from tests.browser.page import Page

JOINTS = (
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
)
ROWS = ("0,-1,-1.2,1.2,-1.2,-1.57,0", "3,3,-1.2,1.2,-1.2,-1.57,0")


def _verdict(page: Page, session: Session, state: str) -> MotionVerdict:
    """The verdict that the page shows, once it is of that kind."""
    page.until(lambda: session.frame.checked is not None, "a verdict")
    page.until(lambda: session.frame.checked.state == state, state)  # type: ignore[union-attr]
    verdict = session.frame.checked
    assert verdict is not None
    page.reads(verdict.sentence)
    return verdict


def test_a_motion_is_checked_repaired_and_saved(page: Page, session: Session) -> None:
    page.click("Scene")
    page.choose("scene", "kitchen-ur5e")
    page.until(lambda: session.frame.plan.scene.arm.model == "urdf", "the robot")
    page.click("Plots")
    page.upload(
        "Check a motion…", "swing.csv", "\n".join((",".join(("time", *JOINTS)), *ROWS)).encode()
    )
    found = _verdict(page, session, "touches")
    marks = page.tab.locator("#abi-overlay [style*=linear-gradient]")
    assert marks.count() > 0
    page.reads("touching")
    assert page.tab.locator("canvas").count() > 1, "no plot"
    page.set_time(found.touches[0].first)

    page.click("Repair")
    _verdict(page, session, "clear")
    page.reads("Repaired from")

    with page.tab.expect_download() as download:
        page.click("Save the verdict")
    saved = json.loads(Path(download.value.path()).read_text())
    assert saved["verdict"] == "clear"
    (proof,) = verify(saved)
    assert proof.proven, proof.reason

    page.close_notices()  # of what was saved
    gizmo = drawn.obstacles(page)[-1]
    old = np.array(page.position(gizmo))
    page.drag_arrow(gizmo, 2, 0.3)
    page.until(
        lambda: (
            session.frame.checked is not None
            and np.allclose(
                session.frame.checked.scene.obstacles[-1].position, page.position(gizmo), atol=1e-5
            )
        ),
        "the verdict where the obstacle is now",
    )
    assert not np.allclose(old, page.position(gizmo))
    page.click("Back to your own plan")
    page.until(lambda: session.frame.checked is None, "the tab's own plan")
    page.until(lambda: drawn.shows(page, session.plan), "the tab's own curve")
    page.click("Scene")
    page.choose("scene", "paper")
    page.until(lambda: drawn.shows(page, session.plan), "the first scene")
