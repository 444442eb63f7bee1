"""
Your own scene
==============

Describe a scene as plain data, save it as a file that you can edit, load it again and plan it.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import abi

scene = abi.Scene.from_dict(
    {
        "version": 1,
        "unit": "m",
        "workspace": {"min": [-0.5, -0.5, 0.0], "max": [0.5, 0.5, 0.8]},
        "start": [-0.4, 0.0, 0.1],
        "goal": [0.4, 0.1, 0.6],
        "obstacles": [
            {"shape": "box", "size": [0.1, 0.7, 0.5], "position": [-0.1, 0.1, 0.25]},
            {"shape": "sphere", "radius": 0.15, "position": [0.2, -0.1, 0.5]},
        ],
        "mesh": {"pitch": 0.08},
        "spline": {"clearance": 0.02},
        "motion": {"speed": 0.3, "acceleration": 0.6, "deceleration": 0.6},
        "arm": {"base": [0, -0.9, 0], "a1": 0.1, "a2": 0.2, "a3": 0.8, "a4": 0.5, "a5": 0.3},
    }
)

# %%
# The file is YAML here; with the ending ``.json`` it would be JSON. It loads as the same scene.
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "cell.yaml")
    scene.save(file)
    print(file.read_text(encoding="utf-8"))
    assert abi.load_scene(file) == scene

# %%
# A mistake gives one sentence that names the field, the value and what would work.
try:
    scene.replace(mesh={"pitch": "fine"})
except abi.SceneError as error:
    print(error)

# %%
plan = abi.plan(scene)
assert plan.error is None and plan.path is not None
print(f"from {scene.start} to {scene.goal} [{scene.unit}]: {plan.path.length:.3f} m on edges")
