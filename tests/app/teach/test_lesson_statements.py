"""Every number that a lesson states by itself is computed again.

Numbers between double braces are those of the plan on the screen. Any other one needs an entry.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import scipy.spatial

from abi.arm_planning.paper_arm_model import paper_arm
from abi.arm_planning.wrist_drives import wrist_positions
from abi.curves.bspline import clamped
from abi.explain.paper import printed
from abi.planner.planner import Planner
from abi.robot.paper_arm.inverse_kinematics import solve
from abi.robot.paper_arm.paper_arm import forward
from abi.robot.urdf_arm import UrdfArm
from abi.scene.scene import load_scene
from abi.search.search import SEARCHES
from abi.tet_mesh.lattice import REGULAR
from app.state.frame import Frame
from app.teach.lesson import Step, scene_of
from app.teach.measures import MEASURES
from app.theatre.searches import trace
from tests.shipped_lessons import LESSONS

_QUOTED = re.compile(r"\{\{.*?\}\}|\$\$.*?\$\$|\$[^$\n]+\$", re.S)
_NAMES = re.compile(r"stage \**\d|lesson \d|Theorem 1|Table I", re.I)
"""Numbers that only name something."""
_NUMBER = re.compile(r"(?<![\w.])\d[\d,]*(?:\.\d+)?(?!\w)")


def statements(step: Step) -> Iterator[str]:
    """Sentences of a page that have a number of their own."""
    texts = [step.text, step.after]
    if step.question is not None:
        texts.append(step.question.text)
        texts += [text for one in step.question.choices for text in (one.text, one.why)]
    for text in texts:
        for sentence in re.split(r"(?<=[.?!:])\s", _NAMES.sub("", _QUOTED.sub("", text))):
            if _NUMBER.search(sentence):
                yield " ".join(sentence.split())


def planned(lesson: str, number: int, *, done: bool = False) -> Frame:
    """What a page of a lesson shows; ``done`` for what it shows once its task is done."""
    content, folder = LESSONS[lesson]
    scene = load_scene("paper")
    for step in content.steps[: number + 1]:
        scene = scene_of(step.set, scene, folder)
        if step.task is not None and (done or step is not content.steps[number]):
            scene = scene_of(step.task.shown_by, scene, folder)
    return Frame(Planner(compile=False)(scene))


def excluded(side: float) -> float:
    """Nodes removed by a cube of that side, on the mesh that lesson 1 ends with."""
    scene = planned("01-mesh", 1, done=True).plan.scene
    box = {"shape": "box", "size": [side] * 3, "position": [3, 3, 3]}
    count = MEASURES["mesh.excluded"](Frame(Planner(compile=False)(scene.replace(obstacles=[box]))))
    assert count is not None
    return count


def a_cube_three_times_as_wide_removes_up_to_27_times_the_nodes() -> bool:
    return 9 < excluded(6) / excluded(2) <= 3**3


def the_other_powers_are_those_of_a_line_and_a_surface() -> bool:
    return (3**1, 3**2) == (3, 9)


def a_weighted_search_is_as_near_the_shortest_as_is_said() -> bool:
    plan = planned("03-search", 3).plan
    least = trace(plan, "a_star", "", 0).length
    weights = np.linspace(1, 1.95, 20)
    lengths = [trace(plan, "weighted_a_star", "", w).length for w in weights]
    return bool(np.all(np.array(lengths) <= weights / (2 - weights) * least + 1e-9))


def a_weight_of_2_is_greedy_and_need_not_find_the_shortest() -> bool:
    plan = planned("03-search", 3).plan
    greedy, least = (trace(plan, name, "", 0).length for name in ("greedy_best_first", "a_star"))
    return trace(plan, "weighted_a_star", "", 2).length == greedy > least + 1e-6


def only_degree_1_goes_through_all_control_points() -> bool:
    points = np.array([[0, 0, 0], [1, 2, 0], [3, 1, 1], [4, 4, 0], [6, 0, 2], [7, 1, 1]], float)
    through = []
    for degree in (1, 2, 3, 4):
        curve = clamped(points, degree)
        dense = curve(np.linspace(*curve.interval, 20_001))
        away = np.linalg.norm(points[:, None] - dense, axis=2).min(axis=1)
        through.append(bool(away[1:-1].max() < 1e-3))
        assert away[[0, -1]].max() < 1e-9
    return through == [True, False, False, False]


def a_point_of_a_spline_depends_on_degree_and_1_control_points() -> bool:
    points = np.zeros((12, 3))
    curve = clamped(points, 4)
    middle = np.array([0.5 * sum(curve.interval) + 0.01])
    moved = 0
    for k in range(12):
        other = points.copy()
        other[k] = 1.0
        moved += bool(np.abs(clamped(other, 4)(middle)).max() > 0)
    return moved == 4 + 1


def longest_detour(lattice: str) -> int:
    """Largest excess of a path along a lattice's directions over the straight line, [%]."""
    one_sense = np.array([*REGULAR[lattice].steps, *REGULAR[lattice].cross], float)
    directions = np.concatenate([one_sense, -one_sense])
    units = directions / np.linalg.norm(directions, axis=1)[:, None]
    nearest = -scipy.spatial.ConvexHull(units).equations[:, 3].max()
    return round(100 * (1 / float(nearest) - 1))


def the_longest_detours_are_24_and_47_percent() -> bool:
    return (longest_detour("bcc"), longest_detour("kuhn")) == (24, 47)


def the_lengths_are_those_of_table_one() -> bool:
    return sorted(printed.LENGTHS.values()) == [13.295, 13.496, 13.695]


def by_hops_each_edge_costs_1() -> bool:
    scene = planned("10-optimal", 0).plan.scene.replace(search={"weight": "hops"})
    searched = Planner(compile=False)(scene).searches
    return len(searched) == len(SEARCHES) and len({one.hops for one in searched}) == 1


def the_curve_to_bend_is_of_degree_2() -> bool:
    texts = [one.question.text if one.question else "" for one in LESSONS["04-bspline"][0].steps]
    asking = next(k for k, text in enumerate(texts) if "of degree 2" in text)
    return planned("04-bspline", asking).plan.scene.spline.degree == 2


def links_with_less_than_0_are_inside() -> bool:
    clearance = planned("09-links", 1, done=True).plan.arm_clearance
    return clearance is not None and clearance.distance < 0 and bool(clearance.contacts)


def the_force_gives_the_acceleration_q_by_i() -> bool:
    still = load_scene("paper").arm.model_copy(update={"forces": (1.0, 1.0, 1.0), "q5": 0.0})
    inertia = sum(mass * i**2 for mass, i in zip(still.masses, still.radii, strict=True))
    time = np.linspace(0, 1, 1001)
    forces = {}
    for dynamics in ("as_printed", "corrected"):
        wrist = wrist_positions(still.model_copy(update={"dynamics": dynamics}), time)[:, 0]
        forces[dynamics] = inertia * np.diff(wrist, 2) / time[1] ** 2
    return bool(
        np.allclose(forces["corrected"], 1, rtol=1e-4)
        and np.allclose(forces["as_printed"], 2, rtol=1e-4)
    )


def a_mirrored_y_is_the_same_only_at_0() -> bool:
    arm = paper_arm(load_scene("paper").arm.model_copy(update={"base": (0.0, 0.0, 0.0)}))
    y = np.linspace(-2, 2, 41)
    tool = np.column_stack([np.full(41, 4.0), y, np.full(41, 5.0)])
    joints, _ = solve(arm, tool, np.zeros(41), "up", np.zeros_like(tool))
    poses = np.zeros((41, 6))
    # the printed equations, sin q1 · r = x and cos q1 · r = y, where y = −cos q1 · r is right
    poses[:, :3] = np.column_stack([np.arctan2(tool[:, 0], y), joints[:, 1:]])
    reached = forward(arm, poses)
    same = np.isclose(reached[:, 1], y, atol=1e-9)
    return bool(np.allclose(reached, tool * [1, -1, 1], atol=1e-9)) and y[same].tolist() == [0.0]


def a_thousand_points_miss_the_plate_that_the_quadratic_goes_through() -> bool:
    frame = planned("13-samples", 0)
    quadratic, clearance = frame.plan.quadratic, MEASURES["quadratic.clearance"](frame)
    assert quadratic is not None
    assert clearance is not None
    points = quadratic.curve(np.linspace(*quadratic.curve.interval, 1000))
    (plate,) = frame.plan.scene.obstacles
    return bool(plate.signed_distance(points).min() > 0 > clearance)


def ten_values_of_each_joint_are_so_many_poses_so_far_apart() -> bool:
    """Of one turn of each joint, ten values are a tenth of a turn apart."""
    arm = planned("14-joints", 1).plan.arm
    assert isinstance(arm, UrdfArm)
    ranges = np.ptp(arm.chain.usual_range(), axis=1)
    return 10 ** len(ranges) == 1_000_000 and np.allclose(np.degrees(ranges) / 10, 36)


STATEMENTS: dict[tuple[str, str], Callable[[], bool]] = {
    ("01-mesh", "3 times as many"): the_other_powers_are_those_of_a_line_and_a_surface,
    ("01-mesh", "9 times as many"): the_other_powers_are_those_of_a_line_and_a_surface,
    (
        "01-mesh",
        "27 times as many",
    ): a_cube_three_times_as_wide_removes_up_to_27_times_the_nodes,
    ("01-mesh", "3³ = 27"): a_cube_three_times_as_wide_removes_up_to_27_times_the_nodes,
    ("03-search", "With w = 2"): a_weight_of_2_is_greedy_and_need_not_find_the_shortest,
    ("03-search", "between 1 and 2"): a_weighted_search_is_as_near_the_shortest_as_is_said,
    (
        "04-bspline",
        "degree 2 or more",
    ): only_degree_1_goes_through_all_control_points,
    ("04-bspline", "degree + 1"): a_point_of_a_spline_depends_on_degree_and_1_control_points,
    ("04-bspline", "of degree 2"): the_curve_to_bend_is_of_degree_2,
    ("08-pitch", "24 % too long in this type"): the_longest_detours_are_24_and_47_percent,
    ("09-links", "Below 0 they are inside"): links_with_less_than_0_are_inside,
    ("12-errata", "Only where Py = 0"): a_mirrored_y_is_the_same_only_at_0,
    ("12-errata", "t² Q / (2 I)"): the_force_gives_the_acceleration_q_by_i,
    (
        "13-samples",
        "1,000 points",
    ): a_thousand_points_miss_the_plate_that_the_quadratic_goes_through,
    (
        "14-joints",
        "1,000,000 poses, and 36° apart",
    ): ten_values_of_each_joint_are_so_many_poses_so_far_apart,
    ("10-optimal", "13.295, 13.695 and 13.496"): the_lengths_are_those_of_table_one,
    ("10-optimal", "each edge costs **1**"): by_hops_each_edge_costs_1,
}
ELSEWHERE = (
    "4 of 9 cases",
    "6 of 9 meshes",
    "31 of 100 random scenes",
    "24 % of random poses",
)
"""What the table of the paper's numbers computes: their own tests compare the texts with it."""


@pytest.mark.slow
@pytest.mark.parametrize("check", list(dict.fromkeys(STATEMENTS.values())))
def test_what_lessons_state_is_so(check: Callable[[], bool]) -> None:
    assert check()


@pytest.mark.parametrize("name", LESSONS)
def test_every_number_is_computed_by_a_test(name: str) -> None:
    phrases = [phrase for lesson, phrase in STATEMENTS if lesson == name]
    found = [one for step in LESSONS[name][0].steps for one in statements(step)]
    for sentence in found:
        assert any(phrase in sentence for phrase in (*phrases, *ELSEWHERE)), (
            f"{name}: {sentence!r} states a number: quote a measure in braces, or add its check."
        )
    assert all(any(phrase in sentence for sentence in found) for phrase in phrases)


@pytest.mark.parametrize("name", LESSONS)
def test_a_task_asks_in_words_for_what_it_waits_for(name: str) -> None:
    for task in (step.task for step in LESSONS[name][0].steps if step.task):
        bounds = {x for one in task.until for x in (one.at_least, one.at_most) if x is not None}
        shown = set(map(float, re.findall(r"\d+(?:\.\d+)?", task.shown_by.model_dump_json())))
        asked = _NUMBER.findall(_NAMES.sub("", _QUOTED.sub("", task.text)))
        for number in (float(one.replace(",", "")) for one in asked):
            # of a count "fewer than 10" is at most 9
            assert number in bounds | shown or number - 1 in bounds
