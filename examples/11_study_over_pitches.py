"""
A study over pitches
====================

Refine the mesh step by step and see what that gains: the taut path hardly depends on the pitch.
"""

from __future__ import annotations

import abi

planner = abi.Planner()
scene = abi.load_scene("paper").replace(search={"taut": True})

print("pitch   nodes    path  over bound    taut  over bound  planned in")
for pitch in (1.6, 1.3, 1.0, 0.8, 0.6, 0.5, 0.4):
    plan = planner(scene.replace(mesh={"pitch": pitch}))
    assert plan.mesh is not None and plan.path is not None
    assert plan.taut is not None and plan.optimum is not None
    bound = plan.optimum.length
    lengths = plan.path.length, plan.taut.length
    columns = "  ".join(f"{one:6.3f}  {one / bound - 1:9.3%}" for one in lengths)
    print(f"{pitch:5.2f}  {len(plan.mesh.points):6}  {columns}  {plan.total_ms:7.0f} ms")

# %%
# Past one convex obstacle the bound is the shortest possible length.
assert plan.optimum is not None
print(f"bound {plan.optimum.length:.6f} cm, exact: {plan.optimum.exact}")
