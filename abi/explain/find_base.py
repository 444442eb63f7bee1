"""Search for the arm's base in a region: the place with the shortest certified plan.

The region is cut into some sixty cells, and the scene is planned with the base in the middle of
each. Then the best cells are halved along every side, three times over. The tool's own path does
not depend on the base, so the planner repeats only the last stage. Where a scene has tasks, all
legs are planned at each place, up to the first that has no certified plan.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from abi.arm_planning.arm_errors import (
    DIRECTION_NOT_HELD,
    OUT_OF_REACH,
    ArmNotClear,
    NoJointMotion,
)
from abi.arrays import FloatArray
from abi.errors import SceneError, StageError
from abi.explain.base_map import BaseMap, BaseTrial
from abi.obstacles.pose import Vec3
from abi.planner.joint_space_motion import HASTY
from abi.planner.plan import Plan
from abi.planner.planner import Planner
from abi.planner.task_plan import legs_of
from abi.scene.arm_end import ENDS
from abi.scene.scene import Scene, require_scene

MOST_NODES = 8_000
"""Most nodes of the mesh on which bases are tried; the best ones are planned on the scene's."""

_FIRST_CELLS = 64
_ROUNDS = 3
_SPLIT = 4
"""Cells that are split in a round."""
_SPLIT_BLINDLY = 16
"""Cells that are split in a round while no base has a plan."""
_FARTHEST = 1e6
_THREE = "three numbers from -1,000,000 to 1,000,000"
_RANKS = {"start": 1, "goal": 2, "same": 2, "path": 3, "curve": 4}
_CERTIFIED = 5
_COARSER = 2 ** (1 / 3)


def find_base(
    scene: Scene,
    low: Sequence[float],
    high: Sequence[float],
    cancelled: Callable[[], bool] = lambda: False,
) -> BaseMap:
    """Find the base in a region that gives the shortest certified plan.

    A plan is certified if the arm follows its curve within reach and limits, the curve is proven to
    keep the clearance, and all links are proven clear. Among equally short plans, the one whose
    links stay farthest from the obstacles is the best. A sequence of tasks is certified if each of
    its legs is, and as long as all of them.

    Args:
        scene: the scene; only ``arm.base`` is varied.
        low: low corner of the region, [unit], world.
        high: high corner of the region; a side of length 0 is not divided.
        cancelled: called after each plan; once it returns True, the search ends.

    Returns:
        The map of all places tried, with the length of the plan from each, [unit].

    Raises:
        SceneError: no scene, or low and high do not span a region; names the corner.
    """
    require_scene(scene)
    if not callable(cancelled):
        raise SceneError("cancelled", cancelled, "a function without arguments")
    found = BaseMap(scene, *_region(low, high))
    for latest in base_maps(scene, low, high):
        found = latest
        if cancelled():
            break
    return found


def base_maps(scene: Scene, low: Sequence[float], high: Sequence[float]) -> Iterator[BaseMap]:
    """Yield maps with one more plan each; the last one is complete.

    The arguments are those of :func:`find_base`.

    Raises:
        SceneError: low and high do not span a region; names the corner.
    """
    found = BaseMap(scene, *_region(low, high))
    coarse = _coarser(scene)
    planners = [Planner(compile=False, effort=HASTY) for _ in scene.tasks or [None]]
    cells = _first_cells(found.low, found.high)
    for number in range(_ROUNDS + 1):
        later = (_ROUNDS - number) * _SPLIT * _parts(cells[0])
        whole = len(found.trials) + len(cells) + later
        for cell in cells:
            tried = _tried(planners, coarse, cell)
            if isinstance(tried, str) and coarse is not scene:
                coarse = scene
                tried = _tried(planners, coarse, cell)
            if isinstance(tried, str):
                yield replace(found, fault=tried, is_done=True)
                return
            trials = (*found.trials, tried)
            planned = len(trials), whole
            found = replace(found, trials=trials, cells=(*found.cells, tried), planned=planned)
            yield found
        if _parts(cells[0]) == 1:
            break
        if number < _ROUNDS:
            split = _to_split(found.cells)
            kept = tuple(cell for cell in found.cells if cell not in split)
            cells = [part for cell in split for part in _halves(cell)]
            found = replace(found, cells=kept)
    while coarse is not scene and found.best is not None:
        found, is_confirmed = _confirmed(found, found.best, planners)
        if is_confirmed:
            break
        yield found
    yield replace(found, is_done=True)


def default_region(scene: Scene) -> tuple[Vec3, Vec3]:
    """Low and high corner of the default region: level with the base, around the workspace.

    It reaches beyond the workspace by half the arm's length for the paper's arm, and by half the
    workspace's longest side otherwise.
    """
    arm, box = scene.arm, scene.workspace
    beyond = (arm.a3 + arm.a4 + arm.a5) / 2 if arm.model == "abi" else max(box.size) / 2
    height = arm.base[2]
    low = (box.min[0] - beyond, box.min[1] - beyond, height)
    return low, (box.max[0] + beyond, box.max[1] + beyond, height)


def _region(low: Sequence[float], high: Sequence[float]) -> tuple[Vec3, Vec3]:
    """Both corners, checked."""
    corners = []
    for name, corner in (("low", low), ("high", high)):
        field = f"region.{name}"
        try:
            numbers = np.asarray(corner, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise SceneError(field, corner, _THREE) from None
        if (
            isinstance(corner, str)
            or numbers.shape != (3,)
            or not np.all(abs(numbers) <= _FARTHEST)
        ):
            raise SceneError(field, corner, _THREE)
        x, y, z = numbers.tolist()
        corners.append((x, y, z))
    if any(a > b for a, b in zip(*corners, strict=True)):
        expected = f"no number below that of region.low, {list(low)}"
        raise SceneError("region.high", list(high), expected)
    return corners[0], corners[1]


def _coarser(scene: Scene) -> Scene:
    """The scene with a coarser pitch if its mesh is large; legs are planned on the scene's own."""
    mesh = scene.mesh
    while not scene.tasks and mesh.node_count(scene.workspace) > MOST_NODES:
        mesh = mesh.model_copy(update={"pitch": mesh.pitch * _COARSER})
    return scene if mesh is scene.mesh else scene.model_copy(update={"mesh": mesh})


def _first_cells(low: Vec3, high: Vec3) -> list[BaseTrial]:
    """Cells that fill the region, nearly cubes, in rows."""
    sides = np.subtract(high, low)
    wide = sides[sides > 0]
    side = float(np.prod(wide) / _FIRST_CELLS) ** (1 / max(len(wide), 1))
    counts = [max(1, min(_FIRST_CELLS, round(length / side))) for length in sides.tolist()]
    cell = sides / counts
    places = itertools.product(*map(range, counts))
    return [_cell(low + (np.array(place) + 0.5) * cell, cell) for place in places]


def _halves(cell: BaseTrial) -> list[BaseTrial]:
    """The cells of half the side that a cell is split into."""
    half = np.array(cell.cell) / 2
    signs = itertools.product(*((-0.5, 0.5) if side > 0 else (0.0,) for side in cell.cell))
    return [_cell(np.array(cell.base) + np.array(sign) * half, half) for sign in signs]


def _cell(middle: FloatArray, sides: FloatArray) -> BaseTrial:
    """Cell around a place, which is rounded to a hundredth of its shortest side."""
    shortest = float(min(sides[sides > 0], default=1.0))
    decimals = max(0, 2 - math.floor(math.log10(shortest)))
    x, y, z = np.where(sides > 0, np.round(middle, decimals) + 0.0, middle).tolist()
    a, b, c = sides.tolist()
    return BaseTrial((x, y, z), (a, b, c))


def _parts(cell: BaseTrial) -> int:
    """Number of cells that a cell is split into."""
    return int(2 ** sum(side > 0 for side in cell.cell))


def _to_split(cells: Sequence[BaseTrial]) -> list[BaseTrial]:
    """The best cells to split next; more while none has a plan."""
    best = sorted(cells, key=lambda cell: cell.order)
    return best[: _SPLIT if best[0].length is not None else _SPLIT_BLINDLY]


def _tried(planners: Sequence[Planner], scene: Scene, cell: BaseTrial) -> BaseTrial | str:
    """The cell with the result of a plan from its middle, and a reason if no base can help."""
    try:
        placed = scene.replace(arm={"base": list(cell.base)})
        return _planned(legs_of(placed, planners, chosen_only=True), bool(scene.tasks), cell)
    except SceneError as error:  # as where joints take the tool out of the workspace
        name = error.field.rpartition(".")[2]
        return replace(cell, fault=f"{name} outside the workspace" if name in ENDS else str(error))


def _planned(legs: Iterable[Plan], counted: bool, cell: BaseTrial) -> BaseTrial | str:
    """The cell with the result of its legs, and a reason if no base can help the first."""
    length, clearance = 0.0, math.inf
    for number, plan in enumerate(legs):
        error = plan.error
        if number == 0 and error is not None and error.stage != "arm" and error.kind != "too_slow":
            return error.message
        fault, rank = _fault(plan)
        if fault or plan.motion is None or plan.arm_clearance is None:
            which = f" (leg {number + 1})" if counted else ""
            return replace(cell, fault=fault + which, rank=rank + _CERTIFIED * number)
        arc = plan.followed_arc
        # where the joints follow a curve of their own, the tool's samples
        tool = float(np.linalg.norm(np.diff(plan.motion.tool, axis=0), axis=1).sum())
        length += tool if arc is None else arc.length
        clearance = min(clearance, plan.arm_clearance.distance)
    return replace(cell, length=length, clearance=clearance)


def _fault(plan: Plan) -> tuple[str, int]:
    """Reason why a plan is not certified, empty if it is, and the last stage reached."""
    if plan.error is not None:
        return _reason(plan.error)
    assert plan.motion is not None
    assert plan.arm_clearance is not None
    if not plan.motion.within_limits:
        return "a joint past its limit", 2
    if plan.arm_clearance.contacts:
        return "a link in the way", 3
    if not plan.arm_clearance.certified:
        return "the links not proven clear", 4
    if plan.followed_curve is not None and not plan.followed_curve.holds:
        return "the curve not proven clear", 4
    return "", _CERTIFIED


def _reason(error: StageError) -> tuple[str, int]:
    """An error of the arm in a few words, and the last stage reached."""
    if error.kind == OUT_OF_REACH:
        return "out of reach on the way", 0
    if not isinstance(error, ArmNotClear | NoJointMotion):
        return error.kind.replace("_", " "), 0
    turned = error.kind == DIRECTION_NOT_HELD
    rank = _RANKS[error.where]
    if error.where in ("start", "goal"):
        what = "out of reach" if error.obstacle is None else "a link in the way"
        return f"{'the direction not kept' if turned else what} at the {error.where}", rank
    if turned:
        return "no motion that keeps the direction", rank
    found = {"path": "no path for the whole arm", "curve": "no curve proven clear"}
    return found.get(error.where, "the joints at the goal already"), rank


def _confirmed(
    found: BaseMap, best: BaseTrial, planners: Sequence[Planner]
) -> tuple[BaseMap, bool]:
    """The map with its best base planned again on the scene's own mesh; whether that has a plan."""
    anew = _tried(planners, found.scene, best)
    if isinstance(anew, str):
        anew = replace(best, length=None, fault="no path on the scene's own mesh")
    trials = tuple(anew if trial is best else trial for trial in found.trials)
    cells = tuple(anew if cell is best else cell for cell in found.cells)
    return replace(found, trials=trials, cells=cells), anew.length is not None
