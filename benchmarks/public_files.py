"""Robots and meshes of public packages, as they are read here and by independent readers.

    python -m benchmarks.public_files FOLDER…

Each folder holds the files of packages, unpacked; nothing of them comes with this repository:

    pip download --no-deps --only-binary :all: -d wheels example-robot-data rtb-data
    pip download --no-deps --only-binary :all: -d wheels --python-version 3.9 pybullet
    for wheel in wheels/*.whl; do unzip -q $wheel -d FOLDER/$(basename $wheel); done

Of each URDF all links' poses are compared at random states with those of yourdfpy, and where a file
has what this does not know (a joint that follows a follower, an axis of another length) with the
file's own numbers, multiplied out. Of each mesh the number of triangles, the bounds and the volume
are compared with trimesh's. The tables count what was read, refused or found different; refusals
and differences are printed with their sentences.
"""

from __future__ import annotations

import argparse
import collections
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path, PurePosixPath
from typing import NamedTuple

import numpy as np
import trimesh
import yourdfpy

from abi.arm.chain import Chain
from abi.arrays import FloatArray
from abi.errors import SceneError
from abi.obstacles.triangle_mesh import mesh_reader
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.mesh_lookup import MeshLookup
from abi.robot.robot import MOST_JOINTS, Robot
from abi.robot.robot_files import archive_of, unpacked
from abi.robot.urdf_reader import read_urdf
from benchmarks.report import Row, table
from tests.random_robots import link_poses, robot_of

_STATES = 3
_NEAR = 1e-9
"""Difference of a pose that counts as none, over the largest coordinate and 1 m."""
_NEAR_MESH = 1e-6
"""The same of the bounds and the volume of a mesh, over its size."""
_SEVERAL = "random_urdfs"
"""Folder of pybullet with a thousand solids, one a URDF: counted by themselves."""

Poses = Mapping[str, FloatArray]
"""Pose of every link in the root, (4, 4)."""


Reader = Callable[[Mapping[str, float]], Poses]
"""Poses at positions of the joints that move by themselves."""


class Outcome(NamedTuple):
    """What came of a file: ``read`` as which reader reads it, ``refused`` or ``different``."""

    file: str
    kind: str
    outcome: str
    why: str


def read_robot(file: Path, folder: Path) -> Robot:
    """The robot of a URDF in its package, as a scene in ``folder`` would have it.

    Raises:
        SceneError: it is refused.
    """
    files = unpacked(archive_of(file.relative_to(folder).as_posix(), MeshSource(folder=folder)))
    (path,) = (one for one in files if one.lower().endswith(".urdf"))
    return read_urdf(files[path], file.name, MeshLookup(files, PurePosixPath(path).parent))


def compare_robot(file: Path, folder: Path) -> Outcome:
    """Read a URDF, and compare the poses of its links with those of other readers."""
    kind = "solids of pybullet" if _SEVERAL in file.parts else "robots"
    name = file.relative_to(folder).as_posix()
    try:
        robot = read_robot(file, folder)
    except SceneError as error:
        return Outcome(name, kind, "refused", error.message)
    told = ""
    for by, opened in (("yourdfpy", _by_yourdfpy), ("the file's numbers", _by_numbers)):
        try:
            other = opened(file)
            gap = _largest_gap(robot, other)
        except Exception as error:  # whatever another library raises
            told += f" {by}: {type(error).__name__}."
            continue
        if gap <= _NEAR:
            return Outcome(name, kind, "read", by)
        told += f" {by}: poses differ by {gap:.2g}."
    return Outcome(name, kind, "different", told.strip())


def _largest_gap(robot: Robot, other: Reader) -> float:
    """Largest difference of any link's pose at random states, over the largest coordinate."""
    random, worst = np.random.default_rng(len(robot.links)), 0.0
    free = [one for one in robot.joints if one.kind != "fixed" and one.mimic is None]
    for _ in range(_STATES):
        state = {one.name: float(random.uniform(one.low, one.high)) for one in free}
        ours, theirs = poses_of(robot, state), other(state)
        size = max(1.0, *(float(np.abs(pose).max()) for pose in ours.values()))
        gaps = (float(np.abs(pose - theirs[link]).max()) for link, pose in ours.items())
        worst = max(worst, max(gaps) / size)
    return worst


def poses_of(robot: Robot, state: Mapping[str, float]) -> Poses:
    """Poses of all links, as planning has them, at positions of the joints."""
    count = {robot.root: 0}
    for joint in robot.joints:
        count[joint.child] = count[joint.parent] + (joint.kind != "fixed")
    tips = [link for link, moving in count.items() if 1 <= moving <= MOST_JOINTS]
    if not tips:
        found = {robot.root: np.eye(4)}
        for joint in robot.joints:
            found[joint.child] = found[joint.parent] @ joint.origin
        return found
    planned = Chain.of(robot, tips[-1]).names
    held = {name: at for name, at in state.items() if name not in planned}
    chain = Chain.of(robot, tips[-1], held=held)
    frames = chain.poses(np.array([[state[name] for name in chain.names]]))[0]
    found = {}
    for one in chain.carried:
        frame = np.vstack([frames[one.frame], [0, 0, 0, 1]]) if one.frame >= 0 else np.eye(4)
        found[one.link] = frame @ one.pose
    return found


def _by_yourdfpy(file: Path) -> Reader:
    robot = yourdfpy.URDF.load(str(file), load_meshes=False, build_collision_scene_graph=False)
    return partial(_poses_by, robot)


def _poses_by(robot: yourdfpy.URDF, state: Mapping[str, float]) -> Poses:
    robot.update_cfg({name: state.get(name, 0.0) for name in robot.actuated_joint_names})
    return {link: robot.get_transform(link) for link in robot.link_map}


def _by_numbers(file: Path) -> Reader:
    return partial(link_poses, robot_of(file.read_bytes()))


def compare_mesh(file: Path, folder: Path) -> Outcome:
    """Read a mesh, and compare its triangles with trimesh's."""
    name, kind = file.relative_to(folder).as_posix(), f"meshes {file.suffix.lower()}"
    try:
        vertices, faces = mesh_reader.read(file.read_bytes(), file.name)
    except SceneError as error:
        return Outcome(name, kind, "refused", error.message)
    try:
        other = trimesh.load_mesh(str(file), process=False)
    except Exception as error:  # whatever another library raises
        return Outcome(name, kind, "read", f"alone: trimesh raises {type(error).__name__}")
    if other.bounds is None:
        return Outcome(name, kind, "read", "alone: trimesh reads nothing")
    ours = trimesh.Trimesh(vertices, faces, process=False)
    size = float(np.ptp(ours.bounds, axis=0).max())
    told = [
        f"{len(ours.faces)} triangles, trimesh {len(other.faces)}"
        if len(ours.faces) != len(other.faces)
        else "",
        "bounds" if np.abs(ours.bounds - other.bounds).max() > _NEAR_MESH * size else "",
        "volume" if abs(ours.volume - other.volume) > _NEAR_MESH * size**3 else "",
    ]
    if any(told):
        return Outcome(name, kind, "different", ", ".join(filter(None, told)))
    return Outcome(name, kind, "read", "trimesh")


def compare(folder: Path, meshes: bool = True) -> Iterator[Outcome]:
    """Outcome of each file below a folder, in the order of their names."""
    for file in sorted(folder.rglob("*")):
        if file.suffix.lower() == ".urdf":
            yield compare_robot(file, folder)
        elif meshes and file.suffix.lower() in mesh_reader.SUFFIXES:
            yield compare_mesh(file, folder)


def rows_of(outcomes: Iterable[Outcome]) -> list[Row]:
    """A row for each kind of file: how many were read, refused, or are different."""
    counts: dict[str, collections.Counter[str]] = {}
    for one in outcomes:
        counts.setdefault(one.kind, collections.Counter())[one.outcome] += 1
    return [
        {"files": kind, "all": sum(found.values())}
        | {name: found[name] for name in ("read", "refused", "different")}
        for kind, found in sorted(counts.items())
    ]


def main() -> None:
    """Print the table, and each file that is refused or different."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--robots", action="store_true", help="leave out the meshes")
    options = parser.parse_args()
    found = [one for folder in options.folders for one in compare(folder, not options.robots)]
    for one in found:
        if one.outcome != "read":
            print(f"{one.outcome}: {one.file}: {one.why}")
    print(table(rows_of(found)))
    agreeing = collections.Counter(one.why for one in found if one.outcome == "read")
    print(table([{"read as by": by, "files": count} for by, count in agreeing.items()]))


if __name__ == "__main__":
    main()
