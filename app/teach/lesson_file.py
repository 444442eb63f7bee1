"""Lesson files: strict reading that reports all faults at once."""

from __future__ import annotations

import functools
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.nodes import MappingNode, Node, SequenceNode

from abi import assets
from abi.errors import AbiError, SceneError
from abi.scene.scene import Scene
from abi.scene.scene_file import parse
from app.teach.lesson import Lesson, Lessons, Library

Place = Sequence[str | int]
"""Path of keys and indices to a part of a file."""
_COUNTED = {"steps": "page", "choices": "answer", "until": "condition"}
"""Names for the entries of lists, counted from 1."""
_LINE = re.compile(r" \(line (\d+)\)$")


@dataclass(frozen=True, order=True)
class LessonFault:
    """Something wrong in a lesson file.

    Attributes:
        file: its name.
        line: where, from 1 on.
        text: what, as a sentence.
        doubtful: whether it may be meant so.
    """

    file: str
    line: int
    text: str
    doubtful: bool = False

    def __str__(self) -> str:
        """The fault in the format of compilers, which editors can jump to."""
        return f"{self.file}:{self.line}: {'note: ' if self.doubtful else ''}{self.text}"


def load_lessons(folder: Path | None = None) -> Lessons:
    """The shipped lessons and those of a folder, by file name, each with its folder.

    Raises:
        AbiError: the folder has no lesson, or one is wrong; names file and field.
    """
    own = {} if folder is None else _read_all(lesson_files(folder))
    return _read_all(sorted(assets.path("lessons").glob("*.yaml"))) | own


def _read_all(files: Sequence[Path]) -> dict[str, tuple[Lesson, Path]]:
    found: dict[str, tuple[Lesson, Path]] = {}
    for file in files:
        lesson, faults = read_lesson(file)
        if lesson is None:
            more = f" ({len(faults) - 1} more: abi lessons check)" if faults[1:] else ""
            raise AbiError(f"{faults[0]}{more}")
        found[file.stem] = lesson, file.parent
    return found


def lesson_named(name: str) -> tuple[Lesson, Path]:
    """A shipped lesson by name, or one from a file, and its file.

    Raises:
        AbiError: there is none, or it is wrong.
    """
    shipped = {file.stem: file for file in assets.path("lessons").glob("*.yaml")}
    file = shipped.get(name, Path(name))
    if not file.is_file():
        known = ", ".join(sorted(shipped))
        raise AbiError(f"There is no lesson {name!r}; expected a file, or one of {known}.")
    lesson, faults = read_lesson(file)
    if lesson is None:
        raise AbiError(str(faults[0]))
    return lesson, file


def library(folder: Path, layers: Collection[str]) -> Library:
    """The shipped lessons and those of a folder, which is checked at once.

    Args:
        folder: of a teacher's own.
        layers: names that ``shown`` may have.

    Raises:
        AbiError: as :func:`load_lessons`, or a layer has another name.
    """
    read = functools.cache(functools.partial(load_lessons, folder))
    for name, (lesson, place) in read().items():
        if place == folder:
            for fault in unknown_layers(folder / f"{name}.yaml", lesson, layers):
                raise AbiError(str(fault))
    return read


def lesson_files(folder: Path) -> list[Path]:
    """The lesson files in a folder, in order; scene files may lie beside them.

    Raises:
        AbiError: there is none.
    """
    files = [file for file in sorted(folder.glob("*.yaml")) if not _is_scene(file)]
    if not files:
        raise AbiError(f"--lessons: {str(folder)!r} has no lesson; expected *.yaml in it.")
    return files


def read_lesson(file: Path) -> tuple[Lesson | None, tuple[LessonFault, ...]]:
    """The lesson of a file, None if it is invalid, and its faults in line order."""
    try:
        data = parse(file)
    except SceneError as error:
        line = _LINE.search(error.expected)
        text = f"Expected {_LINE.sub('', error.expected)}."
        return None, (LessonFault(file.name, int(line[1]) if line else 1, text),)
    if isinstance(data, dict) and "steps" not in data and set(data) & set(Scene.model_fields):
        text = "This is no lesson, for it has no steps, and no scene, for it has no version."
        return None, (LessonFault(file.name, 1, text),)
    try:
        return Lesson.model_validate(data), ()
    except ValidationError as error:
        details = error.errors(include_url=False)
    # pydantic counts only what is right in a list, and calls it too short as well
    wrong_inside = {one["loc"][:k] for one in details for k in range(len(one["loc"]))}
    told = [one for one in details if one["loc"] not in wrong_inside or one["type"] != "too_short"]
    return None, tuple(sorted(fault_at(file, one["loc"], sentence_of(one)) for one in told))


def unknown_layers(file: Path, lesson: Lesson, layers: Collection[str]) -> tuple[LessonFault, ...]:
    """Faults of unknown layers that a lesson shows."""
    return tuple(
        fault_at(file, ("steps", number), f"There is no layer {name!r} among {known}.")
        for known in [", ".join(sorted(layers))]
        for number, step in enumerate(lesson.steps)
        for setting in step.settings
        for name in setting.shown or ()
        if name not in layers
    )


def fault_at(file: Path, place: Place, text: str, doubtful: bool = False) -> LessonFault:
    """A fault of the part of a file at ``place``, with which the sentence begins."""
    named = _named(place)
    sentence = f"{named}: {text}" if named else text
    return LessonFault(file.name, _line(file, place), sentence, doubtful)


def _named(place: Place) -> str:
    """The location ``place`` in words, such as "page 2, question"."""
    words: list[str] = []
    for key in place:
        if isinstance(key, int) and words:
            words[-1] = f"{_COUNTED.get(words[-1], words[-1])} {key + 1}"
        else:
            words.append(str(key))
    return ", ".join(words)


def sentence_of(detail: Any) -> str:
    """A pydantic error in our words."""
    match detail["type"]:
        case "missing":
            return "is missing."
        case "extra_forbidden":
            return "there is no such field here."
        case "too_short":
            return f"expected at least {detail['ctx']['min_length']}."
        case "too_long":
            return f"expected at most {detail['ctx']['max_length']}."
    message = re.sub(r"^(Value error, |\w+ should (be|have) )", "", detail["msg"])
    return f"expected {message}."


def _line(file: Path, place: Place) -> int:
    """Line of the part at ``place``, or of its nearest existing parent."""
    node: Node | None = YAML(typ="safe", pure=True).compose(file.read_text(encoding="utf-8-sig"))
    line = 1
    for key in place:
        if isinstance(node, MappingNode):
            entry = next((one for one in node.value if one[0].value == str(key)), None)
            if entry is None:
                return line
            line, node = entry[0].start_mark.line + 1, entry[1]
        elif isinstance(node, SequenceNode) and isinstance(key, int) and key < len(node.value):
            node = node.value[key]
            line = node.start_mark.line + 1
        else:
            return line
    return line


def _is_scene(file: Path) -> bool:
    """Check whether a file is a scene instead of a lesson: only scenes have a version."""
    try:
        data = parse(file)
    except SceneError:  # told where the file is read
        return False
    return isinstance(data, dict) and "version" in data and "steps" not in data
