"""Another choice ends the plan of the last one: how soon, as a real tab has it.

    python -m benchmarks.choices --times 30

A tab plans a shipped scene with a mesh so fine that it takes seconds. At a random moment of that
another scene or arm is chosen in the page. Measured is the time from there, the page's way to the
server included, until the plan has ended, or until that of what was chosen begins. On a busy
machine that also has the time for which others compute; the processor time between two places
where a plan asks whether it is still wanted has not.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import sys
import time
from contextlib import AbstractContextManager
from typing import Any

from playwright.sync_api import Browser

import abi
from abi.scene.scene import load_scene
from app.server.server import start
from app.state.appearance import PLAIN
from app.tab.planner import TabPlanner
from app.tab.session import Session
from app.ui import page as functions
from benchmarks.browser import chromium
from tests.browser.page import Page

_SLOW = {"sculpture": 0.1, "kitchen-ur5e": 0.025, "forest": 0.15, "paper": 0.08}
"""Scenes, and spacings of their meshes with which they take seconds, [unit]."""
_LONGEST = 2.0
"""Seconds that the plan is under way when something else is chosen, at most."""
_PATIENCE = 300.0
_SEND = "([uuid, value]) => abi.send(uuid, value)"


class Gaps:
    """The processor time between two questions of plans whether they are still wanted.

    Attributes:
        longest: the longest so far, [s].
    """

    def __init__(self, planner: TabPlanner) -> None:
        """Note when the plans of a tab ask."""
        self.longest = 0.0
        self._last = math.inf
        self._begins = planner._watched
        self._asks, self._tells = planner._is_cancelled, planner._told
        planner._watched, planner._is_cancelled, planner._told = (  # type: ignore[method-assign]
            self._begin,
            self._ask,
            self._tell,
        )

    def _begin(self) -> AbstractContextManager[None]:
        self._last = time.thread_time()
        return self._begins()

    def _ask(self) -> bool:
        self.longest = max(self.longest, time.thread_time() - self._last)
        answer = self._asks()
        self._last = time.thread_time()  # what is drawn meanwhile is no part of the plan
        return answer

    def _tell(self, doing: str) -> None:
        self._tells(doing)
        self._last = time.thread_time()


class Chooser:
    """A tab in which one thing after the other is chosen."""

    def __init__(self, page: Page, session: Session) -> None:
        self._page, self._session = page, session

    def interrupt(self, scene: str, pitch: float, wait: float, arm: str) -> float | None:
        """Time until another choice has ended the plan of a fine mesh, [s]; None without one.

        Args:
            scene: whose mesh is made fine.
            pitch: of the fine mesh, [unit].
            wait: from the begin of the plan to the other choice, [s].
            arm: that is chosen instead; empty for another scene.
        """
        session, panels = self._session, self._session.panels
        if panels.files.name != scene:
            self._set(panels.files.choice, scene)
            self._shows(scene)
        begun = session._planner._begun
        self._set(panels.stages.fields["mesh.pitch"], pitch)
        self._until(lambda: session._planner._begun > begun)
        self._page.tab.wait_for_timeout(1e3 * wait)
        took = None if session.resting else self._choose(arm)
        self._set(panels.files.choice, "two-boxes")
        self._shows("two-boxes")
        return took

    def _choose(self, arm: str) -> float:
        """Choose an arm, or without one another scene; time until the plan has ended, [s]."""
        session, panels = self._session, self._session.panels
        chosen = time.monotonic()
        if arm:
            self._set(panels.stages.arm.model.model, arm)
        else:
            self._set(panels.files.choice, "two-boxes")
        planner = session._planner
        self._until(lambda: max(planner.ended, planner._begun) > chosen)
        return min(moment for moment in (planner.ended, planner._begun) if moment > chosen) - chosen

    def _shows(self, scene: str) -> None:
        """Wait until a scene is drawn: its name is there before it, and what is set then is lost.

        It is told from the one before by the number of its obstacles.
        """
        session, count = self._session, len(load_scene(scene).obstacles)
        self._until(lambda: session.resting and len(session.frame.plan.scene.obstacles) == count)

    def _set(self, widget: Any, value: object) -> None:
        self._page.tab.evaluate(_SEND, [functions.uuid(widget), value])

    def _until(self, condition: Any) -> None:
        self._page.until(condition, "the tab", _PATIENCE)


def measure(browser: Browser, times: int, seed: int = 0) -> dict[str, Any]:
    """Interrupt plans.

    Returns:
        The number of ``cancelled`` ones; ``median_s``, ``worst_s`` and ``worst_scene`` of the times
        until they ended; ``gap_s``, the longest processor time between two questions of a plan; and
        ``load``, the mean number of processes that ran or waited in the last minute.
    """
    abi.compile()
    server = start(port=0, scene="two-boxes", look=PLAIN)
    page = Page(browser, server.url)
    chance, took, worst = random.Random(seed), list[float](), ""
    try:
        page.until(lambda: any(one.plans for one in server.sessions.values()), "a session")
        (session,) = server.sessions.values()
        chooser, gaps = Chooser(page, session), Gaps(session._planner)
        for _ in range(times):
            scene = chance.choice(list(_SLOW))
            arm = chance.choice(("", "", "xArm7"))
            found = chooser.interrupt(scene, _SLOW[scene], chance.uniform(0, _LONGEST), arm)
            if found is not None:
                took.append(found)
                print(f"{scene} {arm or 'another scene'}: {found:.3f} s", file=sys.stderr)
                worst = scene if found == max(took) else worst
    finally:
        page.close()
        server.stop()
    took.sort()
    return {
        "cancelled": len(took),
        "median_s": took[len(took) // 2],
        "worst_s": took[-1],
        "worst_scene": worst,
        "gap_s": gaps.longest,
        "load": os.getloadavg()[0],
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with chromium() as browser:
        print(json.dumps(measure(browser, options.times, options.seed)), flush=True)


if __name__ == "__main__":
    main()
