"""Two trees of joint positions that grow towards each other (RRT-Connect), all edges proven.

Kuffner and LaValle, RRT-Connect: An Efficient Approach to Single-Query Path Planning, 2000. A node
is added only if :func:`abi.arm_planning.certificates.separate_chain_kernels.separate_knots`
separates the arm from its surroundings all along the straight way of the joints to it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abi.arm_planning.certificates.separate_chain_kernels import separate_knots
from abi.arm_planning.world.collision_world_kernels import NO_OBSTACLES, Obstacles
from abi.arrays import FloatArray, IntArray
from abi.compilation.jitable import jitable
from abi.compiled import FLOATS, NEW_FLOATS, NEW_IDS, compiled
from abi.curves.clearance.separation_kernels import CERTIFIED
from abi.robot.bodies.capsule_table import BODIES, Bodies
from abi.robot.kinematics.chain_kernels import TABLE, ChainTable

NODES, TURN, JOINED, PROOFS, REFUSED = 0, 2, 3, 5, 6
"""Places in a state: the number of nodes of either tree, the tree that grows next, the two nodes
that the trees met in, the edges asked about, and those of them that were not proven."""
STATE = 7
"""Numbers of a state."""
POSES = (1.0, 0.5, 0.25, 0.75)
"""Places of an edge at which the arm must be clear before a proof of all of it is tried."""
_MOST_TRIES = 20_000
"""Most pairs of bodies that the proof of one edge may try."""


class Trees(NamedTuple):
    """Two trees with room for so many nodes each, of n coordinates.

    Attributes:
        nodes: coordinates of all nodes, those of the first tree first, flat (2 room n,).
        parents: of each node in its tree; -1 of roots, (2 room,).
        weights: factors of the coordinates in distances, (n,).
        step: largest length of an edge.
        state: see ``NODES`` and so on, (STATE,).
    """

    nodes: FloatArray
    parents: IntArray
    weights: FloatArray
    step: float
    state: IntArray


TREES = Trees(NEW_FLOATS, NEW_IDS, FLOATS, 1.0, NEW_IDS)
"""Example of trees."""


@jitable
def edge_is_clear(
    chain: ChainTable, bodies: Bodies, around: Obstacles, a: FloatArray, b: FloatArray
) -> bool:
    """Check whether the arm is proven clear while its joints go straight from a to b, (n,) each."""
    count = len(a)
    knots = np.empty(2 * count)
    for place in range(len(POSES)):
        for j in range(count):
            knots[j] = knots[count + j] = a[j] + POSES[place] * (b[j] - a[j])
        still = separate_knots(chain, bodies, knots, around, _MOST_TRIES, False)
        if still[0] != CERTIFIED:
            return False
    for j in range(count):
        knots[j], knots[count + j] = a[j], b[j]
    outcome = separate_knots(chain, bodies, knots, around, _MOST_TRIES, False)
    return outcome[0] == CERTIFIED


@jitable
def nearest_node(trees: Trees, tree: int, target: FloatArray) -> tuple[int, float]:
    """Number of the node of a tree that is nearest to coordinates (n,), and its distance."""
    count = len(target)
    first = tree * (len(trees.parents) // 2)
    best, nearest = math.inf, 0
    for node in range(trees.state[NODES + tree]):
        at, square = (first + node) * count, 0.0
        for j in range(count):
            d = trees.weights[j] * (trees.nodes[at + j] - target[j])
            square += d * d
        if square < best:
            best, nearest = square, node
    return nearest, math.sqrt(best)


@jitable
def _step_towards(
    chain: ChainTable,
    bodies: Bodies,
    around: Obstacles,
    trees: Trees,
    tree: int,
    target: FloatArray,
) -> tuple[int, bool]:
    """Add the node at most a step from a tree towards coordinates, if the edge to it is proven.

    Returns:
        Number of the node, -1 if none was added, and whether it is at these coordinates.
    """
    count, state = len(target), trees.state
    room = len(trees.parents) // 2
    if state[NODES + tree] == room:
        return -1, False
    parent, away = nearest_node(trees, tree, target)
    if away == 0:
        return parent, True
    reached = away <= trees.step
    share = 1.0 if reached else trees.step / away
    a, b = np.empty(count), np.empty(count)
    for j in range(count):
        a[j] = trees.nodes[(tree * room + parent) * count + j]
        b[j] = target[j] if reached else a[j] + share * (target[j] - a[j])
    state[PROOFS] += 1
    if not edge_is_clear(chain, bodies, around, a, b):
        state[REFUSED] += 1
        return -1, False
    node = int(state[NODES + tree])
    for j in range(count):
        trees.nodes[(tree * room + node) * count + j] = b[j]
    trees.parents[tree * room + node] = parent
    state[NODES + tree] += 1
    return node, reached


_NO_TREES = TREES._replace(parents=NEW_IDS[:0])


@jitable
def _edges_are_clear(
    chain: ChainTable, bodies: Bodies, around: Obstacles, knots: FloatArray
) -> bool:
    """Check whether the arm is proven clear on straight ways between coordinates, flat (k n,)."""
    count = len(chain.limits) // 2
    a, b = np.empty(count), np.empty(count)
    for knot in range(len(knots) // count - 1):
        for j in range(count):
            a[j], b[j] = knots[knot * count + j], knots[(knot + 1) * count + j]
        if not edge_is_clear(chain, bodies, around, a, b):
            return False
    return True


@compiled(example=(TABLE, BODIES, NO_OBSTACLES, TREES, FLOATS), fallback=False)
def grow_trees(
    chain: ChainTable, bodies: Bodies, around: Obstacles, trees: Trees, samples: FloatArray
) -> bool:
    """Grow two trees towards samples and each other until they meet.

    For each sample one of them, in turn, takes a step towards it; then the other goes towards the
    new node, step by step, as far as it can. Where the trees have room for nothing, the edges from
    each sample to the next are proven instead: one kernel has all that proofs of edges need.

    Args:
        chain: the arm's joints.
        bodies: what it consists of.
        around: what it keeps clear of.
        trees: with one root each at least; written.
        samples: coordinates, flat (k n,).

    Returns:
        Whether the trees have met; ``trees.state`` then says in which nodes. Without room, whether
        all edges are proven.
    """
    if len(trees.parents) == 0:
        return _edges_are_clear(chain, bodies, around, samples)
    count, state = len(trees.weights), trees.state
    room, target = len(trees.parents) // 2, np.empty(count)
    for sample in range(len(samples) // count):
        tree = int(state[TURN])
        other = 1 - tree
        state[TURN] = other
        for j in range(count):
            target[j] = samples[sample * count + j]
        node, _ = _step_towards(chain, bodies, around, trees, tree, target)
        if node < 0:
            continue
        for j in range(count):
            target[j] = trees.nodes[(tree * room + node) * count + j]
        met, reached = 0, False
        while met >= 0 and not reached:
            met, reached = _step_towards(chain, bodies, around, trees, other, target)
        if reached:
            state[JOINED + tree], state[JOINED + other] = node, met
            return True
    return False


def edges_are_clear(
    chain: ChainTable, bodies: Bodies, around: Obstacles, knots: FloatArray
) -> bool:
    """Check whether the arm is proven clear on straight ways between coordinates, flat (k n,)."""
    return bool(grow_trees(chain, bodies, around, _NO_TREES, knots))
