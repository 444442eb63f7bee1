"""
Certificates
============

Look at the planes that prove a curve clear, check them in exact arithmetic, and see a forgery fail.
"""

from __future__ import annotations

import json

import abi
from abi.verify.verify import verify

plan = abi.plan(abi.load_scene("forest"))
curve = plan.bspline
assert curve is not None
proof = curve.clearance.certificate
assert proof is not None

print(f"every point keeps more than {proof.margin:.6f} cm from every obstacle, because")
for (first, last), obstacle, normal in list(
    zip(proof.pieces, proof.obstacle, proof.directions, strict=True)
)[:4]:
    x, y, z = normal
    print(f"  t = {first:.3f} to {last:.3f} is beyond obstacle {obstacle + 1}", end="")
    print(f" in direction ({x:+.3f}, {y:+.3f}, {z:+.3f})")
print(f"  … {len(proof.obstacle)} planes in all")

# %%
# The JSON of a plan contains its certificates. The verifier shares no code with the code that made
# them, and decides each inequality in exact rational numbers.
written = json.loads(json.dumps(plan.to_dict()))
for verdict in verify(written):
    print(verdict)

# %%
# Move one control point and keep the certificate: the old planes do not prove the new curve.
written["bspline"]["control_points"][2][0] += 0.5
verdict, *_ = verify(written)
assert not verdict.proven
print(verdict)
