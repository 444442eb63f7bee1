"""Layers follow every change of the frame, and send nothing else."""

from __future__ import annotations

import gc
import itertools
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy
import viser

from abi import load_scene, plan
from abi.explain.diagnosis import explain
from abi.planner.arm_words import arm_result
from abi.scene.scene import Scene
from abi.search.search import SEARCHES
from abi.search.subset import fits
from app.drawing.lines import points_at
from app.layers.arm.arm import ArmLayer
from app.layers.details import lagging
from app.layers.marks import names_others
from app.layers.mesh import EDGE_BUDGET, MeshLayer, _counts, _picture
from app.layers.names import _apart, _lines, _nearest, _rounded, names_layer, pictured
from app.layers.points import add_points, set_points
from app.layers.result.plan_numbers import plan_numbers_layer
from app.layers.result.plots import PlotsLayer, _joints_title
from app.panels.base_offer import _may_help
from app.panels.headline import headline, stage_headline
from app.panels.offered_changes import change_label
from app.panels.plan_sentence import plan_sentence
from app.panels.teach.lecture import VIEWS
from app.server.server import Server, start
from app.stages.catalogue import SHOWN_STAGES
from app.state.appearance import PLAIN
from app.state.frame import Frame
from app.state.legend import SWITCHES
from app.tab.session import Session
from app.ui.colour_scale import scale_colours
from app.ui.numbers import format_lower_bound, unbroken
from app.ui.plan_notes import notes
from app.ui.style import CURVES, HEAT
from tests.app.fake_tab import FakeTab, drawn_node, drawn_points, layer, texts_in, until


def test_the_mesh_shown_has_the_start_where_it_is(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    place = [5.7, 0.35, 0.1]
    fake.drag(session.panels.ends.gizmos["start"], place)
    until(lambda: np.allclose(session.plan.scene.start, place))  # type: ignore[union-attr]
    until(lambda: session.resting and not session._worker.is_woken())

    nodes = drawn_points(layer(session, MeshLayer)._clouds["nodes"])
    assert np.linalg.norm(nodes - np.array(place), axis=1).min() < 1e-4


def test_a_cloud_without_points_has_a_colour_which_the_page_asks_for(
    tab: tuple[FakeTab, Session],
) -> None:
    cloud = add_points(tab[1].client.scene, "/cloud")
    assert cloud.colors.size == 3
    for count in (0, 1, 3, 0):
        set_points(cloud, np.zeros((count, 3)), np.full((count, 3), 9, np.uint8), 0.1)
        assert cloud.colors.size == 3 * max(count, 1)


def test_no_distance_is_named_while_it_is_asked(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    until(lambda: session.resting and not session._worker.is_woken())
    names = session._view.layers[names_layer]
    label, line = drawn_node(session, "/name/distance"), drawn_node(session, "/name/line")
    for asks in (False, True):
        names(replace(session.frame, asks=asks))
        assert label.visible == line.visible == (not asks)


def test_a_lesson_has_notes_on_what_it_shows_alone(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    until(lambda: session.resting)
    numbers, note = session._view.layers[plan_numbers_layer], notes(session.frame.plan)["quadratic"]
    folder = session.panels.layout.folders["quadratic"]
    assert note
    for shown in ({"edges", "bspline"}, {"edges", "quadratic"}, {"edges"}):
        frame = replace(session.frame, lesson=True, shown=frozenset(shown))
        assert bool(plan_sentence(frame)) == (frame.plan.followed in shown)
        numbers(frame)
        assert (unbroken(note) in "".join(texts_in(folder))) == ("quadratic" in shown)


def test_the_distance_to_the_obstacles_is_shown_with_its_curve(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    boxes = session.panels.layer_switches.boxes
    label, line = drawn_node(session, "/name/distance"), drawn_node(session, "/name/line")
    assert session.plan is not None
    assert session.plan.followed == "bspline"
    for on in (True, False, True):
        fake.set(boxes["bspline"], on)
        until(lambda: line.visible == label.visible == on)  # noqa: B023
    fake.set(boxes["names"], False)
    until(lambda: not label.visible)


def test_every_search_has_its_name_where_no_curve_is_shown(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    boxes = session.panels.layer_switches.boxes
    labels = [
        drawn_node(session, f"/name/{name}") for name in ("path", "bspline", "quadratic", *SEARCHES)
    ]

    def named() -> set[str]:
        return {label.text for label in labels if label.visible}

    until(lambda: session.resting and named() == {"A*", "B-spline ▸", "quadratic"})
    fake.set(boxes["bspline"], False)
    until(lambda: named() == {"A*", "quadratic"})
    fake.set(boxes["quadratic"], False)
    searches = {one.label for one in SEARCHES.values()}
    until(lambda: named() == searches)
    fake.set(boxes["dijkstra"], False)
    until(lambda: named() == searches - {"Dijkstra"})
    fake.set(session.panels.stages.fields["search.algorithm"], "Dijkstra")
    until(lambda: named() == searches - {"Dijkstra"} and session.resting)


@pytest.mark.parametrize("direction", VIEWS.values(), ids=list(VIEWS))
def test_names_are_seen_apart_from_wherever_the_camera_looks(
    direction: tuple[float, float, float],
) -> None:
    made = plan(load_scene("paper"))
    eye = 3 + 14 * np.array(direction) / np.linalg.norm(direction)
    view = (_rounded(eye), (3.0, 3.0, 3.0))
    lines, nearest = _lines(made), _nearest(made)
    assert nearest is not None
    labels = [nearest.mean(axis=0), np.array(made.scene.start), np.array(made.scene.goal)]
    for name, place in _apart(made, view).items():
        if name in ("path", "bspline", "quadratic"):
            labels.append(points_at(lines[name], np.array([place]))[0])
    seen = pictured(np.array(labels), *view)
    assert scipy.spatial.distance.pdist(seen).min() > 0.14  # the width of a word


@pytest.mark.slow
def test_the_part_of_a_fine_mesh_that_is_shown_goes_with_the_path(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    fake.set(session.panels.stages.fields["mesh.pitch"], 0.2)
    until(lambda: session.plan.scene.mesh.pitch == 0.2 and session.resting)  # type: ignore[union-attr]
    fake.drag(session.panels.ends.gizmos["start"], [5.7, 0.35, 0.1])

    def is_shown() -> bool:
        plan = session.plan
        assert plan is not None
        if plan.path is None or plan.mesh is None or plan.scene.start[0] < 5:
            return False
        nodes = drawn_points(layer(session, MeshLayer)._clouds["nodes"])
        away = [np.linalg.norm(nodes - vertex, axis=1).min() for vertex in plan.path.points]
        return bool(max(away) < plan.mesh.pitch)

    until(is_shown)
    assert layer(session, MeshLayer)._note


def test_the_ground_is_below_the_arm(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    for height in (-4.0, 0.0):
        fake.set(session.panels.stages.arm.base, (3.0, -3.0, height))
        until(lambda z=height: session.plan.scene.arm.base[2] == z)  # type: ignore[misc, union-attr]
        until(lambda z=height: z - 0.1 < drawn_node(session, "/ground").position[2] < z)  # type: ignore[misc]


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene",
    [
        {"unit": "mm"},
        {"arm": {"a1": 0.1, "a2": 0.2, "a3": 0.6, "a4": 0.3, "a5": 0.25}},
        {"arm": {"a3": 0.1}},
        {"arm": {"a1": 100, "a2": 200, "a3": 600, "a4": 300, "a5": 250}, "unit": "m"},
    ],
)
def test_an_arm_of_any_size_is_drawn_whole(tmp_path: Path, scene: dict[str, object]) -> None:
    path = tmp_path / "scene.yaml"
    scene_of_arm = Scene.from_dict({"version": 1, **scene})
    scene_of_arm.save(path)
    server = start(port=0, scene=str(path), look=PLAIN)
    try:
        fake = FakeTab(server.url)
        until(lambda: any(session.plans for session in list(server.sessions.values())))
        (session,) = server.sessions.values()
        until(lambda: bool(layer(session, ArmLayer)._nodes.joint_nodes))
        nodes = {
            name.rpartition("/")[2]: node
            for name, node in session.client.scene._handle_from_node_name.items()
            if name.startswith("/arm/links/") and not name.endswith(("/mesh", "/red"))
        }
        assert [*nodes] == ["turret", "upper_arm", "elbow", "forearm", "rod", "gripper", "tool"]
        arm = scene_of_arm.arm
        reach = sum(float(np.linalg.norm(node.position)) for node in nodes.values())
        assert reach == pytest.approx(arm.a1 + arm.a2 + arm.a3 + arm.a4 + arm.a5, rel=1e-6)
        fake.close()
    finally:
        server.stop()


def test_the_seed_is_offered_where_it_counts(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    assert not session.panels.stages.fields["mesh.seed"].visible
    fake.set(session.panels.stages.fields["mesh.lattice"], "Delaunay (irregular)")
    until(lambda: session.panels.stages.fields["mesh.seed"].visible)
    fake.set(session.panels.stages.fields["mesh.lattice"], "Kuhn (cube cut in 6)")
    until(lambda: not session.panels.stages.fields["mesh.seed"].visible)


def test_a_plot_has_its_data_once_and_before_it_is_shown(tab: tuple[FakeTab, Session]) -> None:
    """A chart that is shown first and gets its data at once after stays without a time axis."""
    _, session = tab
    tabs = session.client.gui.add_tab_group()
    one = tabs.add_tab("all of it")
    layout = replace(session.panels.layout, result=one, plots=one)
    layer = PlotsLayer(layout)
    updates: list[tuple[object, str]] = []
    for plot in layer._plots.values():
        object.__setattr__(
            plot, "_queue_update", lambda name, _, of=plot: updates.append((of, name))
        )
    result = plan(load_scene("paper"))
    assert result.motion is not None
    layer(Frame(result, interactive=True))
    layer(Frame(result, plots=True))
    layer(Frame(result, plots=True, time=0.5))
    for plot in layer._plots.values():
        # the page itself marks the time
        assert [name for of, name in updates if of is plot] == ["data", "visible"]
        assert plot.visible
        assert plot.data[0][-1] == pytest.approx(result.motion.time[-1])
    tabs.remove()


@pytest.mark.parametrize(
    ("slides", "unit", "title"),
    [
        ((False, True), "cm", "joint positions [rad, cm]"),
        ((False, False), "mm", "joint positions [rad]"),
        ((True, True), "m", "joint positions [m]"),
    ],
)
def test_the_plot_of_joints_names_their_units(
    slides: tuple[bool, ...], unit: str, title: str
) -> None:
    motion = plan(load_scene("paper")).motion
    assert motion is not None
    assert _joints_title(replace(motion, slides=slides), unit) == title


def test_a_mesh_whose_drawing_was_ended_anywhere_is_drawn_whole_later(
    tab: tuple[FakeTab, Session],
) -> None:
    _, session = tab
    until(lambda: session.resting)
    session.close()
    mesh = layer(session, MeshLayer)
    scene = load_scene("paper").replace(mesh={"pitch": 0.3, "max_nodes": 100_000})
    result = plan(scene)
    assert result.free is not None
    assert not fits(result.free, EDGE_BUDGET)
    ended = 0
    for looks in itertools.count():
        overtaken = itertools.chain([False] * looks, itertools.repeat(True))
        draw = lagging([mesh], lambda: 0, lambda: next(overtaken))  # noqa: B023
        draw(Frame(result))
        if mesh._written[:1] == (result,):
            break
        ended += 1
    assert ended >= 5
    assert len(drawn_points(mesh._clouds["nodes"])) > 1000
    assert mesh._text.content == _counts(result, mesh._note)
    assert mesh._edges is not None
    assert mesh._edges.glb_data == _picture(result, "near", False)


def _still(session: Session) -> Frame:
    """The session's last frame, drawn to its end while nothing moves any more."""
    until(lambda: session.resting)
    session.close()
    frame = replace(session.frame, playing=False)
    _draw(session, frame)
    return frame


def _draw(session: Session, frame: Frame) -> None:
    for group in session._view.parts:
        for draw in group:
            draw(frame)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "forest", "no-way"])
def test_what_is_drawn_already_is_not_sent_again(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, name)
    until(lambda: session.frame.plan.scene == load_scene(name))
    until(lambda: session.frame.plan.error is None or session.frame.reason is not None)
    frame = _still(session)
    sent: list[object] = []
    monkeypatch.setattr(session.client._websock_connection, "queue_message", sent.append)
    _draw(session, replace(frame))
    assert sent == []


def test_a_switch_sends_what_it_hides_and_nothing_else(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, session = tab
    frame = replace(_still(session), shown=frozenset(switch.name for switch in SWITCHES))
    _draw(session, frame)
    sent: list[object] = []
    monkeypatch.setattr(session.client._websock_connection, "queue_message", sent.append)
    hidden: list[str] = []
    for switch in SWITCHES:
        _draw(session, replace(frame, shown=frame.shown - {switch.name}))
        if switch.name == "obstacles":  # the sentence no longer asks to drag one
            sent[:] = [one for one in sent if "Drag start or goal." not in str(one)]
        assert sent
        for message in sent:
            assert isinstance(message, viser._messages.SetSceneNodeVisibilityMessage)
            assert not message.visible
            if not message.name.startswith("/name/"):  # they go with what they name
                hidden.append(message.name)
        _draw(session, frame)
        sent.clear()
    assert len(hidden) == len(set(hidden))


def test_the_axes_lead_along_x_y_and_z_in_the_scenes_unit(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.files.choice, "kitchen-ur5e")
    until(lambda: session.frame.plan.scene == load_scene("kitchen-ur5e"))
    until(lambda: drawn_node(session, "/axes/z/label").text == "z [m]")
    workspace = session.frame.plan.scene.workspace
    for axis, name in enumerate("xyz"):
        label = drawn_node(session, f"/axes/{name}/label")
        (begin, end), *barbs = np.asarray(drawn_node(session, f"/axes/{name}").points)
        direction = np.eye(3)[axis]
        np.testing.assert_allclose(begin, 0)
        np.testing.assert_allclose(end / np.linalg.norm(end), direction)
        assert all(np.array_equal(barb[1], end) for barb in barbs)
        assert label.text == ("x", "y", "z [m]")[axis]
    # beside the workspace, where no obstacle, path or end is
    assert drawn_node(session, "/axes").position[0] > workspace.max[0]
    assert drawn_node(session, "/axes").position[1] < workspace.min[1]


def test_the_time_shown_is_the_arms(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    playback = session.playback
    fake.set(playback.slider, 2.0)
    until(lambda: playback._time == pytest.approx(2.0) and not playback.playing)
    inside, outside = [3.0, 3.0, 3.0], [6.0, 6.0, 6.0]
    fake.drag(session.panels.ends.gizmos["goal"], inside)
    until(lambda: session.plan.error is not None)  # type: ignore[union-attr]
    fake.drag(session.panels.ends.gizmos["goal"], outside)
    until(lambda: session.plan.error is None)  # type: ignore[union-attr]

    assert playback._time == pytest.approx(2.0)
    until(lambda: playback.slider.value == pytest.approx(2.0))


@pytest.mark.slow
def test_a_tab_that_has_gone_leaves_nothing_behind(server: Server) -> None:
    gone = []
    for _ in range(3):
        fake = FakeTab(server.url)
        until(lambda: len(server.sessions) == 1)
        (session,) = server.sessions.values()
        until(lambda one=session: one.plan is not None)  # type: ignore[misc]
        gone.append(weakref.ref(session))
        del session
        fake.close()
        until(lambda: not server.sessions)

    # the last one's frames may still be on a thread's way out
    def left() -> int:
        gc.collect()
        return sum(one() is not None for one in gone)

    until(lambda: left() <= 1)


def test_the_usual_layers_come_back(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    switches, usual = session.panels.layer_switches, session.frame.shown
    for name in usual:
        fake.set(switches.boxes[name], False)
    fake.set(switches.boxes["shadow"], True)
    until(lambda: session.frame.shown == {"shadow"})
    fake.set(switches.usual, True)
    until(lambda: session.frame.shown == usual)


def test_the_distance_kept_is_no_good_news_while_the_arm_goes_through_something() -> None:
    scene = load_scene("arm-in-the-way")
    through = plan(scene.replace(arm={"avoid": False}))
    assert through.arm_clearance is not None
    assert through.arm_clearance.contacts
    assert through.followed_curve is not None
    assert through.followed_curve.holds
    assert "✓" not in headline(through)
    around = plan(scene)
    assert around.arm_clearance is not None
    assert around.arm_clearance.certified
    assert "✓" in headline(around)


def test_what_is_proven_is_not_said_of_a_scene_that_is_still_planned(
    tab: tuple[FakeTab, Session],
) -> None:
    _, session = tab
    until(lambda: session.resting)
    layout, stages = session.panels.layout, session.panels.stages
    numbers = session._view.layers[plan_numbers_layer]

    def texts() -> list[str]:
        headings = " ".join(str(folder.label) for folder in layout.folders.values())
        return [layout.overlay.shown["numbers"], texts_in(layout.result)[0], headings]

    for outdated in (True, False):
        for draw in (session.panels.messages.draw, numbers, stages.draw):
            draw(replace(session.frame, outdated=outdated))
        assert [" ✓" in text.replace("✓ keeps", "") for text in texts()] == 3 * [not outdated]


def test_the_numbers_are_those_of_what_is_shown(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    until(lambda: session.resting)
    panels, shown = session.panels, session.panels.layout.overlay.shown
    assert " length" in shown["numbers"]
    fake.set(panels.lecture.toggle, True)
    until(lambda: session.frame.lecture)
    assert " length" in shown["numbers"]
    seen = []
    for stage in SHOWN_STAGES:
        fake.set(panels.lecture._forward, True)
        until(lambda: session.frame.stage == stage)  # noqa: B023
        numbers = stage_headline(session.frame.plan, stage)
        until(lambda: shown["numbers"] == numbers)  # noqa: B023
        until(lambda: SHOWN_STAGES[stage].sentence in shown["message"])  # noqa: B023
        seen.append(numbers)
    assert all(seen)
    assert len(set(seen)) == len(SHOWN_STAGES)
    fake.set(panels.lecture._forward, True)
    until(lambda: not session.frame.stage and " length" in shown["numbers"])
    fake.set(panels.lecture.toggle, True)
    until(lambda: not session.frame.lecture)
    panels.theatre.set(on=True)
    until(lambda: not shown["numbers"])


def test_the_sentence_tells_of_the_curve_that_the_arm_follows() -> None:
    for followed in ("bspline", "quadratic"):
        result = plan(load_scene("paper").replace(motion={"curve": followed}))
        assert result.followed == followed
        length = headline(result).split("<b>")[1].split("</b>")[0]
        assert f"{CURVES[followed][0]}</span> of" in plan_sentence(Frame(result))
        assert length in plan_sentence(Frame(result))


def test_what_the_start_reaches_has_no_second_mark() -> None:
    paper = load_scene("paper")
    (box,) = paper.obstacles
    wall = {**box.model_dump(mode="json"), "size": [1.0, 8.0, 8.0]}
    walled = ((paper.replace(obstacles=[wall]), True), (load_scene("no-way"), False))
    for scene, around_start in walled:
        result = plan(scene)
        reason = explain(scene, result)
        assert reason is not None
        assert len(reason.points) > 0
        assert names_others(reason, result) is not around_start


def test_a_demonstration_says_that_it_is_one() -> None:
    frame = Frame(plan(load_scene("paper")))
    assert "Demo:" not in plan_sentence(frame)
    assert "Demo:" in plan_sentence(replace(frame, demonstrates=True))


@pytest.mark.parametrize(
    "arm",
    [
        {"base": (3.0, -30.0, 0.0)},  # out of reach
        {"q5": 2.5},  # past the slide's limit
        {"clearance": 5.0, "avoid": False},  # too near
    ],
)
def test_no_headline_is_green_while_the_arm_is_not_proven_clear(arm: dict[str, object]) -> None:
    aside = {"shape": "sphere", "radius": 0.2, "position": (5.7, 0.3, 5.7)}
    result = plan(load_scene("paper").replace(arm=arm, obstacles=[aside]))
    assert result.followed_curve is not None
    assert result.followed_curve.holds
    assert result.arm_clearance is not None
    assert not result.arm_clearance.contacts
    assert not result.is_arm_clear
    assert "✓" not in arm_result(result)
    assert "✓" not in headline(result)
    assert "tool tip only, arm ignored" in headline(result)


def test_links_nearer_than_asked_for_are_told_with_both_numbers() -> None:
    scene = load_scene("paper").replace(arm={"clearance": 0.5, "avoid": False})
    result = plan(scene)
    assert result.arm_clearance is not None
    assert result.arm_clearance.is_too_near
    assert arm_result(result) == "links too near ✗"
    note = notes(result)["arm"]
    assert f"{format_lower_bound(result.arm_clearance.distance)} cm of the 0.5 cm wanted" in note
    assert "✗" in note
    assert "Proven" not in note
    kept = plan(load_scene("paper"))
    assert arm_result(kept) == "proven clear ✓"
    assert "Proven: every link stays" in notes(kept)["arm"]


@pytest.mark.parametrize(("speed", "spilt"), [(30.0, False), (3000.0, True)])
def test_a_cup_has_its_tilt_in_degrees_though_it_is_spilt(speed: float, spilt: bool) -> None:
    motion = {"speed": speed, "acceleration": speed, "deceleration": speed}
    result = plan(load_scene("paper").replace(motion=motion))
    assert result.liquid_tilt is not None
    note = notes(result)["motion"]
    assert ("spilt" in note) == spilt
    assert f"by up to {np.degrees(result.liquid_tilt):.0f}°" in note


def test_an_obstacle_in_the_way_is_moved_by_a_button_beside_find_a_base() -> None:
    scene = load_scene("wall-with-window").replace(arm={"avoid": True})
    result = plan(scene)
    reason = explain(scene, result)
    assert reason is not None
    assert reason.moved is not None
    assert reason.change is not None
    assert change_label(reason.change, reason) == f"Move obstacle {reason.moved + 1} there"
    assert _may_help(Frame(result, reason=reason))


def test_a_direction_that_can_be_kept_for_a_part_is_a_button() -> None:
    axis = {"direction": [0.0, 0.0, -1.0], "tolerance": 0.1, "from": 0.0, "to": 0.9}
    label = "Keep the direction within 5.73° from 0 to 90 % of the time"
    assert change_label({"arm": {"axis": axis}}, None) == label


def test_the_nodes_visited_are_shown_in_their_order(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    slider, cloud = session.panels.stages.visited, drawn_node(session, "/search/reached")
    until(lambda: session.resting)
    plan = session.frame.plan
    assert plan.path is not None
    assert plan.graph is not None
    order = plan.path.order
    assert slider.max == len(order)
    count = len(order) // 2
    fake.set(slider, count)
    until(lambda: len(drawn_points(cloud)) == count)
    until(lambda: session.resting)
    places = plan.graph.points[order[:count]].astype(np.float32)
    assert len(np.unique(order[:count])) == count  # A* expands no node again
    colour = {tuple(p): tuple(c) for p, c in zip(cloud.points, cloud.colors, strict=True)}
    wanted = map(tuple, scale_colours(HEAT, np.arange(count) / (len(order) - 1)))
    assert [colour[tuple(place)] for place in places] == list(wanted)
    assert np.allclose(drawn_points(drawn_node(session, "/search/latest")), places[-1:])
    fake.set(session.panels.theatre.on, True)  # which has nodes of its own in these colours
    until(lambda: not cloud.visible)
    fake.set(session.panels.theatre.on, False)
    until(lambda: bool(cloud.visible))
    fake.set(session.panels.files.choice, "two-boxes")
    until(lambda: session.frame.plan.scene == load_scene("two-boxes") and session.resting)
    assert slider.value == session.frame.visited == 0
    path = session.frame.plan.path
    until(lambda: path is not None and slider.max == path.expanded)
