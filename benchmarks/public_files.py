"""Robots and meshes of public packages, as they are read here and by independent readers.

    python -m benchmarks.public_files FOLDER…

Each folder holds the files of packages, unpacked; nothing of them comes with this repository:

    pip download --no-deps --only-binary :all: -d wheels example-robot-data rtb-data
    pip download --no-deps --only-binary :all: -d wheels --python-version 3.9 pybullet
    for wheel in wheels/*.whl; do unzip -q $wheel -d FOLDER/$(basename $wheel); done

``python -m benchmarks.public_files assets/urdf --states 1000`` compares the arms that come along.

Of each URDF the poses of all links are compared at random states with those of yourdfpy and
Pinocchio, and where neither reads all that a file has (a joint that follows a follower) with the
file's own numbers, multiplied out. Of each mesh the number of triangles, the bounds and the volume
are compared with those of trimesh, meshio and pycollada. A file is ``read`` if one of them has the
same; the columns of their names count the files in which each has. Refusals and differences are
printed with their sentences.
"""

from __future__ import annotations

import argparse
import collections
import logging
import re
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath
from typing import NamedTuple

import numpy as np
import trimesh

from abi.errors import SceneError
from abi.obstacles.mesh_files.parts import Parts
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.urdf.link_names import names_anew
from abi.robot.urdf.mesh_lookup import MeshLookup
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import archive_of, unpacked
from abi.robot.urdf.strict_xml import parse
from abi.robot.urdf.urdf_reader import read_urdf
from benchmarks import mesh_readers, robot_readers
from benchmarks.report import Row, table

_STATES = 100
_HELD_STATES = 3
"""States at which the joints beside a tip are held, too, as planning does."""
_NEAR = 1e-9
"""Difference of a pose that counts as none, over the largest coordinate and 1 m."""
_NEAR_MESH = 1e-6
"""The same of the bounds and the volume of a mesh, over its size."""
_SEVERAL = "random_urdfs"
"""Folder of pybullet with a thousand solids, one a URDF: counted by themselves."""

_VARIABLE = re.compile(rb"\$\(optenv \w+ ([^)]*)\)")
"""A variable of the environment, with its default."""


class Outcome(NamedTuple):
    """What came of a file.

    Attributes:
        file, kind: its path and its row in the table.
        outcome: ``read``, ``refused``, ``different``, or ``alone`` if no other reader reads it.
        by: the readers that have the same.
        why: what the others say, or why it is refused.
    """

    file: str
    kind: str
    outcome: str
    by: tuple[str, ...] = ()
    why: str = ""


def read_robot(file: Path, folder: Path) -> Robot:
    """The robot of a URDF in its package, as a scene in ``folder`` would have it.

    Raises:
        SceneError: it is refused.
    """
    files = unpacked(archive_of(file.relative_to(folder).as_posix(), MeshSource(folder=folder)))
    (path,) = (one for one in files if one.lower().endswith(".urdf"))
    return read_urdf(files[path], file.name, MeshLookup(files, PurePosixPath(path).parent))


def compare_robot(file: Path, folder: Path, states: int = _STATES) -> Outcome:
    """Read a URDF, and compare the poses of its links with those of other readers."""
    kind = "solids of pybullet" if _SEVERAL in file.parts else "robots"
    name = file.relative_to(folder).as_posix()
    try:
        robot = read_robot(file, folder)
    except SceneError as error:
        return Outcome(name, kind, "refused", why=error.message)
    # none of the others reads zeros after the end of a text, or what xacro left of a variable
    content = _VARIABLE.sub(rb"\1", file.read_bytes().rstrip(b"\0"))
    random = np.random.default_rng(len(robot.links))
    positions = {
        one.name: random.uniform(one.low, one.high, states)
        for one in robot.joints
        if one.kind != "fixed" and one.follows is None
    }
    ours = robot_readers.poses_of(robot, positions)
    if (gap := _gap_with_tip(robot, positions, ours)) > _NEAR:
        return Outcome(name, kind, "different", why=f"poses with a tip differ by {gap:.2g}")
    anew = {new: own for own, new in names_anew(parse(file.read_bytes(), name)).items()}
    ours = {anew.get(link, link): poses for link, poses in ours.items()}
    same, told = [], []
    for by, opened in robot_readers.READERS.items():
        most = robot_readers.MOST_STATES.get(by)
        first = {name: at[:most] for name, at in positions.items()}
        here = {link: poses[:most] for link, poses in ours.items()}
        try:
            gap = _largest_gap(here, opened(content)(first))
        except Exception as error:  # whatever another library raises
            told.append(f"{by}: {type(error).__name__}")
            continue
        if gap <= _NEAR:
            same.append(by)
        else:
            told.append(f"{by}: poses differ by {gap:.2g}")
    outcome = "read" if same else "different"
    return Outcome(name, kind, outcome, tuple(same), ", ".join(told))


def _largest_gap(ours: robot_readers.Poses, theirs: robot_readers.Poses) -> float:
    """Largest difference of any link's poses, over the largest coordinate and 1 m."""
    size = max(1.0, *(float(np.abs(poses).max()) for poses in ours.values()))
    return max(float(np.abs(poses - theirs[link]).max()) for link, poses in ours.items()) / size


def _gap_with_tip(
    robot: Robot, positions: robot_readers.States, ours: robot_readers.Poses
) -> float:
    """The same at the first states, between all joints planned and some of them held."""
    worst = 0.0
    for number in range(_HELD_STATES if positions else 0):
        state = {name: float(at[number]) for name, at in positions.items()}
        here = {link: poses[number : number + 1] for link, poses in ours.items()}
        worst = max(worst, _largest_gap(robot_readers.poses_with_tip(robot, state), here))
    return worst


def compare_mesh(file: Path, folder: Path) -> Outcome:
    """Read a mesh, and compare its triangles with those of other readers."""
    name, kind = file.relative_to(folder).as_posix(), f"meshes {file.suffix.lower()}"
    try:
        ours = _solid(mesh_reader.read_file(file.read_bytes(), file.name).parts)
    except SceneError as error:
        return Outcome(name, kind, "refused", why=error.message)
    same, told = [], []
    for by, (opened, endings) in mesh_readers.READERS.items():
        if file.suffix.lower() not in endings:
            continue
        try:
            other = opened(file)
        except Exception as error:  # whatever another library raises
            told.append(f"{by}: {type(error).__name__}")
            continue
        if gap := _mesh_gap(ours, other):
            told.append(f"{by}: {gap}")
        else:
            same.append(by)
    differs = any("differ" in one for one in told)
    outcome = "read" if same else "different" if differs else "alone"
    return Outcome(name, kind, outcome, tuple(same), ", ".join(told))


def _solid(parts: Parts) -> trimesh.Trimesh:
    return trimesh.Trimesh(parts.vertices, parts.faces, process=False)


def _mesh_gap(ours: trimesh.Trimesh, other: trimesh.Trimesh) -> str:
    """In what two surfaces differ; empty if in nothing."""
    if other.bounds is None:
        return "nothing is read"
    size = float(np.ptp(ours.bounds, axis=0).max())
    found = {
        f"triangles differ, {len(other.faces):,} of {len(ours.faces):,}": len(other.faces)
        != len(ours.faces),
        "bounds differ": np.abs(ours.bounds - other.bounds).max() > _NEAR_MESH * size,
        "volumes differ": abs(ours.volume - other.volume) > _NEAR_MESH * size**3,
    }
    return ", ".join(name for name, differs in found.items() if differs)


def compare(folder: Path, meshes: bool = True, states: int = _STATES) -> Iterator[Outcome]:
    """Outcome of each file below a folder, in the order of their names."""
    for file in sorted(folder.rglob("*")):
        if file.suffix.lower() == ".urdf":
            yield compare_robot(file, folder, states)
        elif meshes and file.suffix.lower() in mesh_reader.SUFFIXES:
            yield compare_mesh(file, folder)


def rows_of(outcomes: Iterable[Outcome]) -> list[Row]:
    """A row for each kind of file: what came of how many, and in how many each reader agrees."""
    by_kind: dict[str, list[Outcome]] = {}
    for one in outcomes:
        by_kind.setdefault(one.kind, []).append(one)
    return [_row(kind, found) for kind, found in sorted(by_kind.items())]


def _row(kind: str, found: list[Outcome]) -> Row:
    counts = collections.Counter(one.outcome for one in found)
    agreeing = collections.Counter(by for one in found for by in one.by)
    readers = (*robot_readers.READERS, *mesh_readers.READERS)
    return (
        {"files": kind, "all": len(found)}
        | {name: counts[name] for name in ("read", "alone", "refused", "different")}
        | {name: agreeing[name] for name in readers if agreeing[name]}
    )


def main() -> None:
    """Print the table, and each file that is refused or different."""
    logging.getLogger("yourdfpy").setLevel(logging.ERROR)  # it warns of mimic joints at each state
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--robots", action="store_true", help="leave out the meshes")
    parser.add_argument("--states", type=int, default=_STATES, help="random states of each robot")
    options = parser.parse_args()
    found = []
    for folder in options.folders:
        for one in compare(folder, not options.robots, options.states):
            found.append(one)
            if one.outcome != "read" or "differ" in one.why:
                print(f"{one.outcome}: {one.file}: {one.why}", flush=True)
    print(table(rows_of(found)))


if __name__ == "__main__":
    main()
