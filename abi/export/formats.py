"""Table of the formats in which a plan can be exported.

A new format is a file beside this one and a row here. Its ``write(plan, name)`` returns the file's
content, or raises :class:`abi.errors.AbiError` if the format cannot hold the plan.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from abi.atomic_file import replace_file
from abi.errors import AbiError
from abi.explain.arm_faults import arm_warning, limits_warning
from abi.export import (
    csv_table,
    html_page,
    mcap_recording,
    moveit_scene,
    plan_file,
    robot_description,
    ros_bag,
    ros_trajectory,
    spline_curves,
    urscript,
)
from abi.export.between_points import growth_warning
from abi.planner.plan import Plan, require_plan
from abi.planner.task_plan import TaskPlan


@dataclass(frozen=True)
class Format:
    """A file format.

    Attributes:
        label: what it holds, for a person.
        file: name that a download gets.
        write: content of the file of a plan, given the file's name.
        endings: those of file names that mean this format; none if it is that of ``file``.
        holds_motion: whether a motion of the arm is in it.
        has_rates: whether it has velocities and accelerations, of which controllers make
            polynomials.
    """

    label: str
    file: str
    write: Callable[[Plan, str], bytes]
    endings: tuple[str, ...] = ()
    holds_motion: bool = True
    has_rates: bool = False

    def warning(self, plan: Plan) -> str:
        """Sentence on what the exported motion's arm touches or lacks; empty for none."""
        return arm_warning(plan) if self.holds_motion else ""

    def limits_warning(self, plan: Plan) -> str:
        """Sentence on a limit of the joints that the exported motion passes; empty for none."""
        past = limits_warning(plan) if self.holds_motion else ""
        return past or (growth_warning(plan) if self.has_rates else "")


FORMATS: dict[str, Format] = {
    "csv": Format("motion as a table (CSV)", "motion.csv", csv_table.write),
    "json": Format("whole plan (JSON)", "plan.json", plan_file.write),
    "ros": Format(
        "motion for ROS 2 (JointTrajectory)",
        "trajectory.ros.yaml",
        ros_trajectory.write,
        (".yaml", ".yml"),
        has_rates=True,
    ),
    "ros-json": Format(
        "motion for ROS 2 (the same in JSON)",
        "trajectory.ros.json",
        ros_trajectory.write,
        has_rates=True,
    ),
    "spline": Format(
        "curves as B-splines (JSON)", "curves.spline.json", spline_curves.write, holds_motion=False
    ),
    "moveit": Format(
        "obstacles for MoveIt", "obstacles.scene", moveit_scene.write, holds_motion=False
    ),
    "mcap": Format("recording for Foxglove (MCAP)", "motion.mcap", mcap_recording.write),
    "html": Format("page that plays by itself (HTML)", "plan.html", html_page.write),
    "urscript": Format("program for a UR (URScript)", "motion.script", urscript.write),
    "urdf": Format("arm (URDF)", "arm.urdf", robot_description.write, holds_motion=False),
    "urdf-zip": Format(
        "arm with its meshes (zip)", "arm.zip", robot_description.write_archive, holds_motion=False
    ),
    "rosbag": Format(
        "recording for ROS 2 (bag)", "motion.ros2.mcap", ros_bag.write, has_rates=True
    ),
}
"""Formats by the names that ``abi export --format`` takes."""


def format_of(path: Path) -> str:
    """Name of the format for a file's ending; the longest matching ending counts.

    Raises:
        AbiError: no format has this ending.
    """
    endings = {
        ending: name
        for name, row in FORMATS.items()
        for ending in row.endings or ("".join(Path(row.file).suffixes),)
    }
    fitting = [ending for ending in endings if path.name.lower().endswith(ending)]
    if not fitting:
        known = ", ".join(endings)
        raise AbiError(
            f"The ending of {path.name!r} means no format; expected one of {known}.",
            f"Or name a format: {', '.join(FORMATS)}.",
        )
    return endings[max(fitting, key=len)]


def export(
    plan: Plan | TaskPlan,
    path: str | Path,
    format: str | None = None,
    *,
    allow_unproven: bool = False,
) -> None:
    """Write a plan to a file, whole or not at all.

    Args:
        plan: the plan; of one of tasks the file has the motions of all legs.
        path: file to write; an existing file is replaced.
        format: a name in :data:`FORMATS`; None for what the file's ending means.
        allow_unproven: whether to write the motion of a plan that has an error, as one that
            collides has.

    Raises:
        AbiError: there is no such format, it cannot hold the plan, the plan has an error and its
            motion was not asked for all the same, or the file cannot be written.
    """
    tasks = plan if isinstance(plan, TaskPlan) else None
    plan = plan.joined if isinstance(plan, TaskPlan) else plan
    require_plan(plan)
    if not isinstance(path, str | os.PathLike):
        raise AbiError(f"path is {path!r}; expected the file to write, such as 'motion.csv'.")
    path = Path(path)
    if format is None:
        format = format_of(path)
    if format not in tuple(FORMATS):
        known = ", ".join(FORMATS)
        raise AbiError(f"The format is {format!r}; expected one of {known}.")
    row = FORMATS[format]
    moves = plan.motion is not None and row.holds_motion
    if plan.error is not None and moves and not allow_unproven:
        raise AbiError(
            f"The plan has an error: {plan.error.message}",
            "Pass allow_unproven=True to write its motion all the same.",
        )
    if tasks is not None and row.write is plan_file.write:
        content = plan_file.write_tasks(tasks)
    else:
        content = row.write(plan, path.name)
    try:
        replace_file(path, content)
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or "not writable").lower()
        raise AbiError(f"{str(path)!r} cannot be written ({reason}).") from None
