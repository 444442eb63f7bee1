"""What stands in the page's scene stands where it is planned, in whatever order things are chosen.

    python -m benchmarks.poses --steps 300
    python -m benchmarks.poses --pairs

A real tab chooses scenes and arms at random, plays and pauses their motions, moves arms, undoes,
resets and reloads; or it chooses each scene and each arm right after each other one. After each
step the page itself is asked where every link of the arm, every obstacle and both ends are in the
world, which must be where the kinematics of the plan put them.
"""

from __future__ import annotations

import argparse
import io
import itertools
import json
import random
import sys
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import yourdfpy
from playwright.sync_api import Browser

import abi
from abi.arm_planning.motion.trajectory import rest_pose
from abi.arrays import FloatArray
from abi.obstacles.pose import rotation
from abi.planner.plan import Plan
from abi.robot.any_arm import AnyArm
from abi.robot.paper_arm.paper_arm import PaperArm, urdf
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import scene_names
from app.server.server import Server, start
from app.state.appearance import PLAIN
from app.tab.session import Session
from app.ui import page as functions
from benchmarks.browser import chromium
from tests.browser.page import Page

TOLERANCE = 1e-4
"""Error of a place, as a part of the workspace's size, and of an axis: single precision's."""
_PATIENCE = 30.0
"""Seconds in which a pose comes right that is on its way."""
_SEND = "([uuid, value]) => abi.send(uuid, value)"

Poses: TypeAlias = dict[str, FloatArray]
Step: TypeAlias = tuple[str, str]


def planned(plan: Plan, time: float) -> Poses:
    """Poses (4, 4) in the world, [unit], of the arm's nodes at a time [s], and of the ends."""
    scene, found = plan.scene, dict[str, FloatArray]()
    for name, place in (("/start", scene.start), ("/goal", scene.goal)):
        found[name] = _pose(np.eye(3), np.array(place, dtype=float))
    if plan.arm is not None:
        found |= _links(plan, plan.arm, time)
    return found


def _links(plan: Plan, arm: AnyArm, time: float) -> Poses:
    """The same of the arm's nodes."""
    positions = _positions(plan, arm, time)
    if isinstance(arm, UrdfArm):
        name, found = "/robot/base", dict[str, FloatArray]()
        for number, pose in enumerate(arm.chain.poses(positions[None] / arm.scales)[0][:-1]):
            name += f"/joint{number}"
            found[name] = _pose(pose[:, :3], pose[:, 3] / arm.metres)
        return found
    assert isinstance(arm, PaperArm)
    model = yourdfpy.URDF.load(io.BytesIO(urdf(arm, 1.0).encode()))
    model.update_cfg(positions)
    name, found, base = "/arm/links", dict[str, FloatArray](), _pose(np.eye(3), arm.base)
    for link in list(model.link_map)[1:]:
        name += f"/{link}"
        found[name] = base @ model.get_transform(link, model.base_link)
    return found


def _positions(plan: Plan, arm: AnyArm, time: float) -> FloatArray:
    """Joint positions (n,) in which the arm is to be drawn, [rad] and [unit]."""
    if plan.motion is not None:
        columns = plan.motion.positions.T
        return np.array([np.interp(time, plan.motion.time, column) for column in columns])
    if isinstance(arm, UrdfArm):
        return np.asarray(arm.first_poses(np.array(plan.scene.start))[0])
    assert isinstance(arm, PaperArm)
    return np.asarray(rest_pose(arm, plan.scene.arm, plan.scene.start))


def _pose(turn: FloatArray, place: FloatArray) -> FloatArray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, place
    return pose


def misplaced(page: Page, session: Session) -> str:
    """What is not where it is planned, in words; empty where all of it is, or within seconds."""
    told = ["nothing planned"]

    def is_right() -> bool:
        told[0] = _misplaced(page, session)
        return not told[0]

    try:
        page.until(is_right, "", _PATIENCE)
    except AssertionError:
        return told[0]
    return ""


def _misplaced(page: Page, session: Session) -> str:
    """The same at this moment."""
    plan = session.plan
    if plan is None or not session.resting:
        return "the plan is not complete"
    page.frames(2)
    wanted = planned(plan, session.frame.time)
    for gizmo, obstacle in zip(session.panels.obstacles.gizmos, plan.scene.obstacles, strict=True):
        place = np.array(obstacle.position, dtype=float)
        wanted[gizmo.name] = _pose(rotation(obstacle.wxyz), place)
    return differing(page, wanted, max(plan.scene.workspace.size))


def differing(page: Page, wanted: Poses, size: float) -> str:
    """What the page has elsewhere than ``wanted``, in words; ``size`` of the workspace, [unit]."""
    seen, shown = page.poses(), page.shown()
    for name, pose in wanted.items():
        if name not in seen:
            return f"{name} is not in the page"
        away = np.abs(seen[name][:3] - pose[:3])
        if away[:, 3].max() > TOLERANCE * size or away[:, :3].max() > TOLERANCE:
            return f"{name} is at {seen[name][:3].tolist()}, planned at {pose[:3].tolist()}"
    arms = {name.split("/")[1] for name in shown if name.endswith(("/mesh", "/red"))}
    if (arms & {"arm", "robot"}) != {name.split("/")[1] for name in wanted if name.count("/") > 1}:
        return f"seen are {sorted(arms)}"
    return ""


class Walker:
    """A tab whose controls are used one after the other."""

    def __init__(self, page: Page, server: Server) -> None:
        self.page, self._server = page, server
        self._find()
        self._stand()

    def _find(self) -> None:
        """Wait for the session of the tab."""
        sessions = self._server.sessions
        self.page.until(lambda: any(one.plans for one in sessions.values()), "a session")
        (self.session,) = sessions.values()

    def take(self, step: Step) -> None:
        """Take a step, and wait until its plan is there; what plays is paused again at its end."""
        kind, value = step
        if kind == "reload":
            self.page.reload()
            self.page.until(lambda: self.session not in self._server.sessions.values(), "its end")
            self._find()
        else:
            self._use(kind, value)
        self.page.until(lambda: self.session.resting, f"the plan after {step}", 600.0)
        if kind != "play":
            self._stand()

    def _stand(self) -> None:
        """Pause what plays."""
        if self.session.playback.playing:
            self._send(self.session.playback.button, True)
            self.page.until(lambda: not self.session.playback.playing, "the arm to stand")
        self.page.until(lambda: self.session.resting, "the plan at rest")

    def _use(self, kind: str, value: str) -> None:
        """Use a control as the page would, and wait until that was heard."""
        panels = self.session.panels
        model, woken = panels.stages.arm.model, self.session.plans
        if kind == "play":
            playback, plays = self.session.playback, self.session.playback.playing
            self._send(playback.button, True)
            # a step after it that changes nothing would find the arm standing still
            self.page.until(lambda: playback.playing != plays, "the press to be heard")
            return
        if kind == "scene" and panels.files.choice.value != value:
            self._send(panels.files.choice, value)
        elif kind == "arm" and model.model.value != value:
            self._send(model.model, value)
        elif kind == "stands" and model.mount.value != value:
            self._send(model.mount, value)
        elif kind == "base" and list(panels.stages.arm.base.value) != json.loads(value):
            self._send(panels.stages.arm.base, [float(x) for x in json.loads(value)])
        elif kind == "button":
            buttons = {"reset": panels.files.reset, "undo": panels.history.undo}
            self._send({**buttons, "redo": panels.history.redo}[value], True)
        else:
            return
        self.page.until(lambda: self.session.plans > woken, f"{kind} {value} to be heard", 600.0)

    def _send(self, widget: object, value: object) -> None:
        uuid = functions.uuid(widget)  # type: ignore[arg-type]
        self.page.tab.evaluate(_SEND, [uuid, value])


ARMS = ("the paper's arm", "UR5e", "Franka Panda", "xArm7")
_MOUNTS = ("on the floor", "on the ceiling", "on a wall, along x")
_BASES = ("[0, 0, 0]", "[3, -3, 0]", "[0.1, 0, 0]")


def random_step(chance: random.Random, scenes: Sequence[str]) -> Step:
    """A step of the walk."""
    kinds: list[tuple[str, Sequence[str]]] = [
        ("scene", scenes),
        ("arm", ARMS),
        ("play", ("",)),
        ("button", ("reset", "undo", "redo")),
        ("stands", _MOUNTS),
        ("base", _BASES),
        ("reload", ("",)),
    ]
    kind, values = chance.choices(kinds, weights=(4, 4, 3, 2, 1, 1, 0.5))[0]
    return kind, chance.choice(values)


def every_pair(scenes: Sequence[str]) -> list[Step]:
    """Choices of scenes and arms, in which each comes right after each other one just once."""
    choices: list[Step] = [*(("scene", name) for name in scenes), *(("arm", arm) for arm in ARMS)]
    pairs = itertools.combinations(choices, 2)
    return [*itertools.chain.from_iterable(pairs), choices[0]]


def walk(walker: Walker, steps: Sequence[Step], tell: Callable[[str], None] = print) -> list[str]:
    """Take steps one after the other; what was misplaced after each, in words."""
    faults = []
    for number, step in enumerate(steps):
        walker.take(step)
        if step[0] != "play" and (fault := misplaced(walker.page, walker.session)):
            faults.append(f"step {number}, {step}: {fault}")
            tell(faults[-1])
    return faults


def measure(browser: Browser, steps: Sequence[Step]) -> dict[str, object]:
    """Walk: the number of ``steps`` taken, and the ``faults`` in words."""
    abi.compile()
    server = start(port=0, scene="paper", look=PLAIN)
    page = Page(browser, server.url)
    try:
        walker = Walker(page, server)
        faults = walk(walker, steps, lambda text: print(text, file=sys.stderr, flush=True))
    finally:
        page.close()
        server.stop()
    return {"steps": len(steps), "faults": faults}


def main() -> None:
    """Walk and print the faults."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--pairs", action="store_true", help="every choice after every other")
    options = parser.parse_args()
    names, chance = scene_names(), random.Random(options.seed)
    steps = [random_step(chance, names) for _ in range(options.steps)]
    with chromium() as browser:
        found = measure(browser, every_pair(names) if options.pairs else steps)
    print(json.dumps(found), flush=True)


if __name__ == "__main__":
    main()
