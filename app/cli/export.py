"""``abi export``: a plan as a file for another program."""

from __future__ import annotations

from pathlib import Path

import click

from app.cli.exit_code import INCOMPLETE
from app.cli.given_scene import given_scene


def _list_formats(context: click.Context, parameter: click.Parameter, asked: bool) -> None:
    """Print the formats, and end."""
    if asked and not context.resilient_parsing:
        from abi.export.formats import FORMATS

        for name, one in FORMATS.items():
            click.echo(f"{name:{max(map(len, FORMATS))}}  {one.label}")
        context.exit()


@click.command(short_help="Write SCENE's motion, curves, obstacles or arm to a file.")
@click.argument("scene", default="paper")
@click.option(
    "--to",
    "path",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    help="File to write; its ending gives the format.",
)
@click.option("--format", "format_name", help="Format, instead of the ending's.")
@click.option(
    "--formats",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_list_formats,
    help="List the formats and exit.",
)
def export(scene: str, path: Path, format_name: str | None) -> None:
    """Plan SCENE and write its motion, curves, obstacles or arm to a file.

    SCENE is a file, the name of a shipped scene, or - for YAML or JSON from standard input. Of one
    that has tasks the file has the motions of all legs.

    A motion whose arm touches something, is not proven clear, or passes a limit of its joints'
    speeds, accelerations or torques is written with a warning.

    Exit code 0: written; 3: the scene has no complete plan, and what there is of it is written
    where the format can hold it; 2: bad input.
    """
    from abi.errors import AbiError
    from abi.export import formats
    from abi.planner.planner import plan as plan_scene
    from abi.planner.task_plan import plan_tasks

    name = format_name or formats.format_of(path)
    if name not in formats.FORMATS:
        known = ", ".join(formats.FORMATS)
        raise click.ClickException(f"--format is {name!r}; expected one of {known}.")
    given = given_scene(scene)
    tasks = plan_tasks(given) if given.tasks else None
    plan = plan_scene(given) if tasks is None else tasks.joined
    try:
        formats.export(tasks or plan, path, name, allow_unproven=True)
    except AbiError as error:
        if plan.error is None:
            raise
        click.echo(f"abi: {error.message} {error.hint}".rstrip(), err=True)
        raise SystemExit(INCOMPLETE) from None
    click.echo(f"{path}: {formats.FORMATS[name].label}, {path.stat().st_size:,} bytes")
    warning = formats.FORMATS[name].warning(plan)
    if warning and (plan.error is None or warning != plan.error.message):
        click.echo(f"Warning: the arm's motion is not proven clear. {warning}", err=True)
    if past := formats.FORMATS[name].limits_warning(plan):
        click.echo(f"Warning: the motion passes limits of the joints. {past}", err=True)
    if plan.error is not None:
        click.echo(f"{plan.error.message} {plan.error.hint}", err=True)
        raise SystemExit(INCOMPLETE)
