"""Homework: a scene, a goal on any measure, protected fields, and grading."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from abi.errors import AbiError
from abi.planner.planner import Planner, plan
from abi.scene.arm_end import ENDS
from abi.scene.scene import Scene
from abi.scene.scene_file import parse
from abi.scene.section import Settings
from app.state.frame import Frame
from app.state.tab_state import TabState
from app.teach.challenge import TASK, Challenge, whole_plan
from app.teach.lesson import Condition, Setting, scene_of
from app.teach.lesson_file import fault_at, sentence_of
from app.teach.result_code import FLOOR, fingerprint, scene_of_code


class Homework(Settings):
    """A homework as in its file.

    Attributes:
        text: what to do, in words.
        scene: name of a shipped scene, or a scene file beside it.
        change: fields of the scene to change after that.
        until: conditions, all of which must hold.
        keep: fields that must stay beside those of the task, such as ``search.taut``.
        free: fields of the task that may change all the same; a section's name frees all of it, and
            ``start`` or ``goal`` what the arm has there, too.
    """

    text: Annotated[str, Field(min_length=1, max_length=200)]
    scene: str = "paper"
    change: dict[str, Any] | None = None
    until: Annotated[tuple[Condition, ...], Field(min_length=1, max_length=3)]
    keep: Annotated[tuple[str, ...], Field(max_length=8)] = ()
    free: tuple[str, ...] = ()

    @property
    def kept(self) -> tuple[str, ...]:
        """Names of all protected fields."""
        free = {*self.free, *(f"arm.{end}" for end in ENDS if end in self.free)}
        task = (name for name in TASK if not {name, name.partition(".")[0]} & free)
        return tuple(dict.fromkeys((*task, *self.keep)))


def read_homework(file: Path) -> tuple[Scene, Challenge]:
    """The scene of a homework file, and the challenge in it.

    Raises:
        AbiError: the file is wrong, or its goal is reached before anything is done.
        SceneError: its scene cannot be read.
    """
    try:
        given = Homework.model_validate(parse(file))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise AbiError(str(fault_at(file, first["loc"], sentence_of(first)))) from None
    setting = Setting(scene=given.scene, change=given.change)
    scene = scene_of(setting, Scene(version=1), file.parent)
    known = {*Scene.model_fields, *_settings(scene), FLOOR}
    for name in (*given.keep, *given.free):
        if name not in known:
            text = f"keep and free name fields such as search.taut, not {name}."
            raise AbiError(str(fault_at(file, ("keep",), text)))
    challenge = Challenge(
        text=given.text,
        until=(*given.until, whole_plan(scene)),
        task=fingerprint(scene, given.kept),
        keep=given.kept,
        homework=True,
    )
    if challenge.is_met(Frame(plan(scene))):
        text = "the goal is reached before anything is done."
        raise AbiError(str(fault_at(file, ("until",), text)))
    return scene, challenge


def homework_link(file: Path, server: str) -> str:
    """URL that opens a homework on a server, whose own URL may have a token.

    Raises:
        AbiError: as :func:`read_homework`.
    """
    scene, challenge = read_homework(file)
    state = TabState(name="homework", scene=scene, challenge=challenge.model_dump_json())
    return f"{server}{'&' if '?' in server else '?'}state={state.encode()}"


def faults_of(file: Path, results: Sequence[tuple[str, str]]) -> list[tuple[str, ...]]:
    """What each result of a homework lacks, as sentences; none where the goal is reached.

    Args:
        file: the homework.
        results: names and the codes that they handed in, whose scenes are planned again.

    Raises:
        AbiError: as :func:`read_homework`.
    """
    scene, challenge = read_homework(file)
    first, planner = dict[str, str](), Planner()
    found = []
    for name, code in results:
        faults = _faults(code, scene, challenge, planner)
        if code in first:
            faults = (*faults, f"the same code as {first[code]}.")
        first.setdefault(code, name)
        found.append(faults)
    return found


def _faults(code: str, task: Scene, challenge: Challenge, planner: Planner) -> tuple[str, ...]:
    try:
        scene = scene_of_code(code, task, challenge.keep)
    except AbiError as error:
        return (error.message,)
    frame = Frame(planner(scene))
    if not challenge.keeps_task(frame):  # what is free, such as tasks, may say where the goal is
        return (f"{challenge.changed} have changed.",)
    missed = [one for one in challenge.until if not one.holds(frame)]
    return tuple(f"{one.missed(frame)}." for one in missed)


def _settings(scene: Scene) -> list[str]:
    """Dotted names of all fields of a scene's sections, such as ``mesh.pitch``."""
    data = scene.model_dump(mode="json")
    return [
        f"{name}.{key}" for name, part in data.items() if isinstance(part, dict) for key in part
    ]
