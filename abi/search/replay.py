"""Replay of a search up to any step: its open and closed nodes, and the next one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abi import arguments
from abi.arrays import FloatArray, IntArray, read_only
from abi.search.best_first_kernels import WIDTH
from abi.search.search_kernels import reconstruct_path
from abi.search.trace import NO_NODES, SearchTrace, last_labels, trace_of

_EQUAL = 1e-9


@dataclass(frozen=True, eq=False)
class SearchState:
    """A search after some steps; ids as in its trace.

    Attributes:
        trace: the search.
        step: number of steps done.
        cost, parent: (n or 2n,) g and the node that it comes from; inf and -1 where not reached.
        closed: (c,) expanded nodes, in the order of their last expansion.
        open: (o,) nodes that are reached but not expanded.
        current: node expanded last; -1 before the first and after a round.
        following: node that is expanded next; -1 after the last step and before a round.
    """

    trace: SearchTrace
    step: int
    cost: FloatArray
    parent: IntArray
    closed: IntArray
    open: IntArray
    current: int
    following: int

    def __post_init__(self) -> None:
        count = self.trace.sides * len(self.trace.arcs.points)
        arguments.keep(
            self,
            cost=arguments.numbers("cost", self.cost, (count,), infinite=True),
            parent=arguments.bits("parent", self.parent, (count,), -1, count - 1),
            closed=arguments.ids("closed", self.closed, (-1,), count),
            open=arguments.ids("open", self.open, (-1,), count),
        )

    @property
    def examined(self) -> int:
        """Arcs examined so far."""
        return int(self.trace.examined[self.step])

    @property
    def done(self) -> bool:
        """Whether that was the last step."""
        return self.step == self.trace.steps

    def to_go(self, nodes: IntArray) -> FloatArray:
        """h of nodes (k,); 0 in the search that begins at the goal."""
        n = len(self.trace.arcs.points)
        return np.where(nodes < n, self.trace.arcs.estimates[nodes % n], 0.0)

    def promise(self, nodes: IntArray) -> FloatArray:
        """f of nodes (k,), which a best-first search minimises."""
        a, b = self.trace.factors
        with np.errstate(invalid="ignore"):
            f = (a * self.cost[nodes] if a else 0.0) + (b * self.to_go(nodes) if b else 0.0)
        return np.where(np.isfinite(self.cost[nodes]), f, np.inf)

    def path(self) -> IntArray:
        """Nodes of the path so far, from the start to the node expanded last; at the end, to the
        goal."""
        if self.done and len(self.trace.vertices):
            return self.trace.vertices
        if self.current < 0:
            return NO_NODES
        return read_only(reconstruct_path(self.parent, self.current))

    def queue(self, most: int) -> IntArray:
        """The first ``most`` open nodes, in the order in which they would be expanded."""
        if self.trace.queue == "first_in":
            # nobody overtakes those who wait
            return self.trace.order[self.step :][: min(most, len(self.open))]
        promise = self.promise(self.open)
        if self.following >= 0:
            # of what promises the same, the search takes one
            promise[self.open == self.following] = -np.inf
        if most < len(promise):
            few = np.argpartition(promise, most)[:most]
            few = few[np.lexsort((self.open[few], promise[few]))]
            return self.open[few]
        return self.open[np.lexsort((self.open, promise))]

    def candidates(self) -> IntArray:
        """Open nodes that tie with the one that is expanded next."""
        if self.following < 0:
            return NO_NODES
        if self.trace.queue != "best_first":
            return np.array([self.following], np.int32)
        n = len(self.trace.arcs.points)
        best = float(self.promise(np.array([self.following], np.int32))[0])
        slack = WIDTH * float(np.abs(self.trace.arcs.rows.weights).max(initial=0.0))
        same_side = (self.open < n) == (self.following < n)
        equal = same_side & (self.promise(self.open) <= best + slack)
        return np.asarray(self.open[equal | (self.open == self.following)], np.int32)

    def may_follow(self, node: int) -> bool:
        """Check whether a node ties with the one that is expanded next."""
        return node in self.candidates()

    def is_least(self, node: int) -> bool:
        """Check whether a node ties, and none that ties has a smaller f, however slightly."""
        tied = self.candidates()
        if node not in tied:
            return False
        promise = self.promise(np.append(tied, node).astype(np.int32))
        return bool(promise[-1] <= promise.min() + _EQUAL * max(1.0, abs(promise.min())))


def replay(trace: SearchTrace, step: int) -> SearchState:
    """The search after ``step`` steps, 0 to ``trace.steps``, independent of earlier calls."""
    cost, parent = last_labels(trace, step)
    changed = steps_of_changes(trace, step)
    expanded = np.full(len(cost), -2, np.int32)
    if trace.queue == "rounds":
        # whatever the last round did not change has nothing new to tell
        expanded[np.isfinite(cost) & (changed < step)] = step
        closed = np.flatnonzero(expanded == step)
    else:
        order, turns = trace.order[:step], np.arange(1, step + 1, dtype=np.int32)
        expanded[order] = turns
        closed = order[(expanded[order] == turns) & (changed[order] <= turns)]
    open_ = np.flatnonzero((changed >= 0) & (changed > expanded))
    return SearchState(
        trace=trace,
        step=step,
        cost=read_only(cost),
        parent=read_only(parent),
        closed=read_only(closed.astype(np.int32)),
        open=read_only(open_.astype(np.int32)),
        current=int(trace.order[step - 1]) if step else -1,
        following=int(trace.order[step]) if step < trace.steps else -1,
    )


def with_next(state: SearchState, node: int) -> SearchTrace | None:
    """The search with ``node`` expanded next, of all that tie for the least f.

    All else keeps its order: with a consistent heuristic whatever came before that node ties with
    it, too, and its cost is final. None where that does not hold, or its f is not the least.
    """
    trace, step = state.trace, state.step
    g, h = trace.factors
    one_sided = trace.queue == "best_first" and trace.sides == 1 and trace.arcs.negative is None
    if not one_sided or h > g or not state.is_least(node):
        return None
    left = trace.order[step:]
    # a search ends at its goal
    left = (
        left[:0] if node == trace.arcs.goal else np.delete(left, np.flatnonzero(left == node)[:1])
    )
    order = np.concatenate((trace.order[:step], [node], left)).astype(np.int32)
    return trace_of(trace.arcs, read_only(order), "best_first", trace.factors, reopens=True)


def steps_of_changes(trace: SearchTrace, step: int) -> IntArray:
    """Steps (n or 2n,), from 1 to ``step``, that last changed each node; 0 of starts, else -1."""
    ends, nodes, _, _ = trace.changes
    changed = np.full(trace.sides * len(trace.arcs.points), -1, np.int32)
    counts = np.diff(ends[: step + 1], prepend=0)
    changed[nodes[: ends[step]]] = np.repeat(np.arange(step + 1, dtype=np.int32), counts)
    return changed
