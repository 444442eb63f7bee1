"""The search theatre: any search step by step in both directions, with guesses, or as a race."""

from __future__ import annotations

import time
from collections import deque
from functools import partial
from typing import Any

import numpy as np
import viser
from pydantic import ValidationError

from abi.arrays import FloatArray, IntArray
from abi.errors import StageError
from abi.planner.plan import Plan
from abi.scene.scene import Scene
from abi.search.compare import COMPARED
from abi.search.replay import replay, with_next
from abi.search.search import SEARCHES
from abi.search.trace import SearchTrace
from app.panels.widgets import Wake, clamp, hidden_button
from app.state.frame import Frame
from app.teach.lesson import SearchCue
from app.theatre.compared import LETTERS, lettered
from app.theatre.searches import EDGES, are_searched_alike, followed, problem_with, trace
from app.theatre.theatre import Theatre, judge, node_at, one_way_search, race_of, where
from app.ui import notices, page, style

QUIZ = "Which node is next?"
"""Button that begins a search in which each node is asked."""
FRAME = 1 / 20
"""Seconds between two pictures while it plays."""
SPEEDS = {"2 steps a second": 2.0, "10 steps a second": 10.0, "all in 10 s": 0.0}
_ALL_IN = 10.0
_INTRO = style.paragraph(
    f"Watch any of {len(COMPARED)} searches node by node: what it has visited, what waits, and "
    "what comes next, or say yourself which node is next. Or run them all on this grid and compare."
)
_OF_THE_GRAPH = ("workspace", "obstacles", "start", "goal", "mesh", "spline")
"""Parts of a scene that its graph depends on."""
_STEPS = {"to start": None, "◀ 1": -1, "1 ▶": 1}
_COVERING = (
    frozenset(SEARCHES)
    | {"taut", "bspline", "control", "quadratic", "ghost", "names", "excluded", "arm", "trace"}
    | {"tool_only", "other_elbow", "end_poses", "bases", "bent"}
)
"""Layers that would cover the search, or give away what it finds."""


class TheatrePanel:
    """Widgets and clock of the theatre, and the searches that it shows.

    Attributes:
        back: hidden button that goes a step back; ``forward`` one forward, ``close`` ends it.
        playing: whether it goes on by itself.
        yields_clicks: whether a click in the scene answers the class and means nothing here.
        voted: whether a class votes on the next node: the search stands still and does not tell it.
    """

    def __init__(self, client: viser.ClientHandle, wake: Wake) -> None:
        gui, self._client, self._wake = client.gui, client, wake
        self._intro = gui.add_html(_INTRO)
        self.quiz = gui.add_button(
            QUIZ, hint="Asks you at each step which node the search visits next."
        )
        self.on = gui.add_checkbox(
            "step through a search",
            False,
            hint="Any search, node by node. Paths, curves and arm are hidden meanwhile.",
        )
        self.algorithm = gui.add_dropdown(
            "algorithm", tuple(one.label for one in COMPARED.values())
        )
        self.weight = gui.add_slider(
            "heuristic weight w",
            0.0,
            2.0,
            0.05,
            1.5,
            hint="f = (2 − w) g + w h: 0 is Dijkstra, 1 is A*, 2 is greedy.",
        )
        self.step = gui.add_slider("step", 0, 1, 1, 0, hint="Drag to go anywhere in the search.")
        self.play = gui.add_button("Play the search", hint="Or press P.")
        self.one = gui.add_button_group("one step", tuple(_STEPS), hint="Or press B and N.")
        self.speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="10 steps a second")
        self.ask = gui.add_checkbox(
            "ask me: which node next?",
            False,
            hint="Click or tap the node that you think will be visited next.",
        )
        self.race = gui.add_checkbox(
            "race of three", False, hint="Three searches side by side, step for step."
        )
        self.edges = gui.add_dropdown(
            "negative edge",
            tuple(EDGES),
            hint="Adds a one-way edge of negative cost, which leads Dijkstra astray.",
        )
        self.back = hidden_button(gui, "Search: back", partial(self.go, -1))
        self.forward = hidden_button(gui, "Search: forward", partial(self.go, 1))
        self.close = hidden_button(gui, "Search: end", self._end)
        self._letter = gui.add_text("letter", "", visible=False)
        self.playing = self.yields_clicks = self.voted = False
        self._pair: tuple[Scene, tuple[int, ...], tuple[int, ...]] | None = None
        self._inputs: deque[int | None] = deque()
        self._click: tuple[FloatArray, FloatArray] | None = None
        self._advanced, self._position, self._written = time.monotonic(), 0.0, 0
        self._searched: Plan | None = None  # with the graph whose searches are shown
        self._say()
        self._own: tuple[SearchTrace, SearchTrace] | None = None
        self._last: Theatre | None = None
        self._seen: tuple[object, ...] = ()
        for widget in (self.on, self.algorithm, self.weight, self.edges, self.step):
            widget.on_update(wake)
        for widget in (self.speed, self.ask, self.race):
            widget.on_update(wake)
        self._letter.on_update(wake)
        self.quiz.on_click(self._begin_quiz)
        self.play.on_click(self._toggle)
        self.one.on_click(self._one_step)
        gui.add_command("Search: play or pause", hotkey="P").on_trigger(self._toggle)
        gui.add_command("Search: one step", hotkey="N").on_trigger(partial(self.go, 1))
        gui.add_command("Search: one step back", hotkey="B").on_trigger(partial(self.go, -1))
        client.scene.on_click()(self._clicked)

    @property
    def chosen(self) -> str:
        """Name of the search in :data:`abi.search.compare.COMPARED`."""
        name = next(
            (k for k, one in COMPARED.items() if one.label == self.algorithm.value), "a_star"
        )
        return name if not self._kind else one_way_search(name)

    @property
    def kept(self) -> str:
        """Search that is stepped through, and its step, as a text; empty while it is off."""
        if not self.on.value:
            return ""
        cue = SearchCue(
            algorithm=self.chosen,
            step=0 if self.playing else self._written,
            weight=clamp(self.weight.value, 0.0, 2.0),
            edges=self.edges.value if self.edges.value in EDGES else None,
            ask=bool(self.ask.value),
            race=bool(self.race.value),
        )
        return cue.model_dump_json(exclude_none=True)

    def restore(self, text: str) -> None:
        """Show what a kept text says, which may come from anyone; nothing where it says nothing."""
        if text == self.kept and not self.playing:
            return
        try:
            cue = SearchCue.model_validate_json(text) if text else SearchCue(on=False)
        except ValidationError:
            return
        if cue.edges in (None, *EDGES):
            self.set(**cue.model_dump(exclude_none=True))

    def uncovered(self, shown: frozenset[str]) -> frozenset[str]:
        """Names of the switches that are on, without what would cover the search."""
        return shown - _COVERING if self.on.value else shown

    def timeout(self) -> float | None:
        """Time until the next picture, [s]; None while it stands still."""
        return FRAME if self.playing and self.on.value else None

    def set(self, **settings: Any) -> None:
        """Set widgets by name, as a lesson does: ``on``, ``algorithm``, ``step``, …"""
        self._say()  # nothing of what was shown before
        self._own = None
        for name, value in settings.items():
            if name == "step":
                self._position = float(value)
                self.playing = False
            elif name == "algorithm":
                self.algorithm.value = COMPARED[value].label
            else:
                getattr(self, name).value = value

    def advance(self, frame: Frame) -> Theatre | None:
        """Search and step to draw now; None while the theatre is off, or while the user drags."""
        self._replace_search()
        self._show_widgets()
        now = time.monotonic()
        elapsed, self._advanced = now - self._advanced, now
        plan = frame.plan
        if not self.on.value:
            self._await(COMPARED[plan.scene.search.algorithm].label)
        if not self.on.value or plan.graph is None:
            self._last = None
            return None
        if self._searched is None or not are_searched_alike(self._searched, plan):
            if frame.interactive or frame.plan.partial or frame.outdated:
                return None
            self._searched, self._last = plan, None
            self._say()  # the node was one of another graph
        plan = self._searched
        name, found = self._trace_of(plan, self.chosen)
        chosen = self._as_chosen(found)
        racing = self._written_ones(plan)
        if self.race.value and not racing:
            racing = tuple(self._trace_of(plan, one) for one in race_of(name))
        steps = max([chosen.steps, *(other.steps for _, other in racing)])
        self._move(chosen, steps, elapsed)
        self._show_widgets()  # it may have come to its end
        self._last = self._view(name, self._as_chosen(found), racing)
        return self._last

    def compare(self, scene: Scene, own: tuple[int, ...], right: tuple[int, ...]) -> None:
        """Show a student's search beside the right one while the plan is one of ``scene``.

        Args:
            scene: whose graph they search.
            own: nodes in the order in which the student's expands them; none ends the comparison.
            right: the same of the right one.
        """
        self._pair = scene, own, right

    def _await(self, label: str) -> None:
        """While it is off: the search of stage 3, by its label, from its first step on."""
        self._own, self._position, self.playing = None, 0.0, False
        self._say()
        self._inputs.clear()
        self._written = 0
        edges = next(iter(EDGES))
        if (self.algorithm.value, self.edges.value) != (label, edges):
            self.algorithm.value, self.edges.value = label, edges
        if self.race.value or self.step.value or self.ask.value:
            self.race.value, self.step.value, self.ask.value = False, 0, False

    def _as_chosen(self, trace: SearchTrace) -> SearchTrace:
        """The search as it goes on with the nodes that were chosen where several tied."""
        return self._own[1] if self._own is not None and self._own[0] is trace else trace

    def _written_ones(self, plan: Plan) -> tuple[tuple[str, SearchTrace], ...]:
        """The student's search and the right one; none where the graph is another."""
        if self._pair is None or not self._pair[1]:
            return ()
        scene, own, right = self._pair
        if any(getattr(plan.scene, part) != getattr(scene, part) for part in _OF_THE_GRAPH):
            return ()
        return ("yours", followed(plan, own)), ("right", followed(plan, right))

    def _show_widgets(self) -> None:
        """Show the widgets that count now."""
        on = bool(self.on.value)
        chosen = self.race.value, self.algorithm.value, self.edges.value
        seen = (on, *chosen, self.ask.value, self.playing, self.voted)
        if seen == self._seen:
            return
        self._seen = seen
        self._intro.visible = self.quiz.visible = not on
        self.algorithm.visible = on
        self.edges.visible = on and not self.ask.value
        for widget in (self.step, self.play, self.one, self.speed):
            widget.visible = on and not self.voted
        self.ask.visible = on and not self.race.value
        self.race.visible = on
        self.weight.visible = on and self.chosen == "weighted_a_star"
        self.play.label = "Pause the search" if self.playing else "Play the search"

    def _replace_search(self) -> None:
        """Choose one that takes a negative edge, where the one chosen does not."""
        label = COMPARED[self.chosen].label
        if self.on.value and self._kind and label != self.algorithm.value:
            notices.notify_refusal(
                self._client,
                f"{label} instead",
                f"{self.algorithm.value} cannot handle a negative one-way edge.",
            )
            self.algorithm.value = label

    @property
    def _kind(self) -> str:
        return EDGES.get(self.edges.value, "")

    def _trace_of(self, plan: Plan, name: str) -> tuple[str, SearchTrace]:
        """A search of a plan's graph and its trace; another where it takes no one-way edges."""
        try:
            problem_with(plan, self._kind)
        except StageError as error:
            notices.notify_refusal(self._client, "No negative edge", error.message)
            self.edges.value = next(iter(EDGES))
        if self._kind:
            name = one_way_search(name)
        return name, trace(plan, name, self._kind, clamp(self.weight.value, 0.0, 2.0))

    def _move(self, trace: SearchTrace, steps: int, elapsed: float) -> None:
        """Go to the step that the widgets and the clock ask for."""
        asking = self.ask.value and not self.race.value
        if self.step.max != max(steps, 1):
            self.step.max = max(steps, 1)
        if self.voted:
            self._inputs.clear()
            self.playing = False
            self._say()  # what was said may have named the least that waits
        elif self.step.value != self._written:
            self._position, self.playing = float(self.step.value), False
        while self._inputs:
            change = self._inputs.popleft()
            self._position = 0.0 if change is None else int(self._position) + change
            self.playing = False
        if self.playing and not asking:
            rate = SPEEDS.get(self.speed.value, 10.0) or steps / _ALL_IN
            if self._position >= steps:
                self._position = 0.0
            self._position += elapsed * rate
            self.playing = self._position < steps
        before = self._written
        self._position = clamp(self._position, 0.0, float(steps))
        node = self._pointed_node(trace, asking)
        clicked = node is not None
        if node is not None and node >= 0:
            self._take(trace, asking, node)
        step = int(self._position)
        if step != before and not clicked:
            self._say(self._clicked_node)
        if self.step.value != step:
            self.step.value = step
        self._written = step

    def _pointed_node(self, trace: SearchTrace, asking: bool) -> int | None:
        """The node that was clicked, itself or its letter; -1 beside all, None for no click."""
        click, letter = self._click, self._letter.value
        self._click = None
        if letter:
            self._letter.value = ""
        if self.voted or self.yields_clicks:
            return None
        if letter:
            return -1 if self._last is None else lettered(self._last).get(letter, -1)
        if click is None:
            return None
        state = replay(trace, min(int(self._position), trace.steps))
        reached = np.flatnonzero(np.isfinite(state.cost)).astype(np.int32)
        # of both searches' nodes the one that waits
        points: FloatArray = np.concatenate([trace.arcs.points] * trace.sides)
        nodes: IntArray = state.open if asking else reached
        node = node_at(points, nodes, *click)
        return node_at(points, reached, *click) if node < 0 and asking else node

    def _take(self, trace: SearchTrace, asking: bool, node: int) -> None:
        """Judge the node that was clicked, or look it up."""
        self._say(node)
        if not asking or trace.queue == "rounds":
            return
        state = replay(trace, min(int(self._position), trace.steps))
        own = None if COMPARED[self.chosen].any_angle else with_next(state, node)
        right, why = judge(state, node, goes_on=own is not None)
        if own is not None and node != state.following:
            found = self._own[0] if self._own is not None and self._own[1] is trace else trace
            self._own = found, own
        word = "✓ <b>Right:</b>" if right else "✗ <b>Not this one:</b>"
        self._say(node, f"The node at {where(state, node)}. {word} {why}", not right)
        self._position += right

    def _say(self, node: int = -1, text: str = "", is_wrong: bool = False) -> None:
        """Mark a node that was clicked, and say something of it."""
        self._clicked_node, self._said, self._is_wrong = node, text, is_wrong

    def _view(
        self, name: str, trace: SearchTrace, racing: tuple[tuple[str, SearchTrace], ...]
    ) -> Theatre:
        step, last = self._written, self._last
        asking = (bool(self.ask.value) or self.voted) and not racing
        other = last is not None and last.name != name
        if other or self._clicked_node >= trace.sides * len(trace.arcs.points):
            self._say()  # it was of another search; one from both ends has more nodes
        if (
            last is not None
            and last.state.trace is trace
            and last.state.step == min(step, trace.steps)
            and (last.clicked, last.said) == (self._clicked_node, self._said)
            and (last.is_wrong, last.asking, last.voted) == (self._is_wrong, asking, self.voted)
            and tuple(state.trace for _, state in last.race) == tuple(one for _, one in racing)
            and all(state.step == min(step, state.trace.steps) for _, state in last.race)
        ):
            return last
        return Theatre(
            name=name,
            state=replay(trace, min(step, trace.steps)),
            race=tuple((other, replay(one, min(step, one.steps))) for other, one in racing),
            asking=asking,
            voted=self.voted,
            clicked=self._clicked_node,
            said=self._said,
            is_wrong=self._is_wrong,
            widget=page.uuid(self._letter),
            kept=() if last is None or other else _letters(last),
        )

    def _toggle(self, event: Any) -> None:
        self.playing = not self.playing
        self._advanced = time.monotonic()
        self._wake(event)

    def _one_step(self, event: Any) -> None:
        if event.target.value in _STEPS:
            self._inputs.append(_STEPS[event.target.value])
        self._wake(event)

    def _begin_quiz(self, event: object) -> None:
        """Step through the search, and ask at each step."""
        self.on.value = self.ask.value = True
        self._wake(event)

    def _end(self, event: object) -> None:
        """Show paths, curves and arm again."""
        self.on.value = False
        self._wake(event)

    def go(self, change: int, event: object) -> None:
        """Go some steps forward, or back."""
        self._inputs.append(change)
        self._wake(event)

    def _clicked(self, event: Any) -> None:
        if self.on.value and not self.race.value:
            ray = np.array(event.ray_origin, float), np.array(event.ray_direction, float)
            if np.isfinite(ray).all():
                self._click = ray
                self._wake(event)


def _letters(theatre: Theatre) -> tuple[int, ...]:
    """Nodes that have a letter, in the order of all letters; -1 for one that none has."""
    named = lettered(theatre)
    return tuple(named.get(letter, -1) for letter in LETTERS)
