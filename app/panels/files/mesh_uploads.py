"""Uploads of mesh files: drawn once they are read, planned with once they are prepared."""

from __future__ import annotations

import viser

from abi.obstacles.mesh_shape import MeshShape
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
from abi.obstacles.triangle_mesh.surface import Surface
from app.drawing.mesh_picture import drawn_triangles
from app.panels.files.file_uploads import FileUploads
from app.panels.files.upload_job import UploadJob
from app.panels.widgets import Wake
from app.reading.reader import READER


def add_mesh_uploads(gui: viser.GuiApi, wake: Wake) -> FileUploads[Surface]:
    """A button that takes one mesh after the other; the page lets several be chosen at once."""
    kinds = ", ".join(suffix[1:].upper() for suffix in SUFFIXES)
    button = gui.add_upload_button(
        "Add a mesh (STL, OBJ, GLB …)",
        mime_type=",".join(SUFFIXES),
        hint=f"{kinds}, up to 50 MB.",
    )
    return FileUploads(gui, button, _prepared, wake, named=safe_name, several=True)


def _prepared(job: UploadJob[Surface]) -> Surface:
    """Read, repair and prepare one file."""
    job.step("reading and repairing", 0.25)
    surface = READER.mesh(job.content, job.name, job.stopped, job.wait)
    job.step("preparing", 0.75)
    drawn_triangles(surface)
    job.is_read(surface)
    MeshShape.of(surface, file=job.name).prepare()
    return surface


def safe_name(name: str) -> str:
    """File name for the scene from an uploaded one, which may have any characters."""
    stem, dot, ending = name.rpartition(".")
    kept = "".join(c if c.isalnum() or c in "-_" else "_" for c in stem)[:60] or "mesh"
    return f"{kept}{dot}{ending.lower()}"
