"""Scene files on their way into a tab."""

from __future__ import annotations

import re

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.file_names import same_name
from abi.obstacles.triangle_mesh.mesh_source import Files, MeshSource
from abi.obstacles.triangle_mesh.signed_distance import surface_tables
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app.drawing.mesh_picture import drawn_triangles
from app.panels.files.file_uploads import shown_name
from app.panels.files.upload_job import UploadJob
from app.reading.reader import READER

_MESH = re.compile(r"obstacles\[\d+\]\.file")
"""Field of a scene that names a mesh."""


def read(job: UploadJob[tuple[object, Files]]) -> tuple[object, Files]:
    """Read a scene file, and prepare its meshes: its data, and the files that came with it."""
    job.step("reading", 0.25)
    data, files = READER.scene(job.content, job.name, job.stopped, job.wait)
    for name, file in files.items():
        if isinstance(file, Surface):
            job.step(f"preparing {shown_name(name)}", 0.75)
            drawn_triangles(file)
            surface_tables(file)  # planning would wait for it
    return data, files


def parse(data: object, files: Files, meshes: MeshSource) -> Scene:
    """The scene of a file's data, which may name ``meshes`` besides those that came with it.

    Raises:
        SceneError: it is none; names the field.
    """
    source = MeshSource({**meshes.files, **files}, meshes.folder)
    try:
        return Scene.from_dict(data, source)
    except SceneError as error:
        if _MESH.fullmatch(error.field) is None or error.value in source.files:
            raise
        expected = "it to be added here first (Add a mesh), or to be in one zip with the scene"
        raise SceneError(error.field, error.value, expected) from None


def borrowed(files: Files, scene: Scene, meshes: MeshSource) -> list[str]:
    """Names of the scene's files that are not of the ``files`` that came with it, but the tab's."""
    return [
        name
        for name in scene.meshes.files
        if same_name(name, files) is None and meshes.given(name) is not None
    ]
