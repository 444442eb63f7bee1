"""A link between the eye and what one looks at fades, and the mouse reaches what is behind it."""

from __future__ import annotations

import numpy as np

from app.tab.session import Session
from tests.browser.page import Page

_OPACITIES = """() => Object.fromEntries(Object.entries(window.__viserMutable.nodeRefFromName)
  .filter(([name, node]) => node && name.startsWith("/arm/") && name.endsWith("/mesh"))
  .map(([name, node]) => {
    let opacity = 1;
    node.traverse(part => { if (part.isMesh) opacity = part.material.opacity; });
    return [name.split("/").at(-2), opacity];
  }))"""


def _faded(page: Page) -> set[str]:
    return {link for link, opacity in page.tab.evaluate(_OPACITIES).items() if opacity < 1}


def _has_moved(session: Session) -> bool:
    """Check whether the start is not the paper's any more."""
    assert session.plan is not None
    return not np.allclose(session.plan.scene.start, 0, atol=0.1)


def test_links_before_the_start_fade_and_leave_it_to_the_mouse(
    page: Page, session: Session
) -> None:
    page.set_time(0.0)
    camera, before = session.client.camera, session.client.camera.position
    # on the line from the start through the turret, beyond it
    with session.client.atomic():
        camera.position, camera.look_at = (7.0, -7.0, 4.0), (0.0, 0.0, 0.0)
    page.until(lambda: "turret" in _faded(page), "the turret to fade")
    page.settle()
    assert len(_faded(page)) < 7
    grip = page.pixel("/start")
    page.drag(grip, (grip[0] - 60, grip[1] - 90))
    page.until(lambda: session.resting and _has_moved(session), "the plan from another start")
    np.testing.assert_allclose(camera.position, (7.0, -7.0, 4.0), atol=1e-3)
    with session.client.atomic():
        camera.position, camera.look_at = before, (3.0, 1.5, 3.0)
    page.until(lambda: "turret" not in _faded(page), "the turret to be whole again")
