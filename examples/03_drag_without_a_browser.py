"""
Drag without a browser
======================

Move an obstacle in small steps; the planner reruns only the stages whose inputs have changed.
"""

from __future__ import annotations

import math

import abi

planner = abi.Planner()
scene = abi.load_scene("paper").replace(search={"taut": True})

print(" box at x    path    curve  clearance  time")
for step in range(12):
    x = 3 + 0.5 * math.sin(step / 2)
    box = {"shape": "box", "size": [2, 2, 2], "position": [x, 3, 3]}
    plan = planner(scene.replace(obstacles=[box]))
    curve = plan.bspline
    assert plan.path is not None and curve is not None and plan.bspline_arc is not None
    print(
        f"{x:9.3f}  {plan.path.length:6.3f}  {plan.bspline_arc.length:7.3f}"
        f"  {curve.clearance.distance:9.3f}  {plan.total_ms:.1f} ms"
    )

# %%
# Only the stages that a change affects run again: after a new speed, mesh, graph, searches and
# curves in the plan are the very same objects.
faster = planner(plan.scene.replace(motion={"speed": 8}))
assert faster.graph is plan.graph and faster.bspline is plan.bspline
print(f"another speed alone: {faster.total_ms:.1f} ms")
