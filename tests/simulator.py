"""A plan of tasks, followed in MuJoCo by a controller that knows the arm's masses."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
import scipy

from abi.arm_planning.motion.trajectory import ArmMotion
from abi.arrays import FloatArray
from abi.obstacles.primitives import Box
from abi.planner.task_plan import TaskPlan
from abi.robot.urdf_arm import UrdfArm

STEP, PAUSE = 0.001, 0.3
"""Time of a step of the simulation, and between two legs, in which the gripper moves, [s]."""
_STIFFNESS, _DAMPING = 900.0, 60.0
_MASS = 0.1
"""Mass of the block, [kg]."""
_LAST = "panda_link7"
"""The last body that moves, to which the hand is fixed."""
_WELD = -1
"""Number of the weld among what holds bodies together; one finger follows the other by another."""


class Followed(NamedTuple):
    """What happened while a plan was followed.

    Attributes:
        error: farthest that the tool was from where the plan has it at that time, [m].
        contacts: number of the leg, and names of two bodies that touched each other.
        block: where the block came to rest, (3,), [m].
    """

    error: float
    contacts: frozenset[tuple[int, str, str]]
    block: FloatArray


def follow(plan: TaskPlan, fingers: tuple[str, ...]) -> Followed:
    """Follow a plan of the Panda, in metres, in which one box is attached and released.

    Args:
        plan: the plan.
        fingers: joints of the gripper, all held alike.
    """
    arm, whole = plan.legs[0].arm, plan.trajectory
    assert isinstance(arm, UrdfArm)
    assert whole is not None
    model = _model(plan, arm)
    data = mujoco.MjData(model)
    data.qpos[: len(arm.joints)] = whole.positions[0]
    for name in fingers:
        data.joint(name).qpos = _opening(plan, 0)
    mujoco.mj_forward(model, data)
    simulation = _Simulation(plan, arm, model, data, whole, fingers)
    error = 0.0
    contacts: set[tuple[int, str, str]] = set()
    for number in range(len(plan.legs)):
        simulation.grip(number)
        error = max(error, simulation.move(number, contacts))
    simulation.grip(len(plan.legs))
    return Followed(error, frozenset(contacts), data.body("block").xpos.copy())


class _Simulation:
    def __init__(
        self,
        plan: TaskPlan,
        arm: UrdfArm,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        whole: ArmMotion,
        fingers: tuple[str, ...],
    ) -> None:
        self._plan, self._arm, self._model, self._data = plan, arm, model, data
        self._whole = whole
        self._count = len(arm.joints)
        self._fingers = [int(model.joint(name).dofadr[0]) for name in fingers]
        self._driven = [*range(self._count), *self._fingers]
        self._last = _LAST
        body = data.body(self._last)
        self._offset = body.xmat.reshape(3, 3).T @ (arm.tool(whole.positions[:1])[0] - body.xpos)

    def move(self, number: int, contacts: set[tuple[int, str, str]]) -> float:
        """Follow a leg; the largest error of the tool."""
        motion = self._plan.legs[number].motion
        assert motion is not None
        spline = scipy.interpolate.CubicSpline(motion.time, motion.positions, bc_type="clamped")
        times = STEP * np.arange(round(motion.time[-1] / STEP) + 1)
        states = [spline(times[:-1], order) for order in range(3)]
        opening, body, followed = _opening(self._plan, number), self._data.body(self._last), []
        for place, speed, growth in zip(*states, strict=True):
            self._step(place, speed, growth, opening)
            followed.append(body.xpos + body.xmat.reshape(3, 3) @ self._offset)
            for geoms in self._data.contact.geom.tolist():
                first, second = sorted(
                    self._model.body(self._model.geom_bodyid[geom]).name for geom in geoms
                )
                contacts.add((number, first, second))
        wanted = self._arm.tool(spline(times[1:]))
        return float(np.linalg.norm(np.array(followed) - wanted, axis=1).max())

    def grip(self, number: int) -> None:
        """Stand still while the gripper moves to where it is held on a leg, and takes or leaves."""
        still = np.zeros(self._count)
        before = self._plan.scene.tasks[number - 1] if number > 0 else None
        if before is not None and before.attach is not None:
            self._weld()
        if before is not None and before.release:
            self._data.eq_active[_WELD] = 0
        ends = [
            _opening(self._plan, min(max(k, 0), len(self._plan.legs) - 1))
            for k in (number - 1, number)
        ]
        place = self._whole.positions[
            int(np.abs(self._whole.time - self._plan.begins[number]).argmin())
        ]
        for k in range(round(PAUSE / STEP)):
            share = min(2 * k * STEP / PAUSE, 1.0)
            opening = ends[0] + share * (ends[1] - ends[0])
            self._step(place, still, still, opening)

    def _weld(self) -> None:
        """Fix the block to the last link, as it lies in the gripper now."""
        link, block = self._data.body(self._last), self._data.body("block")
        turn = link.xmat.reshape(3, 3)
        inverse, between = np.zeros(4), np.zeros(4)
        mujoco.mju_negQuat(inverse, link.xquat)
        mujoco.mju_mulQuat(between, inverse, block.xquat)
        self._model.eq_data[_WELD, :3] = 0.0
        self._model.eq_data[_WELD, 3:6] = turn.T @ (block.xpos - link.xpos)
        self._model.eq_data[_WELD, 6:10] = between
        self._data.eq_active[_WELD] = 1

    def _step(
        self, place: FloatArray, speed: FloatArray, growth: FloatArray, opening: float
    ) -> None:
        """One step of the simulation with the torques that the wanted motion takes."""
        model, data, n = self._model, self._data, self._count
        wanted = np.zeros(model.nv)
        wanted[:n] = (
            growth + _STIFFNESS * (place - data.qpos[:n]) + _DAMPING * (speed - data.qvel[:n])
        )
        for dof in self._fingers:
            at = data.qpos[model.jnt_qposadr[model.dof_jntid[dof]]]
            wanted[dof] = _STIFFNESS * (opening - at) - _DAMPING * data.qvel[dof]
        torques = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, torques, wanted)
        torques += data.qfrc_bias - data.qfrc_passive
        if data.eq_active[_WELD]:  # it knows the load that it carries
            jacobian = np.zeros((3, model.nv))
            link, block = model.body(self._last).id, data.body("block")
            mujoco.mj_jac(model, data, jacobian, None, block.xpos, link)
            torques += jacobian.T @ (-_MASS * model.opt.gravity)
        data.qfrc_applied[self._driven] = torques[self._driven]
        mujoco.mj_step(model, data)


def _opening(plan: TaskPlan, number: int) -> float:
    """Position of the gripper's joints on a leg."""
    (opening,) = plan.legs[number].scene.arm.gripper.values()
    return opening


def _model(plan: TaskPlan, arm: UrdfArm) -> mujoco.MjModel:
    """Arm, obstacles and block, in metres."""
    files = {name: content for name, content in arm.files().items() if "visual" not in name}
    (urdf,) = (name for name in files if name.endswith(".urdf"))
    meshes = {name.split("/")[-1]: content for name, content in files.items() if name != urdf}
    spec = mujoco.MjSpec.from_string(files[urdf].decode(), assets=meshes)
    spec.option.timestep = STEP
    taken = next(task.attach for task in plan.scene.tasks if task.attach is not None)
    for number, shape in enumerate(plan.scene.obstacles):
        assert isinstance(shape, Box)
        where = {"pos": shape.position, "quat": shape.wxyz}
        size = [edge / 2 for edge in shape.size]
        if number == taken:
            block = spec.worldbody.add_body(name="block", **where)
            block.add_freejoint()
            block.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, mass=_MASS)
        else:
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, **where)
    weld = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY, name1=_LAST, name2="block"
    )
    weld.active = False
    weld.solref = [2 * STEP, 1.0]
    weld.solimp = [0.99, 0.999, 1e-4, 0.5, 2.0]
    bodies = {body.name for body in spec.bodies}
    for one in arm.allowed:
        pair = {one.link, str(one.other)}
        names = {
            _LAST if arm.chain.frames[name] == len(arm.joints) - 1 and name not in bodies else name
            for name in pair
        }
        if len(names) == 2 and names <= bodies:
            first, second = sorted(names)
            spec.add_exclude(bodyname1=first, bodyname2=second)
    return spec.compile()
