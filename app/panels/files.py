"""Scenes to choose, open and save: the shipped ones and the user's files."""

from __future__ import annotations

import re
from pathlib import Path

import viser

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.scene_file import MAX_BYTES, MAX_JSON_BYTES, text_of
from app import page
from app.guard.reader import READER
from app.panels.widgets import Wake

_NAME_LENGTH = 40
"""Letters of a file's name that are shown."""
_OPENED = " (opened)"
"""Behind the name of a file that is called as a shipped scene."""
_MESH = re.compile(r"obstacles\[\d+\]\.file")
"""Field of a scene that names a mesh."""
_FOLDER = re.compile(r"^.*[/\\]")
_ENDING = re.compile(r"\.(ya?ml|json|zip)$", re.IGNORECASE)
_UNFIT = re.compile(r"[^\w.]+")
"""Letters that one system or another has no file name with."""


class FilesPanel:
    """Widgets to choose, open, save and reset; the worker asks what they were used for."""

    def __init__(self, client: viser.ClientHandle, name: str, scene: Scene, wake: Wake) -> None:
        self._client = client
        gui = client.gui
        self._opened: dict[str, Scene] = {} if name in scene_names() else {name: scene}
        self.choice = gui.add_dropdown(
            "scene",
            (*scene_names(), *self._opened),
            initial_value=name,
            hint="The scenes that come with the visualiser, and those you opened.",
        )
        self.upload = gui.add_upload_button(
            "Open a scene file…",
            mime_type=".yaml,.yml,.json,.zip",
            hint=f"YAML up to {MAX_BYTES // 1000} kB, JSON up to {MAX_JSON_BYTES // 1000} kB; or a "
            "zip archive with its meshes.",
        )
        self.save = gui.add_button(
            "Save this scene",
            hint="Downloads it as a YAML file, or as a zip if it has meshes.",
        )
        self.reset = gui.add_button("Back to the scene as loaded", color="gray")
        self._loaded, self._chosen = scene, name
        self._uploaded: object = self.upload.value
        self.choice.on_update(wake)
        self.upload.on_upload(wake)
        self.save.on_click(wake)
        self.reset.on_click(wake)

    @property
    def name(self) -> str:
        """Name of the scene loaded last."""
        return self._chosen

    @property
    def loaded(self) -> Scene:
        """The scene as it was loaded last."""
        return self._loaded

    def restore(self, name: str, scene: Scene) -> None:
        """Take the scene of that name for the one loaded; ``scene`` where none is listed."""
        if name == self._chosen == self.choice.value:
            return
        if name not in (*self._opened, *scene_names()):
            name, self._loaded = self._list(shown_name(name), scene), scene
        else:
            self._loaded = self._opened.get(name) or load_scene(name)
            self.choice.value = name
        self._chosen = name

    def requested(self, meshes: MeshSource) -> Scene | None:
        """The scene chosen, opened or reset since the last call; None for no new one.

        Args:
            meshes: those that an opened file may name besides the shipped ones.
        """
        if self.reset.value:
            self.reset.value = False
            return self._loaded
        if self.upload.value is not self._uploaded:
            self._uploaded = self.upload.value
            name = shown_name(self.upload.value.name)
            try:
                self._loaded = _parse(self.upload.value, name, meshes)
            except SceneError as error:
                page.notify_refusal(self._client, f"{name} is not opened", error.message)
                return None
            self._chosen = self._list(name, self._loaded)
            return self._loaded
        name = self.choice.value
        # a page may send anything: only listed scenes are opened
        if name != self._chosen and (name in self._opened or name in scene_names()):
            self._chosen = name
            self._loaded = self._opened.get(name) or load_scene(name)
            return self._loaded
        return None

    def _list(self, name: str, scene: Scene) -> str:
        """Add an opened scene to the choices, choose it and return its label."""
        name = f"{name}{_OPENED}" if name in scene_names() else name
        self._opened[name] = scene
        self.choice.options = (*scene_names(), *self._opened)
        self.choice.value = name
        return name

    def save_if_requested(self, scene: Scene) -> None:
        """Send the scene as a file if the button was pressed."""
        if not self.save.value:
            return
        self.save.value = False
        try:
            if scene.meshes.files:
                kind, content = ".zip", scene.pack()
            else:
                usual, text = text_of(scene.to_dict())
                kind, content = Path(usual).suffix, text.encode()
        except SceneError as error:
            page.notify_refusal(self._client, "Not saved", error.message)
        else:
            name = file_stem(self._chosen) + kind
            self._client.send_file_download(name, content, save_immediately=True)


def shown_name(name: str) -> str:
    """Name of a file as the page shows it."""
    return "".join(c for c in name if c.isprintable())[-_NAME_LENGTH:].strip() or "a file"


def file_stem(name: str) -> str:
    """Name for the file of a scene, without its ending, that every system takes.

    Args:
        name: of the scene, as the page lists it.
    """
    stem = _ENDING.sub("", _FOLDER.sub("", name.removesuffix(_OPENED)))
    return _UNFIT.sub("-", stem).strip("-.") or "scene"


def _parse(file: viser.UploadedFile, name: str, meshes: MeshSource) -> Scene:
    data, files = READER.scene(file.content, name)
    source = MeshSource({**meshes.files, **files}, meshes.folder)
    try:
        return Scene.from_dict(data, source)
    except SceneError as error:
        if _MESH.fullmatch(error.field) is None or error.value in source.files:
            raise
        expected = "it to be added here first (Add a mesh), or to be in one zip with the scene"
        raise SceneError(error.field, error.value, expected) from None
