"""Source of a scene's mesh files: its folder, an upload, or a scene already loaded."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from functools import cached_property, lru_cache
from pathlib import Path, PurePosixPath

from abi.errors import SceneError, short
from abi.obstacles.triangle_mesh.file_names import same_name, same_path
from abi.obstacles.triangle_mesh.mesh_reader import MAX_BYTES, SUFFIXES, read_surface
from abi.obstacles.triangle_mesh.surface import Surface

_MOST_NAMED = 100
"""Most files of one name that are looked at in a folder."""

Files = Mapping[str, object]
"""Files of a scene by their names: bytes that are still to be read, or a surface or robot that they
were read as.
"""


class MeshSource:
    """Surfaces of mesh files by their names in the scene.

    Args:
        files: content of each file by its name, or what was read of it; looked at first.
        folder: the folder that holds the scene file; nothing outside it is opened.
        otherwise: where to find a surface that is not here, by its name and the error; None for
            nowhere.
    """

    def __init__(
        self,
        files: Files | None = None,
        folder: Path | None = None,
        otherwise: Callable[[str, SceneError], Surface] | None = None,
    ) -> None:
        self.files: dict[str, object] = dict(files or {})
        self.folder, self._otherwise = folder, otherwise

    @classmethod
    def of(cls, origin: str | Path | Files | MeshSource | None) -> MeshSource:
        """A source for a scene's folder, for uploaded files by name, or for no files."""
        if isinstance(origin, MeshSource):
            return origin
        if not isinstance(origin, str | Path | Mapping | None):
            raise SceneError("folder", origin, "a folder, or the content of each file by its name")
        return cls(folder=Path(origin)) if isinstance(origin, str | Path) else cls(origin)

    def surface(self, name: str) -> Surface:
        """The cleaned surface of the mesh file ``name``.

        Raises:
            SceneError: there is no such file, it is outside the folder, or it is no mesh.
        """
        try:
            return self._surface_here(name)
        except SceneError as error:
            if self._otherwise is None:
                raise
            return self._otherwise(name, error)

    def _surface_here(self, name: str) -> Surface:
        """The surface of a file that is given or in the folder."""
        _check_name(name)
        if PurePosixPath(name).suffix.lower() not in SUFFIXES:
            raise SceneError("file", name, f"a file that ends in {', '.join(SUFFIXES)}")
        content = self.given(name)
        if isinstance(content, Surface):
            return content
        if not isinstance(content, bytes | None):
            raise SceneError("file", name, f"its content as bytes, not {short(content)}")
        return _surface(content if content is not None else self._content(name), name)

    def content(self, name: str) -> bytes:
        """Content of the file ``name``, at most 50 MB.

        Raises:
            SceneError: there is no such file, or it is outside the folder.
        """
        _check_name(name)
        content = self.given(name)
        return content if isinstance(content, bytes) else self._content(name)

    def named(self, name: str, beside: PurePosixPath) -> dict[str, bytes]:
        """Content of the files of a name, by path: in the folders above a path, or one below these.

        Args:
            name: of the files.
            beside: a folder inside this source.
        """
        paths = [path for path in self.files if PurePosixPath(path).name == name]
        if self.folder is not None:
            for above in (beside, *beside.parents):
                inside = self.folder / above
                found = [*inside.glob(name), *sorted(inside.glob(f"*/{name}"))[:_MOST_NAMED]]
                paths += [path.relative_to(self.folder).as_posix() for path in found]
        contents = {}
        for path in dict.fromkeys(paths):
            with contextlib.suppress(SceneError):
                contents[path] = self.content(path)
        return contents

    def given(self, name: str) -> object | None:
        """File given under a name, up to Unicode normalisation; None if it is in the folder."""
        same = same_name(name, self.files)
        return None if same is None else self.files[same]

    @cached_property
    def _resolved(self) -> Path:
        """The folder without links.

        Raises:
            OSError: it is not there.
        """
        assert self.folder is not None
        return self.folder.resolve(strict=True)

    def _content(self, name: str) -> bytes:
        if self.folder is None:
            known = ", ".join(sorted(self.files)[:5])
            expected = (
                f"one of the files given: {known}"
                if known
                else "its file to be given too, as folder= of Scene.from_dict or files= of replace"
            )
            raise SceneError("file", name, expected)
        try:
            path = same_path(self._resolved, name).resolve(strict=True)
            if not path.is_relative_to(self._resolved):
                raise SceneError("file", name, "a file in the scene's folder, not a link out of it")
            if not path.is_file():
                raise SceneError("file", name, "a file, not a folder")
            with path.open("rb") as file:
                return file.read(MAX_BYTES + 1)
        except (OSError, RuntimeError) as error:
            reason = (getattr(error, "strerror", None) or "unreadable").lower()
            raise SceneError("file", name, f"a file that can be read ({reason})") from None


def _check_name(name: str) -> None:
    """Refuse a name that is not a plain relative path on every system."""
    parts = name.split("/")
    if not name.isprintable() or any(c in name for c in '\\:*?"<>|'):
        raise SceneError("file", name, 'a plain name with "/" between folders')
    if name.startswith("/") or any(part in ("", ".", "..") for part in parts):
        raise SceneError("file", name, "a path inside the scene's folder, without .. or a root")


@lru_cache(maxsize=8)
def _surface(content: bytes, name: str) -> Surface:
    return read_surface(content, name)
