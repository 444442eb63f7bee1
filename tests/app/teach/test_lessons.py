from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from abi import assets, load_scene, plan
from abi.errors import AbiError
from abi.explain.paper.curve_figures import of_splines
from abi.planner.planner import Planner
from abi.scene.scene import Scene
from abi.teach import exercises, notebook
from abi.teach.exercise_file import exercises_in
from app.cli.command_line import cli
from app.panels.teach.figures import _wrapped
from app.state.frame import Frame
from app.state.legend import SHOWN, SWITCHES
from app.tab.session import Session
from app.teach.exercise_files import NOTEBOOK, SCRIPT
from app.teach.figures import figures
from app.teach.lesson import Lesson, Step, scene_of
from app.teach.lesson_check import check_pages
from app.teach.lesson_file import library, load_lessons, unknown_layers
from app.teach.measures import MEASURES, filled, text
from app.ui.formulas import with_formulas
from tests.app.fake_tab import FakeTab, until
from tests.shipped_lessons import LESSONS

FOLDER = assets.path("lessons")
NAMES = {switch.name for switch in SWITCHES}


@pytest.mark.slow
def test_counts_of_meshes_are_those_of_the_table_of_the_papers_numbers() -> None:
    scene = load_scene("paper")
    rows = of_splines(scene, plan(scene))
    computed = {count for row in rows for count in re.findall(r"in (\d of 9) meshes", row.ours)}
    texts = [file.read_text(encoding="utf-8") for file in FOLDER.iterdir() if file.is_file()]
    told = {count for one in texts for count in re.findall(r"(\d of 9) (?:meshes|cases)", one)}
    assert told == computed


def texts_of(step: Step) -> list[str]:
    choices = step.question.choices if step.question else ()
    asked = [step.question.text if step.question else "", ""]
    asked += [step.task.text, step.task.now] if step.task else []
    return [step.text, step.after, *asked, *(choice.why for choice in choices)]


def test_there_are_enough_lessons_and_each_asks() -> None:
    assert len(LESSONS) >= 10
    for lesson, _ in LESSONS.values():
        assert any(step.question for step in lesson.steps)
    tasks = [step.task for lesson, _ in LESSONS.values() for step in lesson.steps if step.task]
    assert len(tasks) >= 10


def test_each_exercise_has_a_lesson_that_leads_to_it() -> None:
    ends = [lesson.steps[-1] for lesson, _ in LESSONS.values()]
    for name in exercises():
        assert sum(f"--only {name}`" in end.after and name in end.exercises for end in ends) == 1
    assert sum(len(end.exercises) for end in ends) == len(exercises())


@pytest.mark.parametrize("name", LESSONS)
def test_texts_are_typeset_with_the_present_numbers(name: str) -> None:
    frame = Frame(Planner(compile=False)(load_scene("paper")))
    for step in LESSONS[name][0].steps:
        for content in texts_of(step):
            shown = with_formulas(filled(content, frame))
            assert "{{" not in shown
            assert "$" not in shown
            assert shown.count("<math") == len(
                re.findall(r"\$\$.+?\$\$|\$[^$\n]+\$", content, re.S)
            )


@pytest.mark.slow
@pytest.mark.parametrize("name", LESSONS)
def test_nothing_is_wrong_when_every_page_is_gone_through(name: str) -> None:
    lesson, folder = LESSONS[name]
    file = folder / f"{name}.yaml"
    assert not [*unknown_layers(file, lesson, NAMES), *check_pages(file, lesson)]


@pytest.mark.parametrize("scene", ["paper", "no-way", "two-boxes"])
def test_every_measure_is_a_number_or_missing(scene: str) -> None:
    frame = Frame(Planner(compile=False)(load_scene(scene)))
    for name in MEASURES:
        assert MEASURES[name](frame) is None or isinstance(float(MEASURES[name](frame)), float)  # type: ignore[arg-type]
        assert text(name, frame)


def test_a_measure_has_no_more_digits_than_it_means_and_a_bound_stays_one() -> None:
    frame = Frame(Planner(compile=False)(load_scene("paper")))
    assert text("motion.a", frame) == "6"
    assert text("clearance.wanted", frame) == "0.2 cm"
    bound = MEASURES["optimum.length"](frame)
    assert bound is not None
    assert float(text("optimum.length", frame).removesuffix(" cm")) <= bound


def test_a_length_that_is_hardly_longer_is_not_said_to_be_no_longer() -> None:
    frame = Frame(plan(load_scene("paper").replace(search={"taut": True})))
    gap = MEASURES["taut.gap"](frame)
    assert gap is not None
    assert 0 < gap < 0.05
    assert text("taut.gap", frame) == "under 0.1"


def test_figures_are_those_of_the_paper() -> None:
    assert len(figures()) == 9
    for figure in figures():
        assert set(figure.set.shown or ()) <= NAMES
        assert isinstance(scene_of(figure.set, load_scene("paper"), FOLDER), Scene)


def test_a_path_or_curve_that_is_shown_has_its_name_beside_it() -> None:
    lines = {"a_star", "dijkstra", "bellman_ford", "taut", "bspline", "quadratic"}
    steps = [step for lesson, _ in LESSONS.values() for step in lesson.steps]
    settings = [setting for step in steps for setting in step.settings]
    shown = [set(one.shown or ()) for one in (*settings, *(figure.set for figure in figures()))]
    assert sum(bool(lines & one) for one in shown) > 20
    assert all("names" in one for one in shown if lines & one)


SET = "set: {scene: mine.yaml}"
GOOD = """
title: Mine
steps:
  - text: "Length {{path.length}}"
    set: {scene: mine.yaml}
    question:
      text: Why?
      choices: [{text: a, right: true, why: b}, {text: c, why: d}]
"""


def folder_with(tmp_path: Path, content: str) -> Path:
    lessons = tmp_path / "lessons"
    lessons.mkdir()
    (lessons / "mine.yaml").write_text("version: 1\n", encoding="utf-8")
    (lessons / "own.yaml").write_text(content, encoding="utf-8")
    return lessons


def test_a_teacher_adds_a_folder(tmp_path: Path) -> None:
    lessons = load_lessons(folder_with(tmp_path, GOOD))
    assert len(lessons) == len(LESSONS) + 1
    assert lessons["own"][0].title == "Mine"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("path.length", "path.lenght", "own.yaml:4: page 1, text: expected a measure of "),
        ("title: Mine", "", "own.yaml:1: title: is missing"),
        ("right: true", "right: false", "own.yaml:6: page 1, question: expected choices of"),
        (
            "choices: [{",
            "choices: [] #",
            "own.yaml:8: page 1, question, choices: expected at least",
        ),
        (SET, "set: {search: {algorithm: magic}}", "own.yaml:5: page 1, set, search: expected"),
        (
            SET,
            "set: {camera: {position: [1, 2, 3], target: [1, 2, 3]}}",
            "own.yaml:5: page 1, set, camera: expected a position and a target apart from it",
        ),
        ("text: Why?", "txt: Why?", "own.yaml:6: page 1, question, text: is missing. (1 more: "),
        ("title: Mine", "title: [", "own.yaml:4: Expected valid YAML: "),
        ("title: Mine", "title: Mine\nversion: 1", "own.yaml:3: version: there is no such field"),
        ("title: Mine\nsteps", "obstacles", "own.yaml:1: This is no lesson, for it has no steps"),
    ],
)
def test_a_wrong_lesson_is_told_with_its_line_in_one_sentence(
    old: str, new: str, told: str, tmp_path: Path
) -> None:
    with pytest.raises(AbiError) as caught:
        load_lessons(folder_with(tmp_path, GOOD.replace(old, new)))
    assert caught.value.message.startswith(told)
    assert "\n" not in caught.value.message


def test_a_layer_that_does_not_exist_is_named_at_the_start(tmp_path: Path) -> None:
    content = GOOD.replace("{scene: mine.yaml}", "{shown: [nodes, nods]}")
    with pytest.raises(AbiError, match=r"own.yaml:4: page 1: There is no layer 'nods' among"):
        library(folder_with(tmp_path, content), NAMES)


FAULTY = """title: Faulty
steps:
  - text: "Length {path.length}, cost {{search.cost}}"
    set: {scene: other.yaml}
  - text: "Length {path.length}, cost {{search.cost}}"
    set: {scene: paper, change: {start: [3, 3, 3]}}
  - set: {scene: paper, change: {mesh: {pitch: 1}}, shown: [nods]}
    text: Now you.
    task:
      text: Set the spacing to 0.5 or less.
      until: [{measure: mesh.pitch, at_most: 0.5}]
      shown_by: {change: {mesh: {pitch: 0.5}}}
  - text: And again.
    task:
      text: Set it to 2 or less.
      until: [{measure: mesh.asked, at_most: 2}]
      shown_by: {change: {mesh: {pitch: -1}}}
"""


def test_everything_wrong_in_a_folder_is_told_at_once(tmp_path: Path) -> None:
    folder = folder_with(tmp_path, FAULTY)
    (folder / "broken.yaml").write_text("title: 1\nsteps: [{txt: b}]\n", encoding="utf-8")
    run = CliRunner().invoke(cli, ["lessons", "check", str(folder)])
    assert run.exit_code == 3
    lines = run.output.splitlines()
    expected = [
        "broken.yaml:1: title: expected a valid string",
        "broken.yaml:2: page 1, text: is missing",
        "broken.yaml:2: page 1, txt: there is no such field",
        "own.yaml:4: page 1, set: scene is",
        "own.yaml:5: page 2, text: a number needs two braces: {{path.length}}",
        "own.yaml:5: page 2, text: search.cost has no value here",
        "own.yaml:6: note: page 2, set: ",
        "own.yaml:7: page 3: There is no layer 'nods'",
        "own.yaml:12: page 3, task, shown_by: it does not do the task: mesh.pitch is 0.519615, ",
        "own.yaml:16: page 4, task, until: it is met before anything is done",
        "own.yaml:17: page 4, task, shown_by: mesh.pitch is -1",
        "10 faults.",
    ]
    for line, told in zip(lines, expected, strict=True):
        assert line.startswith(told)


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(AbiError, match="has no lesson"):
        load_lessons(tmp_path)
    (tmp_path / "scene.yaml").write_text("version: 1\n", encoding="utf-8")
    with pytest.raises(AbiError, match="has no lesson"):
        load_lessons(tmp_path)


def test_lessons_keep_what_they_are_given() -> None:
    data: dict[str, Any] = {"title": "a", "steps": [{"text": "b"}]}
    assert Lesson.model_validate(data).steps[0].text == "b"


@pytest.mark.slow
def test_a_lesson_goes_on_where_it_was_left(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel = session.panels.lessons
    until(lambda: len(panel.choice.options) == len(LESSONS) + 1)
    fake.set(panel.choice, panel.progress.titles[2])
    until(lambda: session.frame.theatre is not None and session.frame.theatre.name == "dijkstra")
    assert session.frame.theatre is not None
    assert session.frame.theatre.state.step == 24
    fake.set(panel.next, True)
    fake.set(panel.answers[0], True)
    until(lambda: "✗ No." in panel._reply.content)
    assert sum(button.label.startswith("✗") for button in panel.answers) == 1
    assert panel.answers[0].label.startswith("✗ ")
    assert panel.next.disabled
    fake.set(panel.answers[1], True)
    until(lambda: "✓ Right." in panel._reply.content and not panel.next.disabled)
    fake.set(panel.next, True)
    until(lambda: "### A*" in panel._text.content and session.resting)
    kept = panel.progress.kept
    fake.set(panel.choice, panel.choice.options[0])
    until(lambda: not panel._text.visible)
    panel.restore("{")
    panel.restore('{"lesson": "none", "step": 3, "passed": []}')
    assert panel.progress.step is None
    panel.restore(kept)
    assert panel.progress.kept == kept
    # another tab of the same browser begins at the same page once the lesson is chosen
    title = panel.choice.value
    fake.set(panel.choice, panel.choice.options[0])
    until(lambda: panel.progress.step is None)
    panel.progress.passed.clear()
    panel.recall(kept)
    fake.set(panel.choice, title)
    until(lambda: panel.progress.kept == kept)
    fake.set(panel.back, True)
    until(lambda: panel.progress.number == 0 and not panel.next.disabled)


def test_a_page_that_is_turned_to_again_says_nothing_that_is_no_longer_so(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    panel = session.panels.lessons
    until(lambda: len(panel.choice.options) == len(LESSONS) + 1)
    fake.set(panel.choice, panel.progress.titles[list(LESSONS).index("01-mesh")])
    for again in (False, True):
        until(lambda: "### A box" in panel._text.content and "obstacles" in session.frame.shown)
        until(lambda: not panel._after.visible and panel.next.disabled != again)  # noqa: B023
        fake.set(panel.answers[1], True)
        until(lambda: panel._after.visible and "obstacles" not in session.frame.shown)
        fake.set(panel.next, True)
        until(lambda: panel.progress.number == 1 and "obstacles" in session.frame.shown)
        if not again:
            fake.set(panel.show_me, True)
            until(lambda: panel._after.visible and not panel.show_me.visible)
            fake.set(panel.back, True)
    # the mesh is as coarse as at first, so the task may be done again
    until(lambda: panel.show_me.visible and not panel._after.visible)
    assert not panel.next.disabled
    fake.set(panel.show_me, True)
    until(lambda: panel._after.visible)


def test_a_lesson_is_told_of_over_the_scene(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panels = session.panels
    shown = panels.layout.overlay.shown
    until(lambda: session.resting and len(panels.lessons.choice.options) > 1)
    until(lambda: "Drag the orange box." in shown["message"])
    fake.set(panels.lessons.choice, panels.lessons.progress.titles[2])
    title = LESSONS["03-search"][0].title
    pages = len(LESSONS["03-search"][0].steps)
    place = f"<b>Lesson 3 of {len(LESSONS)}: {title}, page 1 of {pages}</b>"
    # what was planned before the choice may be drawn once more
    until(lambda: place in unescape(shown["message"]) and "Drag the orange" not in shown["message"])
    until(lambda: session.frame.theatre is not None)
    fake.set(panels.lessons.leave, True)
    until(lambda: "Lesson 3" not in shown["message"] and "Drag the orange box." in shown["message"])


def test_a_search_that_is_stepped_through_is_told_of_and_ended_over_the_scene(
    tab: tuple[FakeTab, Session],
) -> None:
    fake, session = tab
    panels = session.panels
    shown = panels.layout.overlay.shown
    fake.set(panels.theatre.on, True)
    until(lambda: "A search, step by step." in shown["message"])
    until(lambda: ">Close search</button>" in shown.get("lecture", ""))
    fake.set(panels.theatre.close, True)
    until(lambda: session.frame.theatre is None and "Drag the orange box." in shown["message"])
    assert not panels.theatre.on.value


def test_a_lesson_that_begins_ends_the_tour(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panels = session.panels
    until(lambda: session.resting and len(panels.lessons.choice.options) > 1)
    fake.set(panels.begin_tour, True)
    until(lambda: "1 of 5" in panels.layout.overlay.shown.get("tour", ""))
    fake.set(panels.lessons.choice, panels.lessons.choice.options[1])
    until(lambda: session.frame.lesson and not panels.layout.overlay.shown.get("tour", ""))
    fake.set(panels.begin_tour, True)
    until(lambda: "1 of 5" in panels.layout.overlay.shown.get("tour", ""))


def test_lessons_and_figures_give_back_what_they_replaced(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panels, lessons = session.panels, session.panels.lessons
    until(lambda: len(lessons.choice.options) == len(LESSONS) + 1)
    fake.set(panels.stages.fields["spline.degree"], 2)
    fake.set(panels.layer_switches.boxes["trace"], False)
    until(lambda: session.resting and "trace" not in session.frame.shown)
    scene, shown = session.frame.plan.scene, session.frame.shown

    def is_back() -> bool:
        frame = session.frame
        return frame.plan.scene == scene and frame.shown == shown and frame.theatre is None

    for leave in ("figure", "lesson", "both"):
        if leave != "lesson":
            fake.set(panels.figures.buttons[0], "3")
            until(lambda: session.frame.plan.scene.search.weight == "hops" and session.resting)
        if leave != "figure":
            fake.set(lessons.choice, lessons.progress.titles[2])
            until(lambda: session.frame.theatre is not None)
            assert not panels.figures._folder.visible
            assert not panels.figures.method.visible
            if leave == "lesson":
                fake.set(lessons.leave, True)
            else:
                fake.set(lessons.choice, lessons.choice.options[0])
        else:
            fake.set(panels.figures.back, True)
        until(is_back)
        assert not panels.figures.back.visible
        assert lessons.choice.value == lessons.choice.options[0]
        until(lambda: panels.figures._folder.visible and panels.figures.method.visible)


def test_a_lesson_left_after_a_reload_shows_the_layers_again(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    lessons = session.panels.lessons
    until(lambda: len(lessons.choice.options) == len(LESSONS) + 1)
    fake.set(lessons.choice, lessons.progress.titles[2])
    until(lambda: session.frame.theatre is not None and "arm" not in session.frame.shown)
    session._view._before = None
    fake.set(lessons.choice, lessons.choice.options[0])
    until(lambda: session.frame.theatre is None and session.frame.shown == SHOWN)


def test_a_figure_is_one_click(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    fake.set(session.panels.figures.buttons[0], "3")
    until(lambda: session.frame.plan.scene.search.weight == "hops" and session.resting)
    assert {"a_star", "dijkstra", "bellman_ford"} <= session.frame.shown
    assert "quadratic" not in session.frame.shown
    # what is hidden is not to be dragged
    message = session.panels.layout.overlay.shown
    until(lambda: "Drag the orange box." in message["message"])
    fake.set(session.panels.figures.buttons[0], "2")
    until(lambda: "Drag start or goal." in message["message"])


def test_numbers_beside_the_papers_have_the_pages_minus_sign() -> None:
    assert "+0.213, −0.099 for side 3" in _wrapped("+0.213, -0.099 for side 3")
    assert "B-spline, 1-2, 7e-13" in _wrapped("B-spline, 1-2, 7e-13")


def test_a_lesson_that_is_done_leads_to_the_next(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel = session.panels.lessons
    names, steps = list(LESSONS), LESSONS["01-mesh"][0].steps
    until(lambda: len(panel.choice.options) == len(LESSONS) + 1)
    until(lambda: panel._intro.content.count("<button") == len(LESSONS))
    assert "✓ done" not in panel._intro.content
    fake.set(panel.choice, panel.progress.titles[0])
    until(lambda: panel.progress.chosen)
    panel.progress.passed |= {("01-mesh", number) for number in range(len(steps))}
    for number in range(len(steps) - 1):
        assert not panel.next_lesson.visible
        fake.set(panel.next, True)
        until(lambda: panel.progress.number == number + 1 and panel._text.visible)  # noqa: B023
    until(lambda: panel.next_lesson.visible and not panel.next_lesson.disabled)
    fake.set(panel.next_lesson, True)
    until(lambda: panel.progress.place.startswith("Lesson 2 of"))
    assert panel.choice.value == panel.progress.titles[1]
    fake.set(panel.leave, True)
    until(lambda: not panel.progress.chosen and "✓ done" in panel._intro.content)
    cards = panel._intro.content.split("<button")[1:]
    assert [names[k] for k, card in enumerate(cards) if "✓ done" in card] == ["01-mesh"]
    assert [k for k, card in enumerate(cards) if "· next" in card] == [1]
    assert all("<img" in card for card in cards)


def test_a_lesson_gives_the_exercise_to_which_it_leads(
    tab: tuple[FakeTab, Session], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fake, session = tab
    panel, files = session.panels.lessons, dict[str, bytes]()
    monkeypatch.setattr(
        session.client,
        "send_file_download",
        lambda name, content, **_: files.update({name: content}),
    )
    until(lambda: len(panel.choice.options) == len(LESSONS) + 1)
    fake.set(panel.choice, panel.progress.titles[list(LESSONS).index("03-search")])
    until(lambda: panel.progress.chosen and panel._text.visible)
    assert not panel.exercises[SCRIPT].visible
    last = len(LESSONS["03-search"][0].steps) - 1
    panel.restore(
        json.dumps({"lesson": "03-search", "step": last, "passed": [["03-search", last]]})
    )
    session.wake(None)
    until(lambda: panel.exercises[SCRIPT].visible and panel.exercises[NOTEBOOK].visible)
    fake.set(panel.exercises[SCRIPT], True)
    fake.set(panel.exercises[NOTEBOOK], True)
    until(lambda: len(files) == 2)
    file = tmp_path / "mine.py"
    file.write_bytes(files["mine.py"])
    assert {one.name for one in exercises_in(file)} == {"priority", "heuristic"}
    assert json.loads(files["mine.ipynb"]) == notebook(("priority", "heuristic"))
    fake.set(panel.leave, True)
    until(lambda: not panel.progress.chosen and not panel.exercises[SCRIPT].visible)


def test_a_page_that_asks_gives_no_answer_away(tab: tuple[FakeTab, Session]) -> None:
    fake, session = tab
    panel, shown = session.panels.lessons, session.panels.layout.overlay.shown
    headings = session.panels.layout.folders
    until(lambda: len(panel.choice.options) == len(LESSONS) + 1)
    fake.set(panel.choice, panel.progress.titles[list(LESSONS).index("05-quadratic")])
    until(lambda: session.frame.asks and session.resting)
    until(lambda: not any(re.search("[✓✗]", str(one.label)) for one in headings.values()))
    assert not any(shown.get(part) for part in ("numbers", "contact"))
    fake.set(panel.answers[1], True)
    until(lambda: "✗" in str(headings["quadratic"].label))
    assert str(headings["arm"].label).endswith("Arm")  # which the lesson does not use
