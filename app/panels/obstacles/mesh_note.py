"""What is to be known of a mesh: its file, size and repairs, and other sizes to offer."""

from __future__ import annotations

import html

from abi.obstacles.mesh_shape import MeshShape, file_factor, suggest_unit
from abi.obstacles.pose import METRES
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app.drawing.mesh_picture import MOST_DRAWN
from app.ui.numbers import format_setting

_FITTED = 1 / 3
_LEAST, _MOST = 1 / 12, 3 / 4
"""Sizes, as parts of the workspace's longest side: when fitted, and between which none is."""


def fitted_scale(surface: Surface, scene: Scene, unit: str | None = None) -> float:
    """Scale that makes a mesh a third of the workspace; 1 where its size will do as it is.

    Args:
        surface: of the mesh.
        scene: whose workspace it is to fit.
        unit: of the file; None for the one that the file gives, or else the scene's.
    """
    largest, extent = max(scene.workspace.size), _own_extent(surface, scene, unit)
    if _LEAST <= extent / largest <= _MOST:
        return 1.0
    return max(float(f"{_FITTED * largest / extent:.3g}"), 1e-6)


def _own_extent(surface: Surface, scene: Scene, unit: str | None) -> float:
    """Longest side of a file's bounds at scale 1, [unit]."""
    return surface.extent * file_factor(surface, unit, scene.unit)


def suggested_unit(mesh: MeshShape, scene: Scene) -> str:
    """Unit of a mesh's file in which its size would suit the scene better; empty for none."""
    metres = METRES[scene.unit] * file_factor(mesh.surface, mesh.unit, scene.unit)
    return suggest_unit(_extent(mesh), scene.workspace.size, metres) or ""


def other_scale(mesh: MeshShape, scene: Scene) -> tuple[str, float] | None:
    """Scale to offer, and what it gives: the file's size where it was fitted, or one that fits."""
    own = _own_extent(mesh.surface, scene, mesh.unit)
    if _is_fitted(mesh, scene):
        return f"Original size: {_length(own, scene)}", 1.0
    largest = max(scene.workspace.size)
    if _LEAST <= _extent(mesh) / largest <= _MOST:
        return None
    return "Fit to the workspace", float(f"{_FITTED * largest / own:.3g}")


def mesh_note(mesh: MeshShape, scene: Scene) -> str:
    """A mesh's file, size and repairs, as HTML."""
    count = len(mesh.surface.faces)
    notes = [f"{mesh.file}: {count:,} triangles, {_length(_extent(mesh), scene)} wide."]
    notes += mesh.notes
    if count > MOST_DRAWN:
        notes.append("Planning uses all of them; the picture shows fewer.")
    if _is_fitted(mesh, scene):
        notes.append("It was scaled to fit the workspace.")
    if unit := suggested_unit(mesh, scene):
        notes.append(f"That is far from the workspace's size: is the file in {unit}?")
    text = html.escape(" ".join(notes))
    return f'<div style="margin:0 10px;font-size:12.5px">{text}</div>'


def _is_fitted(mesh: MeshShape, scene: Scene) -> bool:
    return bool(mesh.scale == fitted_scale(mesh.surface, scene, mesh.unit) != 1)


def _extent(mesh: MeshShape) -> float:
    """Longest side of a mesh's bounds, [unit]."""
    return mesh.surface.extent * mesh.factor


def _length(length: float, scene: Scene) -> str:
    digits = f"{length:,.0f}" if length >= 1000 else format_setting(length)
    return f"{digits} {scene.unit}"
