"""
Why there is no plan
====================

Ask what stands in the way and what would help, and apply the change that was found.
"""

from __future__ import annotations

import abi
from abi.explain.diagnosis import explain

# %%
# A scene without a plan raises nothing: the plan ends early and contains the error.
scene = abi.load_scene("wall-with-window").replace(spline={"clearance": 0.6})
plan = abi.plan(scene)
assert plan.error is not None
print(f"{plan.error.stage}: {plan.error.message}")

# %%
# The explanation is found by planning scenes that differ a little: its numbers have been tried.
reason = explain(scene, plan)
assert reason is not None and reason.change is not None
print(reason.message)
print(reason.hint)

# %%
plan = abi.plan(scene.replace(**reason.change))
assert plan.error is None and plan.path is not None
print(f"with {reason.change} there is a path of {plan.path.length:.3f} cm")

# %%
# Sometimes only removing an obstacle helps.
walled_in = abi.load_scene("no-way")
reason = explain(walled_in, abi.plan(walled_in))
assert reason is not None and reason.change is not None
print(reason.message)
print(reason.hint)
plan = abi.plan(walled_in.replace(**reason.change))
assert plan.path is not None
print(f"with {len(plan.scene.obstacles)} obstacles there is a path of {plan.path.length:.3f} cm")
