"""Verdicts on random motions: how many are proven, refuted or undecided, how fast, and if right.

``python -m benchmarks.certify`` moves Panda and xArm7 (7 joints) through 50 waypoints among 10
random obstacles. Of every proof, samples of the motion are compared with the distance proven. Then
a plate thinner than any step between samples is put where a link passes in every motion that was
clear: none of these may be called clear.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from abi.arrays import FloatArray
from abi.certification.certify_motion import certify_motion
from abi.certification.clearance_proof import nearest
from abi.certification.motion import Motion
from abi.certification.posed_hulls_kernels import nearest_obstacle
from abi.certification.read_motion import joint_names
from abi.certification.robot_scene import robot_scene
from abi.certification.separate_motion_kernels import separate_motion
from abi.certification.verdict import MotionVerdict
from abi.obstacles import obstacle_set_kernels
from abi.obstacles.triangle_mesh import surface_kernels
from abi.robot.kinematics.chain_kernels import chain_poses
from abi.robot.urdf.urdf_files import files_of
from abi.scene.scene import Scene

_ARMS = ("panda", "xarm7")
_WAYPOINTS, _OBSTACLES = 50, 10
_APART = 0.9
"""Distance of the bases of two arms, [m]."""
_PLATE = 1e-5
"""Thickness of the plate, [m]."""


def main() -> None:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--motions", type=int, default=60, help="how many")
    parser.add_argument("--samples", type=int, default=10_000)
    parser.add_argument("--two-arms", action="store_true", help="two UR5e in one URDF, 12 joints")
    chosen = parser.parse_args()
    compile_kernels()
    states: dict[str, list[float]] = {"clear": [], "touches": [], "undecided": []}
    refuted = missed = plates = 0
    place = _two_arms() if chosen.two_arms else None
    for seed in range(chosen.motions):
        motion, scene = random_motion(seed, place)
        if seed < len(_ARMS):
            certify_motion(motion, scene)  # reads the robot and finds its pairs
        begin = time.thread_time()
        verdict = certify_motion(motion, scene)
        states[verdict.state].append(1e3 * (time.thread_time() - begin))
        if verdict.state != "clear":
            continue
        samples = np.linspace(0, _WAYPOINTS - 1, chosen.samples)
        refuted += nearest(verdict.problem, samples)[0] < verdict.clearance
        plates += 1
        thin, _ = plate(verdict, seed)
        damaged = scene.replace(obstacles=[*scene.obstacles, thin])
        missed += certify_motion(motion, damaged).state == "clear"
    together = [one for times in states.values() for one in times]
    for state, times in {**states, "all": together}.items():
        if times:
            low, high = np.percentile(times, [50, 95])
            share = len(times) / chosen.motions
            print(f"{state:10} {share:6.1%}  median {low:6.0f} ms  95 % {high:6.0f} ms")
    print(f"proofs refuted by {chosen.samples:,} samples: {refuted} of {len(states['clear'])}")
    print(f"motions with a thin plate in the way called clear: {missed} of {plates}")


def compile_kernels() -> None:
    """Wait for the kernels of a verdict."""
    for kernel in (
        *(separate_motion, nearest_obstacle, surface_kernels.measure),
        obstacle_set_kernels.blocked_segments,
        *(obstacle_set_kernels.nearest, obstacle_set_kernels.near_boxes, chain_poses),
    ):
        kernel.compile()


def random_motion(seed: int, place: Scene | None = None) -> tuple[Motion, Scene]:
    """A smooth motion through waypoints, from one random pose to another by way of a third.

    Args:
        seed: of all that is random.
        place: a scene with the robot; None for one of the shipped arms.
    """
    random = np.random.default_rng(seed)
    scene = place or robot_scene(_ARMS[seed % len(_ARMS)])
    robot = scene.arm.robot
    names = [name for name in joint_names(robot) if "finger" not in name and "drive" not in name]
    limits = {joint.name: (joint.low, joint.high) for joint in robot.joints}
    low, high = np.clip(np.array([limits[name] for name in names]).T, -2.0, 2.0)
    first = random.uniform(low, high)
    second, third = (np.clip(first + random.normal(0, 0.5, len(first)), low, high) for _ in "ab")
    share = np.linspace(0, 1, _WAYPOINTS)[:, None]
    positions = (1 - share) ** 2 * first + 2 * share * (1 - share) * second + share**2 * third
    obstacles = [obstacle(random) for _ in range(_OBSTACLES)]
    return Motion(tuple(names), share[:, 0] * 5, positions), scene.replace(obstacles=obstacles)


def _two_arms() -> Scene:
    """Two UR5e beside each other, in one URDF."""
    (name, text), *meshes = files_of(robot_scene("ur5e").arm.robot).items()
    whole = etree.Element("robot", name="two")
    etree.SubElement(whole, "link", name="stand")
    for side, x in (("left_", -_APART / 2), ("right_", _APART / 2)):
        arm = etree.fromstring(text)
        root = robot_scene("ur5e").arm.robot.root
        for part in arm.iter("link", "joint", "parent", "child", "mimic"):
            for key in ("name", "link", "joint"):
                if key in part.attrib:
                    part.set(key, side + part.attrib[key])
        whole.extend(part for part in arm if part.tag in ("link", "joint"))
        joint = etree.SubElement(whole, "joint", name=f"{side}mount", type="fixed")
        etree.SubElement(joint, "origin", xyz=f"{x} 0 0")
        etree.SubElement(joint, "parent", link="stand")
        etree.SubElement(joint, "child", link=f"{side}{root}")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "two.zip"
        with zipfile.ZipFile(file, "w") as packed:
            packed.writestr(name, etree.tostring(whole))
            for path, content in meshes:
                packed.writestr(path, content)
        return robot_scene(file)


def plate(verdict: MotionVerdict, seed: int) -> tuple[dict[str, Any], float]:
    """A plate across the way of the last link, and the random parameter at which it is there."""
    random = np.random.default_rng(seed)
    at = random.uniform(0.1, len(verdict.problem.motion.points) - 0.1)
    problem = verdict.problem
    body = problem.bodies[-1]
    places = [_place(verdict, body.points[0], body.frame, t) for t in (at, at + 1e-3)]
    way = places[1] - places[0]
    axis = int(np.abs(way).argmax())
    size = [0.2, 0.2, 0.2]
    size[axis] = _PLATE
    return {"shape": "box", "size": size, "position": places[0].tolist()}, at


def _place(verdict: MotionVerdict, point: FloatArray, frame: int, at: float) -> FloatArray:
    """Place of a point of a body at a parameter, [m]."""
    positions = verdict.problem.motion.positions_at(np.array([at]))
    pose = verdict.problem.chain.poses(positions)[0, frame]
    return np.asarray(pose[:, :3] @ point + pose[:, 3])


def obstacle(random: np.random.Generator) -> dict[str, Any]:
    """A box or a ball around the robot, up to 1 m away."""
    way = random.normal(size=3)
    place = (way / np.linalg.norm(way) * random.uniform(0.45, 1.0)).tolist()
    if random.uniform() < 0.5:
        return {"shape": "sphere", "radius": float(random.uniform(0.02, 0.1)), "position": place}
    size, wxyz = random.uniform(0.02, 0.2, 3).tolist(), random.normal(size=4).tolist()
    return {"shape": "box", "size": size, "position": place, "wxyz": wxyz}


if __name__ == "__main__":
    main()
