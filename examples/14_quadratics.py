"""
Three ways to fit a quadratic
=============================

See where the paper's quadratic comes too near to an obstacle, and what the other modes do about it.
"""

from __future__ import annotations

import abi

planner = abi.Planner()
slalom = [
    {"shape": "box", "size": [0.4, 8, 12], "position": [2, -0.2, 3]},
    {"shape": "box", "size": [0.4, 8, 12], "position": [4, 6.2, 3]},
]
scene = abi.Scene.from_dict(
    {"version": 1, "start": [0.5, 3, 3], "goal": [5.5, 3, 3], "obstacles": slalom}
).replace(mesh={"pitch": 0.6})

print("mode            pieces  length  clearance  proven   the arm follows")
for mode in ("least_squares", "clear", "pieces"):
    plan = planner(scene.replace(quadratic={"mode": mode}))
    fit, arc = plan.quadratic, plan.quadratic_arc
    assert fit is not None and arc is not None
    print(
        f"{mode:14}  {len(fit.curve.pieces):6}  {arc.length:6.3f}  {fit.clearance.distance:9.3f}"
        f"  {'yes' if fit.holds else 'no':6}   {plan.followed}"
    )

# %%
# A piece is c0 + c1·t + c2·t² between t0 and t1.
assert plan.quadratic is not None
for t0, t1, coefficients in plan.quadratic.curve.pieces:
    print(f"t from {t0:.3f} to {t1:.3f}:", *(f"{row.round(3).tolist()}" for row in coefficients))
