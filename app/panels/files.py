"""Which scene: the shipped ones, a file from the user's disk, and back to disk."""

from __future__ import annotations

import viser

from abi.errors import SceneError
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.scene_file import MAX_BYTES, dump, parse_bytes
from app import page
from app.panels.widgets import Wake

_MOST = f"{MAX_BYTES // 1000} kB"
_LONGEST = 40
"""Letters of a file's name that are shown."""


class FilesPanel:
    """Choose, open, save, reset. Everything is noticed by the worker; nothing runs here."""

    def __init__(self, client: viser.ClientHandle, name: str, scene: Scene, wake: Wake) -> None:
        self._client = client
        gui = client.gui
        self._own: dict[str, Scene] = {} if name in scene_names() else {name: scene}
        self.choice = gui.add_dropdown(
            "scene",
            (*scene_names(), *self._own),
            initial_value=name,
            hint="The scenes that come with the visualiser, and what was opened.",
        )
        self.upload = gui.add_upload_button(
            "Open a scene file…", mime_type=".yaml,.yml,.json", hint=f"YAML or JSON, up to {_MOST}."
        )
        self.save = gui.add_button("Save this scene", hint="Downloads scene.yaml.")
        self.reset = gui.add_button("Back to the scene as loaded")
        self._loaded, self._chosen = scene, name
        self._uploaded: object = self.upload.value
        self.choice.on_update(wake)
        self.upload.on_upload(wake)
        self.save.on_click(wake)
        self.reset.on_click(wake)

    def requested(self, meshes: MeshSource) -> Scene | None:
        """The scene that the user asked for since the last call; None when for none.

        Args:
            meshes: what an opened scene file may name besides.

        """
        if self.reset.value:
            self.reset.value = False
            return self._loaded
        if self.upload.value is not self._uploaded:
            self._uploaded = self.upload.value
            name = _plain(self.upload.value.name)
            try:
                self._loaded = _checked(self.upload.value, name, meshes)
            except SceneError as error:
                page.refuse(self._client, f"{name} is not opened", error.message)
                return None
            self._chosen = self._listed(name, self._loaded)
            return self._loaded
        name = self.choice.value
        # a page may send anything: only what is listed is opened
        if name != self._chosen and (name in self._own or name in scene_names()):
            self._chosen = name
            self._loaded = self._own.get(name) or load_scene(name)
            return self._loaded
        return None

    def _listed(self, name: str, scene: Scene) -> str:
        """Put an opened scene among the choices and choose it."""
        name = f"{name} (opened)" if name in scene_names() else name
        self._own[name] = scene
        self.choice.options = (*scene_names(), *self._own)
        self.choice.value = name
        return name

    def save_when_asked(self, scene: Scene) -> None:
        """Send the scene as a file when the button was pressed."""
        if not self.save.value:
            return
        self.save.value = False
        try:
            text = dump(scene.to_dict(), "scene.yaml")
        except SceneError as error:
            page.refuse(self._client, "Not saved", error.message)
        else:
            name, content = "scene.yaml", text.encode()
            self._client.send_file_download(name, content, save_immediately=True)


def _plain(name: str) -> str:
    """The name of a file as it can be shown."""
    return "".join(c for c in name if c.isprintable())[-_LONGEST:].strip() or "a file"


def _checked(file: viser.UploadedFile, name: str, meshes: MeshSource) -> Scene:
    if len(file.content) > MAX_BYTES:
        raise SceneError("scene", name, f"a file of at most {_MOST}")
    return Scene.from_dict(parse_bytes(file.content, name), meshes)
