"""
Export a motion
===============

Write the joints over time as CSV and for ROS 2, the whole plan as JSON, and read them back.
"""

from __future__ import annotations

import csv
import json
import tempfile
from pathlib import Path

import abi
from abi.export.formats import FORMATS, export

plan = abi.plan(abi.load_scene("forest"))
folder = tempfile.TemporaryDirectory()
print(f"{len(FORMATS)} formats: {', '.join(FORMATS)}")

# %%
# One row per sample: time [s], joints [rad], q5 and the tool's position [cm]. On the command line
# ``abi export forest --to motion.csv`` does the same.
table = Path(folder.name, "motion.csv")
export(plan, table, "csv")
with table.open(newline="", encoding="utf-8") as file:
    header, first, *rows = csv.reader(file)
print(dict(zip(header, first, strict=True)), f"and {len(rows)} more")

# %%
# The message that a ROS 2 controller takes: positions with their speeds, lengths in metres.
message = Path(folder.name, "motion.ros.json")
export(plan, message, "ros")
points = json.loads(message.read_text(encoding="utf-8"))["points"]
print(len(points), "points, the last at", points[-1]["time_from_start"])

# %%
# The JSON contains what is needed to check the plan elsewhere: curves, certificates and the scene.
whole = Path(folder.name, "plan.json")
export(plan, whole, "json")
again = json.loads(whole.read_text(encoding="utf-8"))
assert again["scene"] == plan.scene.to_dict()
print(f"plan.json: {whole.stat().st_size / 1e3:.0f} kB with {', '.join(again)}")
folder.cleanup()
