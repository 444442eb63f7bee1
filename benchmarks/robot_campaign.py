"""Random robots in random files: each is read, and is where and what its writer knows it to be.

    python -m benchmarks.robot_campaign --files 2000

The robots have joints that follow others, directly and not, in files as authors and programs write
them: odd numbers, units, encodings, ROS packages, and archives of file managers. Every link's pose
at random states, and the corners of every link's surface, are compared with the writer's. The run
fails at the first file that is refused, displaced or smaller.
"""

from __future__ import annotations

import argparse

import numpy as np

from abi.arrays import FloatArray
from abi.obstacles.triangle_mesh.mesh_source import MeshSource
from abi.robot.bodies.chain_capsules import segment_distances
from abi.robot.bodies.finer_links import fitted_capsules
from abi.robot.kinematics.chain import Chain
from abi.robot.urdf.held_joints import planned_joints
from abi.robot.urdf.robot import Robot
from abi.robot.urdf.robot_files import load_robot
from benchmarks.report import Row, table
from tests.random_archives import CORNERS, RobotFile, random_file
from tests.random_robots import link_poses

_STATES, _CAPSULES_EVERY = 2, 10
_NEAR, _NEAR_MESH = 1e-9, 1e-7
"""Largest difference of a pose, and of a surface whose mesh is in single precision, [m]."""


def check(file: RobotFile, random: np.random.Generator, capsules: bool = True) -> Row:
    """Counts of what was compared in one file, with ``capsules`` those around the links, too.

    Raises:
        SceneError: it is refused.
        AssertionError: a link is elsewhere or another than its writer knows.
    """
    robot = load_robot(file.name, MeshSource({file.name: file.content}))
    moved = [joint.child for joint in robot.joints if joint.kind != "fixed"]
    tip = str(random.choice(moved))
    chain = _chain(robot, tip, random)
    for _ in range(_STATES):
        low, high = chain.limits.T
        q = random.uniform(low, high)
        state = {**chain.held, **dict(zip(chain.names, q.tolist(), strict=True))}
        frames = chain.poses(q[None])[0]
        truth = link_poses(file.robot, state)
        assert chain.frames.keys() == truth.keys()
        for link, frame in chain.frames.items():
            pose = _in_world(frames, frame) @ chain.places[link]
            gap = float(np.abs(pose - truth[link]).max())
            assert gap < _NEAR * (1 + chain.table.reach), (file.name, link, gap)
            surface = _corners(robot, link) @ pose[:3, :3].T + pose[:3, 3]
            wanted = CORNERS @ truth[link][:3, :3].T + truth[link][:3, 3]
            away = np.linalg.norm(surface[:, None] - wanted[None], axis=2)
            assert away.min(axis=0).max() < _NEAR_MESH, (file.name, link)
            assert away.min(axis=1).max() < _NEAR_MESH, (file.name, link)
            if capsules:
                assert _is_held(chain, frames, link, wanted), (file.name, link)
    followers = sum(joint.follows is not None for joint in robot.joints)
    return {
        "files": 1,
        "links": len(robot.links),
        "followers": followers,
        "notes": len(robot.notes),
    }


def _chain(robot: Robot, tip: str, random: np.random.Generator) -> Chain:
    """The chain to a tip, with some of the other joints held anywhere."""
    planned = planned_joints(robot, tip)
    held = {
        joint.name: float(random.uniform(joint.low, joint.high))
        for joint in robot.joints
        if joint.kind != "fixed" and joint.follows is None and joint.name not in planned
        if random.random() < 0.6
    }
    return Chain.of(robot, tip, held=held)


def _in_world(frames: FloatArray, frame: int) -> FloatArray:
    return np.vstack([frames[frame], [0, 0, 0, 1]]) if frame >= 0 else np.eye(4)


def _corners(robot: Robot, link: str) -> FloatArray:
    """Corners (n, 3) of a link's shape in its frame."""
    (shape,) = robot.links[link].shapes
    own = shape.vertices
    if shape.kind == "box":
        signs = np.sign(CORNERS - np.array([0, 0, 0.1]))
        own = signs * np.array(shape.size) / 2
    return np.asarray(own @ shape.pose[:3, :3].T + shape.pose[:3, 3])


def _is_held(chain: Chain, frames: FloatArray, link: str, corners: FloatArray) -> bool:
    """Check whether the capsules of a link hold its corners in the world."""
    held = np.zeros(len(corners), dtype=bool)
    for capsule in fitted_capsules(chain):
        if capsule.link == link:
            world = _in_world(frames, capsule.frame)
            ends = capsule.ends @ world[:3, :3].T + world[:3, 3]
            pairs = np.broadcast_to(ends, (len(corners), 2, 3)), np.stack([corners, corners], 1)
            held |= segment_distances(*pairs) <= capsule.radius + _NEAR_MESH
    return bool(held.all())


def measure(files: int, seed: int = 0) -> Row:
    """Counts over random files."""
    total: Row = {}
    for number in range(files):
        random = np.random.default_rng([seed, number])
        row = check(random_file(random), random, number % _CAPSULES_EVERY == 0)
        for name, count in row.items():
            total[name] = total.get(name, 0) + count
    return total


def main() -> None:
    """Print the counts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--files", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print(table([measure(options.files, options.seed)]))


if __name__ == "__main__":
    main()
