"""Joint-space search for a motion: two trees that meet, then shortcuts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from abi import arguments
from abi.arm_planning.joint_search import tree_kernels as kernels
from abi.arm_planning.joint_search.joint_space import JointSpace
from abi.arm_planning.joint_search.joint_tree import JointTree
from abi.arm_planning.joint_search.shorten import shortened
from abi.arrays import FloatArray, ShortRepr, flat, read_only
from abi.errors import ArgumentError

STEP = 1.0
"""Largest length of an edge, [rad]."""
_BATCH = 16
"""Samples between two checks whether the result is still wanted."""


@dataclass(frozen=True, eq=False, repr=False)
class JointSearch(ShortRepr):
    """Findings of a joint-space search so far.

    Attributes:
        path: joint positions (k, n) from a start to a goal, [rad] or [unit], between which the
            joints go straight; None if none was found.
        length: of that path, [rad], slides over the arm's reach; inf if there is none.
        trees: from the starts and from the goals.
        samples: number of random positions that they have grown towards.
        proofs: number of edges whose proof was tried.
        refused: number of those that were not proven.
    """

    path: FloatArray | None
    length: float
    trees: tuple[JointTree, JointTree]
    samples: int
    proofs: int
    refused: int


@dataclass(frozen=True)
class JointSearchEffort:
    """Effort that a search may make; equal efforts and seeds give equal results.

    Attributes:
        seed: of the random positions, 0 to 2^32 - 1.
        samples: random positions that the trees grow towards, at most.
        nodes: of either tree, at most.
        shortcuts: straight ways that are tried to make a path shorter.
    """

    seed: int = 0
    samples: int = 20_000
    nodes: int = 20_000
    shortcuts: int = 100

    def __post_init__(self) -> None:
        arguments.integer("seed", self.seed, 0, 2**32 - 1)
        arguments.integer("samples", self.samples, 1, 10_000_000)
        arguments.integer("nodes", self.nodes, 2, 1_000_000)
        arguments.integer("shortcuts", self.shortcuts, 0, 1_000_000)


def search_joints(
    space: JointSpace,
    starts: FloatArray,
    goals: FloatArray,
    effort: JointSearchEffort | None = None,
) -> JointSearch:
    """Find a path from one of some joint positions to one of others; see :func:`paths_found`."""
    *_, last = paths_found(space, starts, goals, effort)
    return last


def shorter_path(space: JointSpace, path: FloatArray, effort: JointSearchEffort) -> JointSearch:
    """Begin with a path (k, n), k >= 2, that is proven clear, and only make it shorter.

    The first tree is that path, the other its end.
    """
    root, end = (JointTree.of(read_only(path[k].copy()[None])) for k in (0, -1))
    tree, _ = root.grown(path, 0)
    random, shorter = np.random.default_rng(effort.seed), path
    for found in shortened(space, path, random, effort.shortcuts):
        shorter = found
    shorter = path if shorter is path else read_only(shorter)
    return JointSearch(shorter, space.distance(shorter), (tree, end), 0, len(path) - 1, 0)


def paths_found(
    space: JointSpace,
    starts: FloatArray,
    goals: FloatArray,
    effort: JointSearchEffort | None = None,
) -> Iterator[JointSearch]:
    """Search for a path, yielding it and each shorter one as soon as it is found.

    All edges are proven clear. Where no path is found in time the only result has none. Whoever
    wants the result no longer just stops asking.

    Args:
        space: the arm and what it keeps clear of.
        starts: joint positions (k, n), within the limits and clear, [rad] or [unit].
        goals: the same of the goals.
        effort: how long to search.

    Raises:
        ArgumentError: ``starts`` or ``goals`` are none, or past the limits.
    """
    effort = effort or JointSearchEffort()
    random = np.random.default_rng(effort.seed)
    roots = [_roots(space, *given) for given in (("starts", starts), ("goals", goals))]
    trees, samples = _new_trees(space, roots, effort), 0
    low, high = _range(space, roots)
    met = False
    while not met and samples < effort.samples:
        batch = random.uniform(low, high, (min(_BATCH, effort.samples - samples), len(low)))
        if samples == 0:  # often the straight way is free
            batch[0] = roots[1][0]
        met = kernels.grow_trees(*space.kernel_arguments, trees, flat(batch))
        samples += len(batch)
    found = [_tree(trees, number, space) for number in range(2)]
    counts = samples, *(int(trees.state[k]) for k in (kernels.PROOFS, kernels.REFUSED))
    if not met:
        yield JointSearch(None, np.inf, (found[0], found[1]), *counts)
        return
    first, last = (found[k].way_to(int(trees.state[kernels.JOINED + k])) for k in range(2))
    path = np.concatenate([first, last[-2::-1]])
    for shorter in shortened(space, path, random, effort.shortcuts):
        path = read_only(shorter)
        yield JointSearch(path, space.distance(path), (found[0], found[1]), *counts)


def _roots(space: JointSpace, name: str, given: FloatArray) -> FloatArray:
    """Coordinates of starts or goals, (k, n), [rad] and [m]."""
    positions = arguments.numbers(name, given, (-1, len(space.weights)))
    if not len(positions):
        raise ArgumentError(f"number of {name}", 0, "1 or more")
    if not space.is_within(positions):
        raise ArgumentError(name, positions.tolist(), "positions within the joints' limits")
    return np.asarray(positions / space.arm.scales)


def _range(space: JointSpace, roots: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest coordinates that are sampled: one turn, and what the ends need."""
    low, high = space.arm.chain.usual_range().T
    ends = np.concatenate(roots)
    return np.minimum(low, ends.min(axis=0)), np.maximum(high, ends.max(axis=0))


def _new_trees(
    space: JointSpace, roots: list[FloatArray], effort: JointSearchEffort
) -> kernels.Trees:
    """Both trees with their roots only."""
    room = max(effort.nodes, *map(len, roots))
    count = len(space.weights)
    nodes = np.zeros((2, room, count))
    for tree, ends in enumerate(roots):
        nodes[tree, : len(ends)] = ends
    state = np.zeros(kernels.STATE, dtype=np.int32)
    state[kernels.NODES : kernels.NODES + 2] = [len(ends) for ends in roots]
    parents = np.full(2 * room, -1, dtype=np.int32)
    # a slide's coordinate is in metres
    weights = read_only(space.weights * space.arm.scales)
    return kernels.Trees(nodes.reshape(-1), parents, weights, STEP, state)


def _tree(trees: kernels.Trees, number: int, space: JointSpace) -> JointTree:
    """A copy of one of the trees."""
    count, size = len(space.weights), int(trees.state[kernels.NODES + number])
    nodes = trees.nodes.reshape(2, -1, count)[number, :size]
    parents = trees.parents.reshape(2, -1)[number, :size]
    return JointTree(read_only(nodes * space.arm.scales), read_only(parents.copy()))
