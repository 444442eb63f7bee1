"""``abi certify``: the verdict on a motion that anybody planned."""

from __future__ import annotations

import json
from pathlib import Path

import click

from app.cli.exit_code import INCOMPLETE, UNDECIDED
from app.cli.given_scene import STANDARD, given_scene
from app.cli.output import print_text, write_text


@click.command(short_help="Prove that a motion from elsewhere keeps a robot clear.")
@click.argument("motion", type=click.Path(path_type=Path))
@click.option("--robot", help="A .urdf or .zip file, or ur5e, panda or xarm7.")
@click.option("--scene", help="A scene with the obstacles.  [default: the robot alone]")
@click.option("--clearance", type=float, default=0.0, help="Distance to keep from obstacles.")
@click.option("--start", help="State in which the robot stands: NAME=VALUE,NAME=VALUE.")
@click.option("--acceleration", type=float, help="Limit of each joint, rad/s² or m/s².")
@click.option("--topic", help="Of a trajectory in a bag: TOPIC, or TOPIC:NUMBER.")
@click.option("--budget", type=click.IntRange(1_000), help="Pairs to try at most.")
@click.option(
    "--out", type=click.Path(dir_okay=False, path_type=Path), help="Write JSON to a file."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of sentences.")
def certify(
    motion: Path,
    robot: str | None,
    scene: str | None,
    clearance: float,
    start: str | None,
    acceleration: float | None,
    topic: str | None,
    budget: int | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Prove that the motion in a file keeps a robot clear at all times, or find where it touches.

    MOTION is a ROS 2 JointTrajectory (YAML, JSON, or in a bag, .mcap or .db3), a CSV with the
    joints' names in its first row, a plan of abi plan, or JSON with joints, times and positions.

    Exit code 0: proven clear; 3: it touches something; 4: not decided; 2: bad input.
    """
    from abi.certification.certify_motion import certify_motion
    from abi.certification.clearance_proof import MOST_TRIES
    from abi.certification.read_motion import load_motion
    from abi.certification.robot_scene import robot_scene
    from abi.certification.verdict_words import remarks

    place = robot_scene(robot, None if scene is None else given_scene(scene))
    verdict = certify_motion(
        load_motion(motion, place.arm.robot, topic),
        place,
        None if start is None else _state(start),
        clearance,
        acceleration,
        budget or MOST_TRIES,
    )
    text = json.dumps(verdict.to_dict(), allow_nan=False) if out or as_json else ""
    if out is not None and str(out) != STANDARD:
        write_text(out, text)
    print_text(
        text
        if as_json or str(out) == STANDARD
        else "\n".join([verdict.sentence, *remarks(verdict), *place.file_notes])
    )
    if verdict.state != "clear":
        raise SystemExit(INCOMPLETE if verdict.state == "touches" else UNDECIDED)


def _state(text: str) -> dict[str, float]:
    """Parse the positions of joints by name."""
    state = dict[str, float]()
    for part in text.split(","):
        name, sign, value = part.partition("=")
        if name.strip() in state:
            raise click.UsageError(f"--start: {name.strip()} is given twice.")
        try:
            state[name.strip()] = float(value.replace("_", "?"))  # 1_0 would be 10
        except ValueError:
            sign = ""
        if not sign:
            raise click.UsageError(f"--start: {part.strip()!r} is not NAME=VALUE, as elbow=1.57.")
    return state
