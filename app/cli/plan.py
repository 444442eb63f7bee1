"""``abi plan``: a plan as JSON, without a browser."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.cli.exit_code import INCOMPLETE
from app.cli.given_scene import STANDARD, given_scene
from app.cli.output import print_text, write_text

if TYPE_CHECKING:
    from abi.planner.plan import Plan
    from abi.scene.scene import Scene


@click.command(short_help="Plan SCENE and print the plan as JSON.")
@click.argument("scene", default="paper")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Write to a file.")
@click.option("--full", is_flag=True, help="Include the mesh's nodes and edges, and all samples.")
@click.option("--all-searches", is_flag=True, help="Run the other searches too, for comparison.")
@click.option("--list", "list_scenes", is_flag=True, help="List the shipped scenes and exit.")
def plan(scene: str, out: Path | None, full: bool, all_searches: bool, list_scenes: bool) -> None:
    """Plan SCENE and print the plan as JSON.

    SCENE is a file, the name of a shipped scene, or - for YAML or JSON from standard input. Of one
    that has tasks all legs are planned.

    Exit code 0: a complete plan; 3: the scene has none, and the JSON says why; 2: bad input.
    """
    from abi.explain.diagnosis import explain
    from abi.planner.planner import plan as plan_scene
    from abi.scene.scene import scene_names

    if list_scenes:
        print_text("\n".join(scene_names()))
        return
    given = given_scene(scene)
    if given.tasks:
        _plan_tasks(given, out, full)
        return
    result = plan_scene(given)
    data = result.to_dict(full)
    if all_searches and result.graph is not None:
        data["searches"] = _all_searches(result, data["searches"] or [])
    reason = explain(result.scene, result)
    if data["error"] is not None:
        data["error"]["reason"] = None if reason is None else reason.to_dict()
    _write(data, out)
    for note in result.notes:
        click.echo(note, err=True)
    if result.error is not None:
        explained = reason or result.error
        click.echo(f"{explained.message} {explained.hint}", err=True)
        raise SystemExit(INCOMPLETE)


def _plan_tasks(scene: Scene, out: Path | None, full: bool) -> None:
    """Plan all legs of a scene's tasks, and write their plan."""
    from abi.planner.task_plan import plan_tasks

    result = plan_tasks(scene)
    _write(result.to_dict(full), out)
    for note in result.notes:
        click.echo(note, err=True)
    if result.error is not None:
        number = len(result.legs)
        name = f" ({scene.tasks[number - 1].name})" if scene.tasks[number - 1].name else ""
        sentence = f"Leg {number}{name}: {result.error.message} {result.error.hint}"
        click.echo(sentence, err=True)
        raise SystemExit(INCOMPLETE)


def _write(data: dict[str, Any], out: Path | None) -> None:
    text = json.dumps(data, indent=1, allow_nan=False)
    if out is None or str(out) == STANDARD:
        print_text(text)
    else:
        write_text(out, text)


def _all_searches(plan: Plan, searches: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The plan's searches, followed by those that it does not run by default."""
    from abi.planner.comparison import compared_searches, search_problem

    done = {search["algorithm"] for search in searches}
    others = compared_searches(search_problem(plan, heuristic_weight=1.5))
    return searches + [other for other in others if other["algorithm"] not in done]
