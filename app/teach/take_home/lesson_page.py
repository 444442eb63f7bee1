"""A lesson as a single HTML page that works from a file, without server or network.

Every plan that the lesson leads to is in it. Nothing can be planned anew there, so a task is shown
and not done.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from markdown_it import MarkdownIt

from abi.errors import AbiError
from abi.export.html_page import page_data, page_of, rounded
from abi.planner.planner import Planner
from app.state.frame import Frame
from app.teach.exercise_files import exercise_files
from app.teach.lesson import Lesson, Step
from app.teach.measures import filled
from app.teach.rehearsal import Take, rehearsal
from app.theatre.theatre import Theatre, priorities
from app.ui.formulas import with_formulas

_DRAWN = {
    "obstacles": ("obstacles",),
    "edges": ("edges",),
    "nodes": ("nodes",),
    "excluded": ("removed",),
    "a_star": ("a_star",),
    "dijkstra": ("dijkstra",),
    "bellman_ford": ("bellman_ford",),
    "taut": ("taut",),
    "bspline": ("bspline",),
    "control": ("control",),
    "quadratic": ("quadratic",),
    "arm": ("arm",),
    "trace": ("tool",),
}
"""What each layer draws in the page; the other layers are left out."""
_MARKDOWN = MarkdownIt("commonmark", {"html": True})


def lesson_page(name: str, lesson: Lesson, folder: Path) -> bytes:
    """The page of a lesson.

    Args:
        name: of its file, under which a browser remembers how far one has come.
        lesson: the lesson.
        folder: of the scenes that it names.

    Raises:
        SceneError: a page's scene cannot be read.
        AbiError: a page's scene has no mesh, so there is nothing to show.
    """
    take, shown = rehearsal(folder, Planner()), list[Frame]()
    pages = [_page(step, take, shown) for step in lesson.steps]
    plans = [page_data(frame.plan) | _paths(frame) for frame in shown]
    data = {"name": name, "title": lesson.title, "pages": pages, "plans": plans}
    return page_of("lesson.html", data)


def _page(step: Step, take: Take, shown: list[Frame]) -> dict[str, Any]:
    """Texts of a page with numbers filled in, and the views before and after it is passed.

    Args:
        step: the page.
        take: rehearses the lesson, which was taken up to it.
        shown: a frame of each plan that the lesson has shown, to which those of the page are added.
    """
    before = take(step.set)
    seen = _view(before, shown)
    question, task = step.question, step.task
    asking = "" if question is None else question.text
    if task is not None:
        asking = f"➜ {task.text} {task.now} *(In the visualiser: this page plans nothing anew.)*"
        take(task.shown_by)
    after = take(step.reveal)
    choices = () if question is None else question.choices
    return {
        "text": _html(step.text, before),
        "asking": _html(asking, before),
        "choices": [
            {
                "text": _html(one.text, before, inline=True),
                "right": one.right,
                "why": _html(one.why, after if one.right else before),
            }
            for one in choices
        ],
        "task": task is not None,
        "passed": question is None and task is None,
        "after": _html(step.after, after),
        "files": exercise_files(step.exercises) if step.exercises else {},
        "before": seen,
        "revealed": _view(after, shown),
    }


def _view(frame: Frame, shown: list[Frame]) -> dict[str, Any]:
    """What is drawn of a frame, and of which plan."""
    if frame.plan.free is None:
        raise AbiError("A page's scene has no mesh, so there is nothing to show.")
    numbers = [k for k, one in enumerate(shown) if one.plan is frame.plan]
    if not numbers:
        shown.append(frame)
    drawn = [name for layer in sorted(frame.shown) for name in _DRAWN.get(layer, ())]
    search = None if frame.theatre is None else _search(frame.theatre)
    return {
        "plan": numbers[0] if numbers else len(shown) - 1,
        "draw": drawn if search is None else ["obstacles", "search"],
        "search": search,
    }


def _paths(frame: Frame) -> dict[str, Any]:
    """The path of each search of a plan."""
    return {one.algorithm: rounded(one.points) for one in frame.plan.searches}


def _search(theatre: Theatre) -> dict[str, Any]:
    """A search at its step: places of visited nodes in order, and of waiting ones."""
    state, trace = theatre.state, theatre.state.trace
    points, n = trace.arcs.points, len(trace.arcs.points)
    order = trace.order[trace.order >= 0] % n
    share = state.step / trace.steps if trace.steps else 1.0
    waiting = state.open[np.argsort(priorities(state), kind="stable")]
    return {
        "order": rounded(points[order]),
        "path": rounded(points[trace.vertices]),
        "visited": rounded(points[state.closed % n]),
        "waiting": rounded(points[waiting % n]),
        "trail": rounded(points[state.path() % n]),
        "share": share if len(order) else 1.0,
    }


def _html(text: str, frame: Frame, inline: bool = False) -> str:
    """A lesson's text as HTML, with numbers and formulas."""
    content = with_formulas(filled(text, frame))
    return str(_MARKDOWN.renderInline(content) if inline else _MARKDOWN.render(content))
