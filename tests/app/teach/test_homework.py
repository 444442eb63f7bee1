from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from abi import load_scene, plan
from abi.errors import AbiError
from abi.scene.arm_settings import ArmSettings
from abi.scene.scene import Scene
from app.cli.command_line import cli
from app.state.frame import Frame
from app.teach.challenge import MAY_CHANGE, TASK, parsed
from app.teach.homework import Homework, read_homework
from app.teach.lesson import Condition
from app.teach.result_code import fingerprint, result_code, scene_of_code

KEEP = (*TASK, "search.taut")
FILE = """text: Bring the path along the edges down to 12.2 cm
scene: paper
until: [{measure: path.length, at_most: 12.2}]
keep: [search.taut]
"""
GOAL = Condition(measure="path.length", at_most=9)
MOVED = {"shape": "box", "size": [1, 1, 1], "position": [1, 4, 1]}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "homework.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


@settings(deadline=None, max_examples=30)
@given(
    pitch=st.floats(0.5, 3),
    lattice=st.sampled_from(["bcc", "kuhn", "delaunay"]),
    degree=st.integers(2, 5),
    speed=st.floats(0.5, 9),
    taut=st.booleans(),
)
def test_a_code_says_all_but_what_has_to_stay(
    pitch: float, lattice: str, degree: int, speed: float, taut: bool
) -> None:
    task = load_scene("paper")
    changes: dict[str, Any] = {
        "mesh": {"pitch": pitch, "lattice": lattice},
        "spline": {"degree": degree},
        "motion": {"speed": speed},
    }
    own = task.replace(**changes, search={"taut": taut}, obstacles=[MOVED])
    code = result_code(own, KEEP)
    assert len(code) < 200
    assert scene_of_code(code, task, KEEP) == task.replace(**changes)


@given(st.text(max_size=80))
def test_what_is_no_code_is_refused(text: str) -> None:
    with pytest.raises(AbiError, match="code"):
        scene_of_code(text, Scene(version=1), KEEP)


def test_a_code_that_lacks_a_letter_is_refused() -> None:
    code = result_code(load_scene("paper").replace(mesh={"pitch": 0.8}), KEEP)
    for k in range(len(code)):
        with pytest.raises(AbiError, match="code"):
            scene_of_code(code[:k] + code[k + 1 :], load_scene("paper"), KEEP)


def test_a_code_cannot_change_what_has_to_stay() -> None:
    task = load_scene("paper")
    code = result_code(task.replace(search={"taut": True}, start=[1, 0, 0]), ("goal",))
    assert scene_of_code(code, task, ("goal",)).start == (1, 0, 0)
    kept = scene_of_code(code, task, KEEP)
    assert (kept.start, kept.search.taut) == (task.start, task.search.taut)


def test_every_field_has_to_stay_or_is_a_choice() -> None:
    of_arm = [f"arm.{name}" for name in ArmSettings.model_fields]
    sections = [name for name in Scene.model_fields if name not in ("version", "arm")]
    assert sorted((*TASK, *MAY_CHANGE)) == sorted((*sections, *of_arm, "floor"))


@pytest.mark.parametrize(
    "change",
    [
        {"tasks": []},
        *({"arm": {end: None}} for end in ("start", "goal")),
        {"arm": {"allowed": [["panda_hand", 0]]}},
        {"arm": {"gripper": "closed"}},
        {"tasks": [], "arm": {"attached": MOVED}},
        {"arm": {"axis": {"direction": [0, 0, -1], "tolerance": 0.1}}},
    ],
)
def test_what_else_defines_the_problem_has_to_stay(change: dict[str, Any]) -> None:
    task = load_scene("pick-and-place")
    own = task.replace(**change)
    assert fingerprint(own, TASK) != fingerprint(task, TASK)
    assert scene_of_code(result_code(own, TASK), task, TASK) == task


@pytest.mark.parametrize(
    ("change", "stays"),
    [
        ({"workspace": {"min": [-1, -1, -1]}}, False),
        ({"arm": {"base": [0, 0, -0.5]}}, False),
        ({"arm": {"base": [0.1, 0, 0.3]}, "workspace": {"min": [-2, -1, 0]}}, True),
    ],
)
def test_the_floor_stays_where_workspace_and_base_are_free(
    change: dict[str, Any], stays: bool
) -> None:
    task = load_scene("paper").replace(workspace={"min": [-1, -1, 0]}, arm={"base": [0, 0, 0]})
    own = task.replace(**change)
    assert (fingerprint(own, TASK) == fingerprint(task, TASK)) == stays
    assert scene_of_code(result_code(own, TASK), task, TASK) == own  # told when it is graded


def test_a_part_that_is_free_is_free_with_what_the_arm_has_there() -> None:
    def kept(*free: str) -> set[str]:
        return {*Homework(text="a", until=(GOAL,), free=free).kept}

    assert kept() == {*TASK}
    assert {*TASK} - kept("goal") == {"goal", "arm.goal"}
    assert {*TASK} - kept("arm.a3", "obstacles") == {"arm.a3", "obstacles"}
    assert not any(name.startswith("arm") for name in kept("arm"))


def test_who_reaches_the_goal_is_given_a_code_that_is_right(file: Path, tmp_path: Path) -> None:
    task, challenge = read_homework(file)
    assert parsed(challenge.model_dump_json()) == challenge
    done = Frame(plan(task.replace(mesh={"lattice": "delaunay", "pitch": 0.8})))
    assert challenge.is_met(done)
    shown = challenge.html(True, done)
    code = result_code(done.plan.scene, challenge.keep)
    assert f">{code}</code>" in shown
    near = result_code(task, challenge.keep)
    codes = tmp_path / "codes.csv"
    codes.write_text(f"ada,{code}\nbob,{near}\neve,{code}\nkim,abcd\n\n", encoding="utf-8")
    run = CliRunner().invoke(cli, ["lessons", "grade", str(file), str(codes)])
    assert run.exit_code == 3
    rows = run.output.splitlines()
    assert rows[:2] == ["name,reached,why not", "ada,yes,"]
    assert rows[2] == 'bob,no,"path.length is 12.4388, asked is at most 12.2."'
    assert rows[3] == "eve,no,the same code as ada."
    assert rows[4].startswith("kim,no,")
    heads, part = "Your name,Code", f"ida,{code[:-1]}"
    for first, names in ((heads, ["ada"]), (part, ["ida", "ada"])):
        codes.write_text(f"{first}\nada,{code}\n", encoding="utf-8")
        run = CliRunner().invoke(cli, ["lessons", "grade", str(file), str(codes)])
        assert [row.split(",")[0] for row in run.stdout.splitlines()[1:]] == names
        assert ("Your name, Code" in run.stderr) == (first == heads)
        assert run.exit_code == (0 if first == heads else 3)


@pytest.mark.parametrize("keep", [[], ["unit"], ["nothing", "start.x", "mesh.x.y", "."]])
def test_a_link_with_any_fields_harms_nobody(keep: list[str]) -> None:
    goal = {"measure": "path.length", "at_most": 99}
    data = {"text": "a", "until": [goal], "task": "0", "keep": keep, "homework": True}
    challenge = parsed(json.dumps(data))
    assert challenge is not None
    frame = Frame(plan(load_scene("paper")))
    assert not challenge.is_met(frame)
    assert "have changed" in challenge.html(True, frame)


def test_straightening_the_path_is_seen_where_it_has_to_stay(file: Path) -> None:
    task, challenge = read_homework(file)
    taut = not task.search.taut
    frame = Frame(plan(task.replace(search={"taut": taut}, mesh={"pitch": 0.8})))
    assert not challenge.is_met(frame)
    assert "search.taut" in challenge.html(False, frame)


def test_the_link_opens_the_homework_and_fits_a_qr_code(file: Path, tmp_path: Path) -> None:
    for ending, begin in ((".svg", b"<?xml"), (".png", b"\x89PNG")):
        picture = tmp_path / f"link{ending}"
        arguments = ["--url", "http://localhost:8080/?token=abc", "--qr", str(picture)]
        run = CliRunner().invoke(cli, ["lessons", "homework", str(file), *arguments])
        assert run.exit_code == 0, run.output
        assert picture.read_bytes().startswith(begin)
    link = run.output.strip()
    assert link.startswith("http://localhost:8080/?token=abc&state=")
    state = link.split("state=")[1]
    assert base64.urlsafe_b64decode(state + "=" * (-len(state) % 4))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("12.2}", "20}", "homework.yaml:3: until: the goal is reached before anything"),
        ("search.taut", "search.tight", "not search.tight"),
        ("path.length", "path.lenght", "homework.yaml:3: condition 1: expected one of the"),
        ("text:", "txt:", "homework.yaml:1: text: is missing"),
    ],
)
def test_a_wrong_homework_is_told(file: Path, old: str, new: str, told: str) -> None:
    file.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.raises(AbiError) as caught:
        read_homework(file)
    assert told in caught.value.message
