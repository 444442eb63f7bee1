"""What a search that is stepped through says: its step in words and numbers, and its legend."""

from __future__ import annotations

import numpy as np

from abi.scene.scene import Scene
from abi.search.compare import COMPARED
from abi.search.replay import SearchState
from app.theatre.compared import LETTERS, asks_for_sums, lettered
from app.theatre.theatre import Theatre, formula, labels, order_label, priorities, where
from app.ui import style
from app.ui.numbers import format_count, format_length
from app.ui.table import table

_PLACES = ("next", "2nd", "3rd", "4th", "5th")
"""Names of the nodes at the queue's head that are shown."""
_RING = '<i class="abi-disc abi-ring"></i>'


def describe(theatre: Theatre, scene: Scene) -> str:
    """The step in words and numbers, as HTML.

    A row of the table has its node's place, so that the page finds the one by the other.
    """
    state = theatre.state
    trace, n = state.trace, len(state.trace.arcs.points)
    text = f"<b>{COMPARED[theatre.name].label}</b>, {_counts(state)}"
    if state.done:
        text += f" {_end(state, scene.unit)}"
    elif tied := _ties(theatre):
        text += f" {tied}"
    named = [
        (f"{_disc(style.MARK)}visited last", state.current, ""),
        (f"{_disc(style.POINT)}clicked", theatre.clicked, ""),
    ]
    if not theatre.asking and not state.done and trace.queue != "rounds":
        queue = state.queue(len(_PLACES)).tolist()
        sides = (" ←" if node >= n else "" for node in queue)
        named += zip(_PLACES, queue, sides, strict=False)
    named += [(_choice(theatre, letter), node, "") for letter, node in lettered(theatre).items()]
    columns = 1 if formula(state) == "g" and trace.queue == "best_first" else 3  # h has no part
    rows = [
        (_at(state, node, f"{name} {where(state, node)}{side}"), *node_row(theatre, node)[:columns])
        for name, node, side in named
        if node >= 0
    ]
    text = style.paragraph(text)
    if rows:
        cost = _unit(scene)
        last = "no. in line" if trace.queue == "first_in" else f"f [{cost}]"
        numbers = (f"g so far [{cost}]", f"h to go [{cost}]", last)[:columns]
        text += table((f"node at [{scene.unit}]", *numbers), rows)
    if theatre.asking and not state.done:
        text += style.paragraph(f"{question(theatre)} {_rule(theatre)}")
    if theatre.said:
        text += style.paragraph(theatre.said)
    return text


def _choice(theatre: Theatre, letter: str) -> str:
    """A letter whose row answers with it, as the letter in the scene does."""
    return f'<b data-choose="{theatre.widget}" data-value="{letter}">{letter}</b>'


def _counts(state: SearchState) -> str:
    """The step, and what was visited, waits and was tried until then, as the tables count it."""
    trace, tried = state.trace, f"{format_count(state.examined)} edges tried."
    of = f"{format_count(state.step)} of {format_count(trace.steps)}"
    waiting = format_count(len(state.open))
    if trace.queue == "rounds":  # each goes over all nodes that are reached
        reached = format_count(int(np.isfinite(state.cost).sum()))
        return f"round {of}: {reached} nodes reached, {waiting} of them cheaper by it, {tried}"
    again = state.step - len(np.unique(trace.order[: state.step]))
    visited = f"{format_count(state.step)} visited"
    if again:
        visited += f", {format_count(again)} of them again"
    return f"step {of}: {visited}, {waiting} waiting, {tried}"


def question(theatre: Theatre) -> str:
    """The question which node is next, as HTML."""
    asked, letters = "<b>Which node is visited next?</b>", "".join(lettered(theatre))
    if len(letters) < 2:
        return f"{asked} Click or tap one of those that wait."
    named = f"{', '.join(letters[:-1])} and {letters[-1]}"
    if LETTERS.startswith(letters) and len(letters) > 2:
        named = f"{letters[0]} to {letters[-1]}"
    return f"{asked} It is one of {named}: compare them, and click or tap it."


def _rule(theatre: Theatre) -> str:
    """Which of those that wait is next, in words."""
    state = theatre.state
    if state.trace.queue == "rounds":
        return "In a round all are."
    if state.trace.queue == "first_in":
        return (
            "It is the one that waits longest, with the least number in line: first in, first out."
        )
    rule = f"It has the least {_ordering(state)} of all that wait; where several tie, any is right."
    letters = len(lettered(theatre))
    if 1 < letters < len(state.open):
        rule += " None without a letter has less."
    if formula(state) == "g + h" and asks_for_sums(theatre) and letters > 1:
        return f"{rule} Add g and h at each letter."
    return rule


def node_row(theatre: Theatre, node: int) -> tuple[str, str, str]:
    """g, h, and what orders those that wait, as text, unless it is asked."""
    state = theatre.state
    g, h, f = labels(state, node)
    if asks_for_sums(theatre) and node in state.open and node != theatre.clicked:
        return g, h, "?"
    return g, h, f if state.trace.queue != "first_in" else order_label(state, node)


def legend(theatre: Theatre, lesson: bool = False) -> str:
    """Meaning of the colours and rings in the scene, as HTML; a ``lesson`` may ask for it first."""
    state = theatre.state
    parts = [f"{_disc(style.CLOSED)}visited", f"{_disc(style.MARK)}visited last"]
    if len(state.open) == 0:
        return _entries(parts)
    values = priorities(state)
    least, most = (format_length(float(value)) for value in (values.min(), values.max()))
    if state.trace.queue == "rounds":
        parts.append(f"{_disc(style.WAITING[0])}waiting")
    elif theatre.open_question:
        rule = (
            ""
            if theatre.voted or lesson
            else f"; least {_ordering(state, 'number in line')} is next"
        )
        parts.append(f"{_disc(style.WAITING[0])}waiting{rule}")
    elif lesson and theatre.asking and not state.done:
        parts.append(f"waiting, from the next one {_scale()} to the last")
    elif state.trace.queue == "first_in":
        first, last = f"{values.min():.0f}", f"{values.max():.0f}"
        parts.append(f"waiting; least number in line is next: {first} {_scale()} {last}")
    else:
        by = _ordering(state)
        span = least if least == most else f"{least} {_scale()} {most}"
        order = f"waiting when it ended, by {by}" if state.done else f"waiting; least {by} is next"
        parts.append(f"{order}: {span}")
    ringed = len(theatre.ringed)
    if ringed and state.trace.queue != "rounds":
        parts.append(f"{_RING}{'next' if ringed == 1 else f'{ringed} tie for the least'}")
    return _entries(parts)


def _ordering(state: SearchState, in_line: str = "how long") -> str:
    """What orders those that wait, in words; ``in_line`` where they stand in a line."""
    by = formula(state)
    if state.trace.queue == "first_in":
        return in_line
    return by if by in ("g", "h") else f"f = {by}"


def _ties(theatre: Theatre) -> str:
    """How equals are told apart; empty where one node is the least, or is to be guessed."""
    count = len(theatre.ringed)
    if count < 2:
        return ""
    name = formula(theatre.state)
    name = name if name in ("g", "h") else "f"
    return (
        f"{count} waiting nodes tie for the least {name}, so any of them may be next. Of those "
        "that tie, the one reached last is visited first: it tends to be the farthest on its way. "
        "On an irregular grid (Delaunay, in stage 1) nodes hardly ever tie."
    )


def _unit(scene: Scene) -> str:
    return scene.unit if scene.search.weight == "length" else "edges"


def _at(state: SearchState, node: int, text: str) -> str:
    points = state.trace.arcs.points
    place = " ".join(f"{x:.6g}" for x in points[node % len(points)])
    return f'<span data-place="{place}">{text}</span>'


def _end(state: SearchState, unit: str) -> str:
    trace = state.trace
    if len(trace.cycle):
        return "<b>✗ Negative cycle</b> (red): each turn costs less, so there is no cheapest path."
    if not len(trace.vertices):
        return "<b>✗ No path.</b>"
    found = f"<b>Path found:</b> {format_length(trace.length)} {unit}"
    if trace.arcs.negative is not None:
        found += f", cost {format_length(trace.cost)}"
    return f"{found}."


def _entries(parts: list[str]) -> str:
    entries = "".join(f"<span>{part}</span>" for part in parts)
    return f'<div class="abi-card abi-legend">{entries}</div>'


def _disc(colour: style.Colour) -> str:
    return f'<i class="abi-disc" style="background:{style.css(colour)}"></i>'


def _scale() -> str:
    stops = ",".join(map(style.css, style.WAITING))
    return f'<i class="abi-scale" style="background:linear-gradient(90deg,{stops})"></i>'
