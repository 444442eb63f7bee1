"""Choice of what is read of an uploaded file that has several: a robot, or a trajectory."""

from __future__ import annotations

import viser

from app.panels.widgets import Wake
from app.reading.stored_upload import StoredUpload

_NONE = "choose one…"


class SeveralInFile:
    """Dropdown with the names in a file that has several; hidden without such a file.

    Attributes:
        handle: the dropdown.
        file: name of the file; empty for none.
        chosen: the name that was chosen last; empty for none.
    """

    def __init__(self, gui: viser.GuiApi, label: str, hint: str, wake: Wake) -> None:
        self.handle = gui.add_dropdown(label, (_NONE,), hint=hint, visible=False)
        self.handle.on_update(wake)
        self.file = self.chosen = ""
        self._content: StoredUpload | None = None
        self._names: tuple[str, ...] = ()

    def offer(self, file: str, content: StoredUpload | None, names: tuple[str, ...]) -> None:
        """Offer the names in a file."""
        self.file, self._content, self._names, self.chosen = file, content, names, ""
        self.handle.visible = content is not None
        self.handle.options = (_NONE, *names)
        self.handle.value = _NONE

    def forget(self) -> None:
        """Offer nothing any more, as another file was read."""
        self.offer("", None, ())

    def asked(self) -> tuple[StoredUpload, str] | None:
        """Content of the file, and the name chosen since the last call; None for none."""
        name = self.handle.value
        if self._content is None or name not in self._names or name == self.chosen:
            return None
        self.chosen = name
        return self._content, name
