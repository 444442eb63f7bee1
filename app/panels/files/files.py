"""Choosing, opening and saving of scenes: shipped ones and the user's files."""

from __future__ import annotations

import re
from pathlib import Path

import viser

from abi.errors import AbiError, SceneError
from abi.obstacles.triangle_mesh.mesh_source import Files, MeshSource
from abi.scene.scene import Scene, load_scene, scene_names
from abi.scene.scene_file import MAX_BYTES, MAX_JSON_BYTES, text_of
from app.panels.files.file_uploads import FileUploads, shown_name
from app.panels.files.scene_uploads import borrowed, parse, read
from app.panels.widgets import Wake, pressed
from app.state.frame import Frame
from app.ui import notices
from app.ui.cards import cards
from app.ui.scene_cards import scene_cards

_OPENED = " (opened)"
"""Behind the name of a file that is called as a shipped scene."""
_FOLDER = re.compile(r"^.*[/\\]")
_ENDING = re.compile(r"\.(ya?ml|json|zip)$", re.IGNORECASE)
_UNFIT = re.compile(r"[^\w.]+")
"""Letters that one system or another has no file name with."""


class FilesPanel:
    """Widgets to choose, open, save and reset; the worker asks what they were used for.

    Attributes:
        name: of the scene loaded last, as the page lists it.
        loaded: that scene, without what was changed since.
    """

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
        self._cards = gui.add_html("")
        self._shown = ""
        self.reset = gui.add_button(
            "Reset scene",
            color="gray",
            hint="As it was when it was chosen or opened; Undo takes that back.",
        )
        self.upload = gui.add_upload_button(
            "Open a scene file…",
            mime_type=".yaml,.yml,.json,.zip",
            hint=f"YAML up to {MAX_BYTES // 1000} kB, JSON up to {MAX_JSON_BYTES // 1000} kB; or a "
            "zip archive with its meshes.",
        )
        self.uploads = FileUploads(gui, self.upload, read, wake)
        self.save = gui.add_button(
            "Save this scene",
            hint="Downloads it as a YAML file, or as a zip if it has meshes.",
        )
        self.name, self.loaded = name, scene
        self.choice.on_update(wake)
        self.save.on_click(wake)
        self.reset.on_click(wake)

    def draw(self, frame: Frame) -> None:
        """Show what the scenes are about, once there is time, and which one is chosen."""
        if self._shown != self.name and not (frame.interactive or frame.plan.partial):
            self._shown = self.name
            self._cards.content = cards(scene_cards(self.choice, self.name), few=True)

    def show(self, name: str, loaded: Scene) -> None:
        """Take a scene loaded earlier, listed under ``name``, for the one loaded last."""
        self.name, self.loaded = name, loaded
        if self.choice.value != name:
            self.choice.value = name

    def open_shipped(self, name: str) -> Scene:
        """Choose a shipped scene and return it."""
        self.show(name, load_scene(name))
        return self.loaded

    def restore(self, name: str, scene: Scene) -> None:
        """Take the scene of that name for the one loaded; ``scene`` where none is listed."""
        if name == self.name == self.choice.value:
            return
        if name not in (*self._opened, *scene_names()):
            self.name, self.loaded = self._list(shown_name(name), scene), scene
        else:
            self.show(name, self._opened.get(name) or load_scene(name))

    def requested(self, meshes: MeshSource) -> Scene | None:
        """The scene chosen, opened or reset since the last call; None for no new one.

        Args:
            meshes: those that an opened file may name besides the shipped ones.
        """
        if pressed(self.reset):
            return self.loaded
        name = self.choice.value
        # a page may send anything: only listed scenes are opened
        if name != self.name and (name in self._opened or name in scene_names()):
            self.uploads.drop()
            self.name, self.loaded = name, self._opened.get(name) or load_scene(name)
            return self.loaded
        opened = [self._open(one.name, one.result, meshes) for one in self.uploads.ended()]
        return self.loaded if any(opened) else None

    def _open(
        self, name: str, found: tuple[object, Files] | AbiError | None, meshes: MeshSource
    ) -> bool:
        """Load what was read; False where that is no scene."""
        try:
            if found is None:
                return False
            if isinstance(found, AbiError):
                raise found
            data, files = found
            scene = parse(data, files, meshes)
        except AbiError as error:
            notices.notify_refusal(self._client, f"{name} is not opened", error.message, stays=True)
            return False
        if taken := borrowed(files, scene, meshes):
            names = ", ".join(taken)
            reason = f"{names} of this tab was taken, since nothing came with the scene."
            notices.notify_warning(self._client, f"{name} names what is not in it", reason)
        self.name, self.loaded = self._list(name, scene), scene
        return True

    def _list(self, name: str, scene: Scene) -> str:
        """Add an opened scene to the choices, choose it and return its label."""
        name = f"{name}{_OPENED}" if name in scene_names() else name
        self._opened[name] = scene
        self.choice.options = (*scene_names(), *self._opened)
        self.choice.value = name
        return name

    def save_if_requested(self, scene: Scene) -> None:
        """Send the scene as a file if the button was pressed."""
        if not pressed(self.save):
            return
        try:
            if scene.meshes.files:
                kind, content = ".zip", scene.pack()
            else:
                usual, text = text_of(scene.to_dict())
                kind, content = Path(usual).suffix, text.encode()
        except SceneError as error:
            notices.notify_refusal(self._client, "Not saved", error.message)
        else:
            name = file_stem(self.name) + kind
            self._client.send_file_download(name, content, save_immediately=True)


def file_stem(name: str) -> str:
    """Name for the file of a scene, without its ending, that every system takes.

    Args:
        name: of the scene, as the page lists it.
    """
    stem = _ENDING.sub("", _FOLDER.sub("", name.removesuffix(_OPENED)))
    return _UNFIT.sub("-", stem).strip("-.") or "scene"
