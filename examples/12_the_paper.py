"""
The paper
=========

Compute the paper's figures anew and count which of its statements hold.
"""

from __future__ import annotations

from collections import Counter

import abi
from abi.explain.paper.reproduction import compare

found = compare()
for verdict, count in Counter(one.verdict for one in found).items():
    print(f"{count:3} {verdict}")

# %%
# Printed statements that do not hold, and what we find instead.
for one in found:
    if one.verdict == "does not hold":
        print(f"{one.section}, {one.subject}\n    printed: {one.printed}\n    ours:    {one.ours}")

# %%
# Table I: with Euclidean weights the three searches tie, weighted by hops they differ in length.
for weight in ("length", "hops"):
    plan = abi.plan(abi.load_scene("paper").replace(search={"weight": weight}))
    lengths = ", ".join(f"{path.algorithm} {path.length:.3f} cm" for path in plan.searches)
    print(f"by {weight}: {lengths}")
