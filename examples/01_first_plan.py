"""
First plan
==========

Load a shipped scene, plan it and read how long each stage's result is.
"""

from __future__ import annotations

import abi

print("shipped scenes:", ", ".join(abi.scene_names()))

plan = abi.plan(abi.load_scene("wall-with-window"))

# %%
# A plan holds the result of every stage. A stage that was not reached is None.
assert plan.mesh is not None and plan.path is not None and plan.taut is not None
assert plan.bspline_arc is not None and plan.quadratic_arc is not None
assert plan.profile is not None

print(f"mesh        {len(plan.mesh.points)} nodes")
print(f"path        {plan.path.length:.3f} cm over {plan.path.hops} edges")
print(f"taut path   {plan.taut.length:.3f} cm")
print(f"B-spline    {plan.bspline_arc.length:.3f} cm")
print(f"quadratic   {plan.quadratic_arc.length:.3f} cm")
print(f"the arm follows the {plan.followed} for {plan.profile.duration:.2f} s")
