"""
An obstacle from an STL file
============================

Make a ring with trimesh, add its STL to a scene and plan a path through the hole.
"""

from __future__ import annotations

import trimesh

import abi

ring = trimesh.creation.torus(major_radius=20, minor_radius=6)  # in millimetres, say
stl = ring.export(file_type="stl")
assert isinstance(stl, bytes)
print(f"ring.stl: {len(ring.faces)} triangles, {len(stl)} bytes")

# %%
# The content comes with the data, by name. A scene file finds its meshes in its own folder.
scene = abi.Scene.from_dict(
    {
        "version": 1,
        "unit": "cm",
        "start": [4.8, 1, 3],
        "goal": [4.4, 5.2, 3.4],
        "obstacles": [
            {
                "shape": "mesh",
                "file": "ring.stl",
                "unit": "mm",
                "position": [3, 3, 3],
                "wxyz": [0.7071067811865476, 0.7071067811865476, 0, 0],
            }
        ],
        "mesh": {"pitch": 0.5},
        "spline": {"clearance": 0.1},
        "arm": {"avoid": False},  # through the ring goes the tool alone
    },
    {"ring.stl": stl},
)
plan = abi.plan(scene)
assert plan.error is None and plan.bspline is not None and plan.taut is not None

# %%
middle = plan.bspline.curve(0.5)
away = float(((middle - scene.obstacles[0].position) ** 2).sum() ** 0.5)
print(f"half-way the curve is {away:.2f} cm from the ring's centre; the hole's radius is 1.4 cm")
print(f"taut path {plan.taut.length:.3f} cm, straight line {plan.straight_length:.3f} cm")
print(f"proven clearance: {plan.bspline.clearance.distance:.4f} cm")
