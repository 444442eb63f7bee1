"""``abi plan``: a plan as JSON, without a browser."""

from __future__ import annotations

import json
from pathlib import Path

import click

from app.commands.exit_code import INCOMPLETE
from app.commands.output import print_text, write_text


@click.command()
@click.argument("scene", default="paper")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Write to a file.")
@click.option("--full", is_flag=True, help="Also the mesh's nodes and edges, and every sample.")
@click.option("--list", "list_scenes", is_flag=True, help="Name the shipped scenes and stop.")
def plan(scene: str, out: Path | None, full: bool, list_scenes: bool) -> None:
    """Plan SCENE and print the plan as JSON.

    Exit code 0: a complete plan; 3: the scene has none, and the JSON says why; 2: bad input.
    """
    from abi.planner.diagnosis import explain
    from abi.planner.planner import plan as plan_scene
    from abi.scene.scene import load_scene, scene_names

    if list_scenes:
        click.echo("\n".join(scene_names()))
        return
    result = plan_scene(load_scene(scene))
    data = result.to_dict(full)
    reason = explain(result.scene, result)
    if data["error"] is not None:
        data["error"]["reason"] = None if reason is None else reason.to_dict()
    text = json.dumps(data, indent=1, allow_nan=False)
    if out is None:
        print_text(text)
    else:
        write_text(out, text)
    if result.error is not None:
        explained = reason or result.error
        click.echo(f"{explained.message} {explained.hint}", err=True)
        raise SystemExit(INCOMPLETE)
