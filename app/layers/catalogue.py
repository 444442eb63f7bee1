"""Table of the layers of a tab, in the order of drawing and of the legend.

A new layer is a file beside this one with a :class:`app.frame.Layer`, and a line here.
"""

from __future__ import annotations

from app.frame import Layer
from app.layers.arm import ArmLayer
from app.layers.arm_ghosts import ArmGhostsLayer
from app.layers.arm_regions import ArmRegionsLayer
from app.layers.axes import AxesLayer
from app.layers.base_map import BaseMapLayer
from app.layers.curves import CurvesLayer
from app.layers.ghost import GhostLayer
from app.layers.headline import HeadlineLayer
from app.layers.joint_rates import JointRatesLayer
from app.layers.markers import MarkersLayer
from app.layers.mesh import MeshLayer
from app.layers.names import NamesLayer
from app.layers.paper_text import PaperTextLayer
from app.layers.paths import PathsLayer
from app.layers.plots import PlotsLayer
from app.layers.race import RaceLayer
from app.layers.search_order import SearchOrderLayer
from app.layers.stage_notes import StageNotesLayer
from app.layers.tables import TablesLayer
from app.layers.theatre import TheatreLayer
from app.layers.workspace import WorkspaceLayer

LAYERS: tuple[type[Layer], ...] = (
    HeadlineLayer,
    TablesLayer,
    StageNotesLayer,
    PlotsLayer,
    JointRatesLayer,
    WorkspaceLayer,
    AxesLayer,
    MarkersLayer,
    MeshLayer,
    PathsLayer,
    SearchOrderLayer,
    TheatreLayer,
    RaceLayer,
    CurvesLayer,
    GhostLayer,
    BaseMapLayer,
    NamesLayer,
)
DETAILS: tuple[type[Layer], ...] = (TablesLayer, StageNotesLayer, PlotsLayer, MeshLayer, NamesLayer)
"""Layers that a drag can do without for a moment while many tabs drag."""
SLOW_LAYERS: tuple[type[Layer], ...] = (ArmLayer, ArmGhostsLayer, ArmRegionsLayer, PaperTextLayer)
"""Sent in a message of their own: the page takes longer to show them than all the others."""
