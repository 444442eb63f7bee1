"""Motions of shipped scenes, followed in PyBullet: how far the tool is off, and what is touched.

    pip install pybullet
    python -m benchmarks.in_pybullet kitchen-ur5e wall-with-window

PyBullet reads the exported URDF with its meshes, and the scene's solids. Torques are those of its
own inverse dynamics for the planned acceleration, with a correction of what is off. ``error`` is
the farthest that the tool is from where the plan has it at that time, [mm]; ``links`` are those
that touch an obstacle on the way, and ``told`` those of which the plan says so, as of an arm that
avoids nothing (``wall-with-window``): what it touches holds it back.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pybullet
import scipy

from abi.arrays import FloatArray
from abi.export.solids import Solid, solids
from abi.planner.plan import Plan
from abi.planner.planner import plan as plan_scene
from abi.scene.scene import load_scene
from benchmarks.report import Row, table

_STEP = 1e-3
_STIFFNESS, _DAMPING = 900.0, 60.0


def follow(plan: Plan) -> Row:
    """Row of a plan's motion."""
    assert plan.motion is not None
    assert plan.arm is not None
    pybullet.connect(pybullet.DIRECT)
    try:
        return {"scene": "", "seconds": float(plan.motion.time[-1])} | _followed(plan)
    finally:
        pybullet.disconnect()


def _followed(plan: Plan) -> Row:
    motion, arm = plan.motion, plan.arm
    assert motion is not None
    assert arm is not None
    chain = arm.chain
    robot = _robot(plan)
    scene = plan.scene
    others = [_body(one) for parts in solids(scene.obstacles, scene.unit) for one in parts]
    numbers = range(pybullet.getNumJoints(robot))
    told = [pybullet.getJointInfo(robot, k) for k in numbers]
    names = {one[1].decode(): k for k, one in enumerate(told)}
    links = [one[12].decode() for one in told]
    free = [k for k, one in enumerate(told) if one[3] >= 0]
    at = {name: free.index(names[name]) for name in motion.joints}
    metre = np.where(np.array(motion.slides), arm.metres, 1.0)
    spline = scipy.interpolate.CubicSpline(motion.time, motion.positions * metre, bc_type="clamped")
    columns = [at[name] for name in motion.joints]
    for k in free:
        pybullet.setJointMotorControl2(robot, k, pybullet.VELOCITY_CONTROL, force=0)
        pybullet.changeDynamics(robot, k, linearDamping=0, angularDamping=0, jointDamping=0)
    for name, at_first in zip(motion.joints, spline(0.0).tolist(), strict=True):
        pybullet.resetJointState(robot, names[name], at_first)
    tip, error, touched = _tip(links, plan), 0.0, set()
    for step in range(int(motion.time[-1] / _STEP)):
        time = step * _STEP
        states = [pybullet.getJointState(robot, k)[:2] for k in free]
        place, speed = (np.array(part) for part in zip(*states, strict=True))
        growth = -_DAMPING * speed  # of joints that are held
        growth[columns] = (
            spline(time, 2)
            + _STIFFNESS * (spline(time) - place[columns])
            + _DAMPING * (spline(time, 1) - speed[columns])
        )
        torques = pybullet.calculateInverseDynamics(
            robot, place.tolist(), speed.tolist(), growth.tolist()
        )
        pybullet.setJointMotorControlArray(
            robot, free, pybullet.TORQUE_CONTROL, forces=list(torques)
        )
        pybullet.stepSimulation()
        here = _place_of(robot, tip)
        wanted = chain.poses(spline(time + _STEP)[None])[0, -1, :, 3]
        error = max(error, float(np.linalg.norm(here - wanted)))
        for other in others:
            contacts = pybullet.getContactPoints(robot, other)
            touched |= {links[one[3]] for one in contacts if one[3] >= 0 and one[8] <= 0}
    clearance = plan.arm_clearance
    told_of = set() if clearance is None else {one.link for one in clearance.contacts}
    names_of = (", ".join(sorted(names)) or "none" for names in (touched, told_of))
    return {"error": 1e3 * error, **dict(zip(("links", "told"), names_of, strict=True))}


def _robot(plan: Plan) -> int:
    """The arm, standing where it does, with gravity and the step of time set."""
    arm = plan.arm
    assert arm is not None
    pybullet.setGravity(0, 0, -9.81)
    pybullet.setTimeStep(_STEP)
    with tempfile.TemporaryDirectory() as folder:
        for name, content in arm.files().items():
            file = Path(folder, name)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        (urdf,) = Path(folder).rglob("*.urdf")
        w, x, y, z = arm.wxyz
        robot = pybullet.loadURDF(
            str(urdf),
            (arm.base * arm.metres).tolist(),
            (x, y, z, w),
            useFixedBase=True,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
        )
    return int(robot)


def _body(solid: Solid) -> int:
    """A solid that stands still."""
    size = np.array(solid.size)
    if solid.kind == "box":
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=(size / 2).tolist())
    elif solid.kind == "sphere":
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=float(size[0]) / 2)
    elif solid.kind == "cylinder":
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=float(size[0]) / 2, height=float(size[2])
        )
    else:
        corners = solid.triangles.reshape(-1, 3)
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=corners.tolist(),
            indices=list(range(len(corners))),
            flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
        )
    w, x, y, z = solid.wxyz
    return int(pybullet.createMultiBody(0, shape, -1, solid.position, (x, y, z, w)))


def _tip(links: list[str], plan: Plan) -> int:
    """Number of the link whose origin is the tool."""
    assert plan.arm is not None
    chain = plan.arm.chain
    last = chain.table.origins.reshape(-1, 12)[-1]
    for link, frame in chain.frames.items():
        if frame == chain.table.length - 1 and np.allclose(chain.places[link][:3, 3], last[9:]):
            return links.index(link)
    raise ValueError("no link is at the tool")


def _place_of(robot: int, link: int) -> FloatArray:
    """Origin of a link in the world, (3,), [m]."""
    return np.array(pybullet.getLinkState(robot, link, computeForwardKinematics=True)[4])


def main() -> None:
    """Print a row for each scene."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenes", nargs="+")
    rows = []
    for name in parser.parse_args().scenes:
        plan = plan_scene(load_scene(name))
        if plan.error is not None:
            raise SystemExit(f"{name}: {plan.error.message}")
        rows.append(follow(plan) | {"scene": name})
    print(table(rows))


if __name__ == "__main__":
    main()
