"""Where a student is in the lessons, and what of them was passed."""

from __future__ import annotations

import json

from app.teach.lesson import NO_LESSONS, Lesson, Lessons, Question, Step


class LessonProgress:
    """Lesson and page of a student, and the pages passed.

    Attributes:
        lessons: all of them with their folders, by name; none until they are listed.
        name: of the lesson that is gone through; empty for none.
        number: of its page, from 0.
        answer: number of the answer that was given to the page's question; -1 for none.
        passed: lessons and pages that were passed.
        done: whether the page was passed since it was turned to.
        finished: the lesson that was gone through last, to its end.
    """

    def __init__(self) -> None:
        self.lessons: Lessons = NO_LESSONS
        self.name, self.number, self.answer = "", 0, -1
        self.passed: set[tuple[str, int]] = set()
        self.done, self.finished = False, ""

    def turn_to(self, name: str, number: int) -> None:
        """Turn to a page; no name ends the lesson."""
        self.name, self.number, self.answer, self.done = name, number, -1, False

    def pass_page(self) -> None:
        """Note that the page was passed."""
        self.passed.add((self.name, self.number))
        self.done = True

    @property
    def lesson(self) -> Lesson:
        """The lesson that is gone through."""
        return self.lessons[self.name][0]

    @property
    def passed_pages(self) -> int:
        """How many pages of the lesson were passed."""
        return sum((self.name, number) in self.passed for number in range(len(self.lesson.steps)))

    @property
    def chosen(self) -> bool:
        """Whether a lesson is gone through, which says itself what is shown."""
        return self.step is not None

    @property
    def step(self) -> Step | None:
        """The page; None where no lesson is gone through."""
        if self.name not in self.lessons:
            return None
        return self.lessons[self.name][0].steps[self.number]

    @property
    def asks(self) -> bool:
        """Whether the page asks a question that has not been answered yet."""
        step = self.step
        return step is not None and step.question is not None and not self.is_passed

    @property
    def question(self) -> Question | None:
        """The question of the page; None without one."""
        step = self.step
        return None if step is None else step.question

    @property
    def exercises(self) -> tuple[str, ...]:
        """Names of the exercises to which the page leads, once it was passed."""
        step = self.step
        return step.exercises if step is not None and self.is_passed else ()

    @property
    def place(self) -> str:
        """Lesson and page where the student is, as a text; empty where no lesson is chosen."""
        if self.step is None:
            return ""
        lesson, number = self.lessons[self.name][0], list(self.lessons).index(self.name) + 1
        return (
            f"Lesson {number} of {len(self.lessons)}: {lesson.title}, "
            f"page {self.number + 1} of {len(lesson.steps)}"
        )

    @property
    def kept(self) -> str:
        """Place of the student and the steps passed, as a text to keep."""
        if not self.name and not self.passed:
            return ""
        passed = sorted(self.passed)
        return json.dumps({"lesson": self.name, "step": self.number, "passed": passed})

    @property
    def is_passed(self) -> bool:
        """Whether the page was passed, or asks nothing."""
        step = self.step
        nothing_to_do = step is not None and step.question is None and step.task is None
        return nothing_to_do or (self.name, self.number) in self.passed

    @property
    def is_last(self) -> bool:
        """Whether the page is the lesson's last."""
        return self.number + 1 == len(self.lessons[self.name][0].steps)

    @property
    def titles(self) -> list[str]:
        """The lessons with their numbers, in order; none until they are listed."""
        return [
            f"{number}. {lesson.title}"
            for number, (lesson, _) in enumerate(self.lessons.values(), 1)
        ]

    def title(self, name: str) -> str:
        """A lesson's title with its number."""
        return self.titles[list(self.lessons).index(name)]

    @property
    def following(self) -> str:
        """The lesson after this one, or after the one finished last; empty behind the last."""
        names = list(self.lessons)
        name = self.name or self.finished
        place = names.index(name) + 1 if name in names else len(names)
        return names[place] if place < len(names) else ""

    def is_complete(self, name: str) -> bool:
        """Check whether all that a lesson asks was answered or done."""
        steps = self.lessons[name][0].steps
        asked = [k for k, one in enumerate(steps) if one.question or one.task]
        return bool(asked) and all((name, number) in self.passed for number in asked)

    def take(self, text: str) -> tuple[str, int] | None:
        """Take what a kept text says was passed; lesson and page where it stands, or None."""
        try:
            data = json.loads(text)
            name, number = str(data["lesson"]), int(data["step"])
            passed = {(str(a), int(b)) for a, b in data["passed"]}
        except (ValueError, TypeError, KeyError, RecursionError):
            return None
        self.passed |= {(a, b) for a, b in passed if a in self.lessons}
        known = name in self.lessons and 0 <= number < len(self.lessons[name][0].steps)
        return (name, number) if known else None
