"""Scenes on the server's own machine, whose files are read as uploads are."""

from __future__ import annotations

import contextlib
from pathlib import Path, PurePosixPath

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
from abi.obstacles.triangle_mesh.mesh_source import Files, MeshSource
from abi.robot.urdf.robot_files import SHIPPED, archive_of
from abi.scene import scene_archive
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.scene_file import ENDINGS, parse, read_file
from app.reading.reader import Reader
from app.reading.reading import named_files


def load_local(name: str) -> Scene:
    """Load a shipped scene by name, or a scene file, whose meshes and arm another process reads.

    Raises:
        SceneError: no such scene, not readable, or a field is wrong.
    """
    path = Path(name)
    if name in scene_names() or path.suffix.lower() not in (*ENDINGS, scene_archive.SUFFIX):
        return load_scene(name)
    # longer than an upload may take: nobody else waits for it
    reader = Reader(seconds=120, patience=600.0)
    try:
        if path.suffix.lower() == scene_archive.SUFFIX:
            content = read_file(path, scene_archive.MAX_BYTES)
            data, files = reader.scene(content, path.name)
            return Scene.from_dict(data, MeshSource(dict(files)))
        data = parse(path)
        source = MeshSource(folder=path.parent)
        return Scene.from_dict(data, MeshSource(_read(data, source, reader), path.parent))
    finally:
        reader.close()


def _read(data: object, source: MeshSource, reader: Reader) -> Files:
    """Read the surfaces and the robot that a scene names, by name.

    What is not there is left out: the scene is refused for it, with the name of the field.
    """
    meshes, arms = named_files(data)
    contents: dict[str, bytes] = {}
    archives: dict[str, bytes] = {}
    with contextlib.suppress(SceneError):
        for name in sorted(meshes):
            if PurePosixPath(name).suffix.lower() in SUFFIXES:
                contents[name] = source.content(name)
        for name in arms - SHIPPED.keys():
            archives[name] = archive_of(name, source)
    surfaces = {name: reader.mesh(content, name) for name, content in contents.items()}
    robots = {name: reader.arm(content, name) for name, content in archives.items()}
    return {**surfaces, **robots}
