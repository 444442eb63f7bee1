"""Scene files on their way into a tab."""

from __future__ import annotations

import re
from dataclasses import dataclass

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.file_names import same_name
from abi.obstacles.triangle_mesh.mesh_source import Files, MeshSource
from abi.obstacles.triangle_mesh.signed_distance import body_frame
from abi.obstacles.triangle_mesh.surface import Surface
from abi.scene.scene import Scene
from app.drawing.mesh_picture import drawn_triangles
from app.panels.files.file_uploads import UploadJob, shown_name
from app.reading.reader import READER

_MESH = re.compile(r"obstacles\[\d+\]\.file")
"""Field of a scene that names a mesh."""


@dataclass(frozen=True)
class SceneFile:
    """Contents of a scene file.

    Attributes:
        data: plain data of the scene.
        files: meshes and robots that came with it, by name.
    """

    data: object
    files: Files


def read(job: UploadJob[SceneFile]) -> SceneFile:
    """Read a scene file, and prepare its meshes."""
    job.step("reading", 0.25)
    found = SceneFile(*READER.scene(job.content, job.name, job.stopped, job.wait))
    for name, file in found.files.items():
        if isinstance(file, Surface):
            job.step(f"preparing {shown_name(name)}", 0.75)
            drawn_triangles(file)
            body_frame(file).prepare()  # planning would wait for it
    return found


def parse(found: SceneFile, meshes: MeshSource) -> Scene:
    """The scene of a file, which may name ``meshes`` besides those that came with it.

    Raises:
        SceneError: it is none; names the field.
    """
    source = MeshSource({**meshes.files, **found.files}, meshes.folder)
    try:
        return Scene.from_dict(found.data, source)
    except SceneError as error:
        if _MESH.fullmatch(error.field) is None or error.value in source.files:
            raise
        expected = "it to be added here first (Add a mesh), or to be in one zip with the scene"
        raise SceneError(error.field, error.value, expected) from None


def borrowed(found: SceneFile, scene: Scene, meshes: MeshSource) -> list[str]:
    """Names of the files of a scene that did not come with its file, but were in the tab."""
    return [
        name
        for name in scene.meshes.files
        if same_name(name, found.files) is None and meshes.given(name) is not None
    ]
