"""Lazy Theta* (Nash, Koenig and Tovey, 2010) on the graph: a path that need not follow edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abi.arrays import flat, read_only
from abi.search.label_kernels import lazy_theta_star_steps
from abi.search.search_problem import SearchProblem
from abi.search.trace import SearchTrace, finished_trace


def lazy_theta_star(problem: SearchProblem) -> SearchTrace:
    """Search by length; a node's parent may be any expanded node that sees it.

    A node takes over its neighbour's parent untested. Whether they see each other is tested when
    the node is expanded; if not, the best expanded neighbour becomes its parent, along an edge. The
    length counts, whatever the graph's edges cost, and h is the straight line. A triangle mesh
    blocks whatever its bounding box blocks.
    """
    arcs = problem.arcs
    obstacles = problem.obstacles.boxed
    margins = read_only(np.full(len(obstacles.primitives), problem.margin))
    order, changes = lazy_theta_star_steps(
        arcs.rows.indptr,
        arcs.rows.indices,
        flat(arcs.points),
        (arcs.start, arcs.goal),
        obstacles.packed,
        margins,
    )
    left = np.linalg.norm(arcs.points - arcs.points[arcs.goal], axis=1)
    straight = replace(arcs, estimates=read_only(left))
    return finished_trace(straight, "best_first", order, changes, (1.0, 1.0))
