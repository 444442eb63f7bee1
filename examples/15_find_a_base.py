"""
Where to put the arm
====================

Try many places for the base, and take the one with the shortest path that is proven clear.
"""

from __future__ import annotations

import abi

# %%
# The arm of this scene stands behind a wall: the tool has a path, but the arm cannot follow it.
scene = abi.load_scene("find-a-base")
plan = abi.plan(scene)
assert plan.error is not None
print(f"base at {scene.arm.base}: {plan.error.message}")

# %%
# A region is a box. Its cells are tried coarsely, then the best of them more finely.
found = abi.find_base(scene, low=(-6, -6, 0), high=(12, 12, 0))
best = found.best
assert best is not None and best.length is not None
print(f"{len(found.trials)} places tried; best {best.base}: {best.length:.3f} cm")
for reason, count in found.faults.items():
    print(f"{count:4} x {reason}")

# %%
# The plan from there is certified like any other.
plan = abi.plan(scene.replace(arm={"base": best.base}))
assert plan.error is None and plan.arm_clearance is not None
print(f"proven: every link keeps {plan.arm_clearance.distance:.3f} cm from the obstacles")
