"""
Export a motion
===============

Write the joints over time as CSV and the whole plan as JSON, for other programs to read.
"""

from __future__ import annotations

import csv
import json
import tempfile
from pathlib import Path

import abi

plan = abi.plan(abi.load_scene("forest"))
data = plan.to_dict(full=True)  # every sample, not just 200
arm = data["arm"]

# %%
# One row a sample: time [s], joints [rad], q5 and the tool's place [cm].
folder = tempfile.TemporaryDirectory()
table = Path(folder.name, "motion.csv")
with table.open("w", newline="", encoding="utf-8") as file:
    writer = csv.writer(file)
    writer.writerow(["time", *arm["joints"], "x", "y", "z"])
    for time, joints, tool in zip(arm["time"], arm["positions"], arm["tool"], strict=True):
        writer.writerow([time, *joints, *tool])
print(*table.read_text(encoding="utf-8").splitlines()[:3], sep="\n")

# %%
# The JSON has what it takes to check it elsewhere: curves, certificates, the scene itself.
whole = Path(folder.name, "plan.json")
whole.write_text(json.dumps(data), encoding="utf-8")
again = json.loads(whole.read_text(encoding="utf-8"))
assert again["arm"] == arm
print(f"plan.json: {whole.stat().st_size / 1e3:.0f} kB with {', '.join(again)}")
folder.cleanup()
