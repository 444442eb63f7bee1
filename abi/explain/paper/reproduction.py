"""Table of all of the paper's numbers beside ours, misprints included.

Everything is computed anew from the shipped scene ``paper`` and from seeded random ones.
"""

from __future__ import annotations

from abi.explain.paper import arm_figures, curve_figures, graph_figures
from abi.explain.paper.comparison import PaperComparison
from abi.planner.planner import plan
from abi.scene.scene import load_scene


def compare() -> tuple[PaperComparison, ...]:
    """All comparisons, in the order of the paper."""
    scene = load_scene("paper")
    by_length = plan(scene)
    by_hops = plan(scene.replace(search={"weight": "hops"}))
    return (
        *graph_figures.of_mesh(scene),
        *graph_figures.of_table_one(by_length, by_hops),
        *curve_figures.of_splines(scene, by_length),
        *curve_figures.of_quadratic(scene, by_length),
        *curve_figures.of_motion(by_length),
        *arm_figures.of_kinematics(scene),
        *arm_figures.of_drives(scene),
    )
