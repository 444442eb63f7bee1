"""Lessons as data: YAML files with Markdown texts, checked when they are read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, PlainValidator, model_validator

from abi.obstacles.pose import Vec3
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.section import Settings
from abi.search.compare import COMPARED
from abi.teach.catalogue import exercises
from app.camera.view import View
from app.state.frame import Frame
from app.teach.measures import MEASURES, names_in
from app.theatre.searches import EDGES


def _with_known_measures(text: str) -> str:
    """A text, each of whose numbers is a measure."""
    for name in names_in(text):
        if name not in MEASURES:
            raise ValueError(f"a measure of {', '.join(MEASURES)}, not {name}")
    return text


Text = Annotated[str, AfterValidator(_with_known_measures)]
"""A text in which ``{{path.length}}`` stands for a number."""


class Condition(Settings):
    """A measure and the range that it must be in."""

    measure: str
    at_least: float | None = None
    at_most: float | None = None

    @model_validator(mode="after")
    def _measure_exists(self) -> Self:
        if self.measure not in MEASURES:
            raise ValueError(f"one of the measures {', '.join(MEASURES)}")
        if self.at_least is None and self.at_most is None:
            raise ValueError("at_least or at_most")
        return self

    def holds(self, frame: Frame) -> bool:
        """Check whether the condition holds; a measure without a value never does."""
        number = MEASURES[self.measure](frame)
        return number is not None and (
            (self.at_least is None or number >= self.at_least - 1e-9)
            and (self.at_most is None or number <= self.at_most + 1e-9)
        )

    def missed(self, frame: Frame) -> str:
        """Clause on the present value and the one asked for."""
        number = MEASURES[self.measure](frame)
        now = "has no value" if number is None else f"is {number:.6g}"
        asked = [
            f"{word} {bound:g}"
            for word, bound in (("at least", self.at_least), ("at most", self.at_most))
            if bound is not None
        ]
        return f"{self.measure} {now}, asked is {' and '.join(asked)}"


class SearchCue(Settings):
    """State of the search that is stepped through."""

    on: bool = True
    algorithm: str | None = None
    step: Annotated[int, Field(ge=0)] | None = None
    weight: Annotated[float, Field(ge=0, le=2)] | None = None
    edges: str | None = None
    ask: bool | None = None
    race: bool | None = None

    @model_validator(mode="after")
    def _search_exists(self) -> Self:
        if self.algorithm is not None and self.algorithm not in COMPARED:
            raise ValueError(f"one of the searches {', '.join(COMPARED)}")
        if self.edges not in (None, *EDGES):
            raise ValueError(f"edges of {', '.join(EDGES)}")
        return self


def _upright(camera: object) -> View:
    """The view of a camera of a lesson, with z upwards."""
    match camera:
        case {"position": position, "target": target, **others} if not others:
            if view := View.of([position, target, (0.0, 0.0, 1.0)]):
                return view
    raise ValueError("a position and a target apart from it, three numbers each")


class Setting(Settings):
    """Settings of a step; only the given ones apply.

    Attributes:
        scene: name of a shipped scene, or a scene file beside the lesson; the camera turns to it.
        change: fields of the scene to change after that.
        shown: layers to show; all others are hidden.
        camera: where to look from: in a file a position and a target, [unit], world.
        search: of the theatre.
        bend: displacements of the B-spline's control points, by their numbers, [unit].
        time: of the motion, [s]; it stands still there.
        play: whether the motion plays.
    """

    scene: str | None = None
    change: dict[str, Any] | None = None
    shown: tuple[str, ...] | None = None
    camera: Annotated[View, PlainValidator(_upright)] | None = None
    search: SearchCue | None = None
    bend: dict[int, Vec3] | None = None
    time: Annotated[float, Field(ge=0)] | None = None
    play: bool | None = None


class AnswerChoice(Settings):
    """One answer to a question, and the reply to it."""

    text: Text
    right: bool = False
    why: Text


class Question(Settings):
    """A question with answers to choose from, asked before the explanation."""

    text: Text
    choices: Annotated[tuple[AnswerChoice, ...], Field(min_length=2, max_length=4)]

    @model_validator(mode="after")
    def _one_is_right(self) -> Self:
        if sum(choice.right for choice in self.choices) != 1:
            raise ValueError("choices of which exactly one is right")
        return self


class Task(Settings):
    """Something to do; the lesson waits until all its conditions hold.

    Attributes:
        text: what to do.
        now: how far it is; hidden where it was done and is so no more.
        until: conditions.
        shown_by: what does it, for those who are stuck.
    """

    text: Text
    now: Text = ""
    until: Annotated[tuple[Condition, ...], Field(min_length=1)]
    shown_by: Setting

    def is_done(self, frame: Frame) -> bool:
        """Check whether all conditions hold."""
        return all(condition.holds(frame) for condition in self.until)


class Step(Settings):
    """One page of a lesson.

    Attributes:
        set: what it sets when it begins.
        text: what to look at, Markdown with formulas between dollars, numbers as
            ``{{path.length}}``.
        question: asked before ``after`` is revealed.
        task: to be done before it is.
        reveal: what is set then.
        after: text that is shown then.
        exercises: names of those that can be downloaded then.
    """

    text: Text
    set: Setting = Setting()
    question: Question | None = None
    task: Task | None = None
    reveal: Setting = Setting()
    after: Text = ""
    exercises: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _exercises_exist(self) -> Self:
        if set(self.exercises) - set(exercises()):
            raise ValueError(f"in exercises names of {', '.join(exercises())}")
        return self

    @property
    def settings(self) -> tuple[Setting, ...]:
        """What the page may set, in the order in which it does."""
        shown_by = () if self.task is None else (self.task.shown_by,)
        return (self.set, *shown_by, self.reveal)


class Lesson(Settings):
    """A lesson.

    Attributes:
        title: in the list.
        minutes: that it takes.
        steps: in order.
    """

    title: Annotated[Text, Field(min_length=1, max_length=60)]
    minutes: Annotated[int, Field(ge=1, le=120)] = 5
    steps: Annotated[tuple[Step, ...], Field(min_length=1, max_length=40)]


Lessons = Mapping[str, tuple[Lesson, Path]]
"""Lessons by file name, each with its folder."""
NO_LESSONS: Lessons = MappingProxyType({})
Library = Callable[[], Lessons]
"""Function that reads the lessons at the first call and remembers them."""


def scene_of(setting: Setting, scene: Scene, folder: Path) -> Scene:
    """The scene that a step sets, starting from ``scene``.

    Raises:
        SceneError: it cannot be read, or a change is wrong.
    """
    if setting.scene is not None:
        file = folder / setting.scene
        known = setting.scene in scene_names()
        scene = load_scene(setting.scene if known else file)
    return scene.replace(**setting.change) if setting.change else scene
