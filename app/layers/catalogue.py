"""Table of the layers of a tab, in the order of drawing and of the legend.

A new layer is a file beside this one with a :class:`app.state.frame.Layer`, and a line here.
"""

from __future__ import annotations

from app.layers.arm.arm import ArmLayer
from app.layers.arm.arm_ghosts import ArmGhostsLayer
from app.layers.arm.arm_regions import ArmRegionsLayer
from app.layers.arm.joint_trees import JointTreesLayer
from app.layers.base_map import BaseMapLayer
from app.layers.marks import MarksLayer
from app.layers.mesh import MeshLayer
from app.layers.names import NamesLayer
from app.layers.plan_lines import PlanLinesLayer
from app.layers.race import RaceLayer
from app.layers.result.joint_rates import JointRatesLayer
from app.layers.result.plan_numbers import PlanNumbersLayer
from app.layers.result.plots import PlotsLayer
from app.layers.search_step import TheatreLayer
from app.layers.workspace import WorkspaceLayer
from app.state.frame import Layer

LAYERS: tuple[type[Layer], ...] = (
    PlanNumbersLayer,
    PlotsLayer,
    JointRatesLayer,
    WorkspaceLayer,
    MeshLayer,
    PlanLinesLayer,
    MarksLayer,
    TheatreLayer,
    RaceLayer,
    BaseMapLayer,
    NamesLayer,
)
DETAILS: tuple[type[Layer], ...] = (PlanNumbersLayer, PlotsLayer, MeshLayer, NamesLayer)
"""Layers that a drag can do without for a moment while many tabs drag."""
SLOW_LAYERS: tuple[type[Layer], ...] = (
    ArmLayer,
    ArmGhostsLayer,
    ArmRegionsLayer,
    JointTreesLayer,
)
"""Sent in a message of their own: the page takes longer to show them than all the others."""
