"""
Three lattices
==============

Plan one scene on each of the meshes and compare what their directions cost.
"""

from __future__ import annotations

import abi

planner = abi.Planner()
scene = abi.load_scene("two-boxes")

print("lattice    nodes   edges    path    taut")
for lattice in ("bcc", "kuhn", "delaunay"):
    plan = planner(scene.replace(mesh={"lattice": lattice, "pitch": 0.6}))
    assert plan.mesh is not None and plan.graph is not None
    assert plan.path is not None and plan.taut is not None
    print(
        f"{lattice:9} {len(plan.mesh.points):6}  {plan.graph.edge_count:6}"
        f"  {plan.path.length:6.3f}  {plan.taut.length:6.3f}"
    )

# %%
# A path on edges has only their directions, so its length depends on the lattice. Pulled taut, the
# three agree.
