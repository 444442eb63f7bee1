"""Table of the layers of a tab, in the order of drawing.

A layer is a part of the picture, in the scene or in a panel: called with the layout of a tab, it
adds what it draws to its containers, and gives what shows a frame there. A new one is a file beside
this one, a line here, and its entries in :mod:`app.state.legend`.
"""

from __future__ import annotations

from collections.abc import Callable

from app.layers.arm.arm import ArmLayer
from app.layers.arm.arm_ghosts import arm_ghosts_layer
from app.layers.arm.arm_regions import arm_regions_layer
from app.layers.arm.joint_trees import joint_trees_layer
from app.layers.base_map import base_map_layer
from app.layers.marks import marks_layer
from app.layers.mesh import MeshLayer
from app.layers.names import names_layer
from app.layers.plan_lines import plan_lines_layer
from app.layers.race import race_layer
from app.layers.result.joint_rates import joint_rates_layer
from app.layers.result.plan_numbers import plan_numbers_layer
from app.layers.result.plots import PlotsLayer
from app.layers.search_step import search_step_layer
from app.layers.workspace import workspace_layer
from app.state.frame import Draw
from app.ui.layout import Layout

Layer = Callable[[Layout], Draw]

LAYERS: tuple[Layer, ...] = (
    plan_numbers_layer,
    PlotsLayer,
    joint_rates_layer,
    workspace_layer,
    MeshLayer,
    plan_lines_layer,
    marks_layer,
    search_step_layer,
    race_layer,
    base_map_layer,
    names_layer,
)
DETAILS: tuple[Layer, ...] = (plan_numbers_layer, PlotsLayer, MeshLayer, names_layer)
"""Layers that a drag can do without for a moment while many tabs drag."""
SLOW_LAYERS: tuple[Layer, ...] = (
    ArmLayer,
    arm_ghosts_layer,
    arm_regions_layer,
    joint_trees_layer,
)
"""Sent in a message of their own: the page takes longer to show them than all the others."""
