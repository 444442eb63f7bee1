"""Meshes of a robot's archive, each found, read once, and counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import PurePosixPath

from abi.errors import SceneError
from abi.obstacles.mesh_files import stl
from abi.obstacles.mesh_files.parts import Parts
from abi.obstacles.mesh_files.words import counted
from abi.obstacles.triangle_mesh import mesh_reader
from abi.robot.urdf.mesh_places import (
    alike,
    guesses,
    length,
    other_folder,
    package_of,
    packages,
    places,
)
from abi.robot.urdf.urdf_joints import some_of

MAX_TRIANGLES = 500_000
"""Most triangles of all shapes of a robot; a shape used twice counts twice."""
_PLAIN = ".plain.stl"
"""Suffix of a file that has been converted to STL."""
_NOTES = "notes.plain.txt"
"""Name of the file with the notes on converted meshes."""
_MARK = "Files that end in .plain.stl are converted from those that the URDF names."
"""First line of that file; without it an archive may be anybody's, and both are told of."""
_MOST_NOTES = 20
_SIMPLE = (".stl", ".obj", ".glb")


class MeshLookup:
    """Meshes of an archive, found where the URDF says or by the ends of their paths.

    Args:
        files: content by path.
        folder: of the URDF.
        plain: whether meshes are as :meth:`plain` converts them, with the digits of an STL.
    """

    def __init__(
        self, files: Mapping[str, bytes], folder: PurePosixPath, plain: bool = False
    ) -> None:
        self._files, self._folder, self._rounds = files, folder, plain
        self._packages = packages(files)
        self._read: dict[str, Parts] = {}
        self._taken: set[str] = set()
        self._guessed: dict[str, str] = {}
        self._several: dict[str, str] = {}
        own = {file: file for file in files}
        self._names = {file.removesuffix(_PLAIN): file for file in files} | own
        self._triangles = 0
        lines = files.get(_NOTES, b"").decode(errors="replace").splitlines()
        self._marked = lines[:1] == [_MARK]
        kept = [line[:200] for line in lines[self._marked :][:_MOST_NOTES]]
        said = kept if self._marked else [f"{_NOTES} says: {line}" for line in kept]
        self._kept = tuple(dict.fromkeys(said))
        self._told: dict[str, dict[str, None]] = {}

    def __call__(self, name: str) -> Parts:
        """Vertices, faces and colours of the mesh that a URDF calls ``name``.

        Raises:
            SceneError: it is not there, not read, or one too many.
        """
        found = self.path(name)
        if found not in self._read:
            mesh = self._mesh(self._files[found], PurePosixPath(found).name)
            if self._rounds and not is_plain(found):
                mesh = stl.read(stl.write(*mesh), MAX_TRIANGLES).parts
            self._read[found] = mesh
        mesh = self._read[found]
        if self._triangles + len(mesh.faces) > MAX_TRIANGLES:
            expected = f"meshes of at most {MAX_TRIANGLES:,} triangles in all"
            raise SceneError("arm.urdf mesh", name, expected)
        self._triangles += len(mesh.faces)
        self._taken.add(found)
        return mesh

    def plain(self) -> dict[str, bytes]:
        """Files of the meshes that were used, those that are not simple converted to STL."""
        plain = {}
        for path in sorted(self._taken):
            if is_plain(path):
                plain[path] = self._files[path]
            else:
                plain[path + _PLAIN] = stl.write(*self._read[path])
        told = self._notes_on_files
        if told or any(path.endswith(_PLAIN) for path in plain):
            # what somebody else called so is told of again
            mark = () if any(file.endswith(_PLAIN) for file in self._guessed.values()) else (_MARK,)
            plain[_NOTES] = "\n".join((*mark, *told)).encode()
        return plain

    def path(self, name: str) -> str:
        """Path in the archive of the mesh that a URDF calls ``name``.

        Raises:
            SceneError: it is not there, or there are several.
        """
        exact = places(self._folder, name, self._packages)
        found = next((one for one in exact if one in self._names), None)
        package = package_of(name) or ""
        of_name = self._packages.get(package, ())
        if found is not None and len(of_name) > 1:
            self._several[package] = found
        if found is None and len(of_name) == 1:
            expected = f"a file that came with the URDF, as {exact[0] if exact else name}"
            raise SceneError("arm.urdf mesh", name, expected)
        meant = self._alike(name) if found is None else found
        file = self._names[meant]
        if file != meant and not self._marked:
            self._guessed[name] = file
        return file

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on files that were used for others, and on what of them is left out."""
        folders = {name: other_folder(name, file) for name, file in self._guessed.items()}
        counts = Counter((package_of(name), found) for name, found in folders.items() if found)
        others = (
            f"{f'Package {package}' if package else 'What the URDF names beside it'} is not there: "
            f"{counted(n, 'mesh', 'meshes')} taken from {found}."
            for (package, found), n in counts.items()
        )
        single = (f"Taken for {k}: {file}." for k, file in self._guessed.items() if not folders[k])
        several = (
            f"Several packages are called {name}; {file} is taken."
            for name, file in self._several.items()
        )
        return (*others, *single, *several, *self._notes_on_files)

    @property
    def _notes_on_files(self) -> tuple[str, ...]:
        """What was kept of them, and each sentence once, behind the files that it is about."""
        told = (f"{some_of([*names])}: {note}" for note, names in self._told.items())
        return tuple(dict.fromkeys((*self._kept, *told)))

    def _mesh(self, content: bytes, name: str) -> Parts:
        """A mesh in its file's axes and in metres, the default unit."""
        suffix = PurePosixPath(name).suffix.lower()
        if suffix not in mesh_reader.SUFFIXES:
            expected = f"a mesh that ends in {', '.join(mesh_reader.SUFFIXES)}"
            raise SceneError("arm.urdf mesh", name, expected)
        try:
            file = mesh_reader.read_file(content, name)
        except SceneError as error:
            raise SceneError("arm.urdf mesh", error.value, error.expected) from None
        notes = [*file.notes[:_MOST_NOTES]]
        if file.metres not in (None, 1.0):
            notes.append(f"Its unit of {file.metres:g} m counts.")
        if file.up != "z":
            notes.append(f"Its {file.up} axis points up, and it is not turned.")
        if file.metres is None and file.commented not in (None, 1.0):
            unit = f"{file.commented:g} m"
            notes.append(f"Its comment names a unit of {unit}; of an arm it counts in metres.")
        for note in notes:
            self._told.setdefault(note, {})[name] = None
        return file.parts._replace(vertices=file.parts.vertices * (file.metres or 1.0))

    def _alike(self, name: str) -> str:
        """File for a name that none has where it says: one in its package's folder elsewhere.

        Else, with a note, one in a folder above the URDF, or the only one whose path shares the
        longest end with the name.
        """
        files, count = alike(self._names, name)
        near = next((one for one in guesses(self._folder, name) if one in self._names), None)
        several = package_of(name) is None and len(files) > 1
        if near is not None and (several or count < length(name)):
            self._guessed[name] = near
            return near
        if len(files) > 1:
            exact = [file for file in files if file.endswith(PurePosixPath(name).name)]
            files = tuple(exact) if len(exact) == 1 else files
        if len(files) != 1:
            expected = "a file that came with the URDF"
            if files:
                expected += f"; of that name there are {', '.join(sorted(files)[:2])}"
            raise SceneError("arm.urdf mesh", name, expected)
        (file,) = files
        exactly = count == length(name) and file.endswith(PurePosixPath(name).name)
        if package_of(name) is None or not exactly:
            self._guessed[name] = file
        return file


def is_plain(path: str) -> bool:
    """Check whether a file needs no slow parsing, as XML meshes do."""
    suffix = PurePosixPath(path).suffix.lower()
    return suffix in _SIMPLE or suffix not in mesh_reader.SUFFIXES
