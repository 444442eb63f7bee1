"""What the legs of a sequence of tasks must be, so that an arm can go through them in order."""

from collections.abc import Sequence

from abi.errors import MISSING, SceneError
from abi.obstacles.obstacle_set import Obstacle
from abi.obstacles.pose import METRES
from abi.robot.attached_object import require_solid
from abi.scene.arm_settings import ON_MESH, ArmSettings
from abi.scene.held_axis import check_axis
from abi.scene.leg import Leg
from abi.scene.settings import Workspace


def check_tasks(
    tasks: Sequence[Leg],
    arm: ArmSettings,
    obstacles: Sequence[Obstacle],
    workspace: Workspace,
    unit: str,
) -> None:
    """Raise a SceneError if legs attach or release what they cannot, or lead elsewhere.

    Args:
        tasks: the legs.
        arm: that goes through them.
        obstacles: of the scene.
        workspace: of the scene.
        unit: of its lengths.
    """
    if arm.model != "urdf" and (tasks or arm.attached is not None):
        expected = "urdf where there are tasks, or an object is attached"
        raise SceneError("arm.model", arm.model, expected)
    if arm.search == "mesh" and len(tasks) > 1:
        raise SceneError("arm.search", "mesh", ON_MESH)
    holds, gripper = arm.attached is not None, dict(arm.gripper)
    for number, leg in enumerate(tasks):
        field = f"tasks[{number}]"
        check_axis(f"{field}.axis", leg.axis, arm.model, arm.search)
        if number > 0 and leg.goal is None:
            raise SceneError(f"{field}.goal", MISSING, "a waypoint")
        if leg.attach is not None and leg.attach >= len(obstacles):
            expected = f"the number of an obstacle, below {len(obstacles)}"
            raise SceneError(f"{field}.attach", leg.attach, expected)
        if leg.attach is not None:
            require_solid(f"{field}.attach", obstacles[leg.attach])
        if leg.attach is not None and (holds or leg.release):
            expected = "none before what is held is released, on an earlier leg"
            raise SceneError(f"{field}.attach", leg.attach, expected)
        if leg.release and not holds:
            raise SceneError(f"{field}.release", True, "false where nothing is held")
        holds = leg.attach is not None or (holds and not leg.release)
        if number > 0:
            gripper |= leg.gripper or {}
            held = arm.model_copy(update={"gripper": gripper})
            _check_later_leg(field, leg, held, workspace, unit)


def _check_later_leg(
    field: str, leg: Leg, arm: ArmSettings, workspace: Workspace, unit: str
) -> None:
    """Raise a SceneError if a leg's arm has no such gripper or goal, or the goal is outside."""
    metres = METRES[unit]
    try:
        there = arm.model_copy(update={"goal": leg.goal})
        place = leg.goal if isinstance(leg.goal, tuple) else there.tool_at("goal", metres)
        goal = None if isinstance(leg.goal, tuple) else leg.goal
        arm.model_copy(update={"start": None, "goal": goal}).check_gripper(metres)
    except SceneError as error:
        name = error.field.replace("arm", field, 1)
        raise SceneError(name, error.value, error.expected) from None
    assert place is not None
    if bounds := workspace.left_bounds(place, unit):
        raise SceneError(f"{field}.goal", place, f"the tool tip in the workspace, {bounds}")
