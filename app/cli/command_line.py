"""The commands of ``abi``: serve the visualiser, or plan without a browser.

Each command is a file in ``commands`` and imports what it needs when it runs, because the method
takes a second to import and the page can load meanwhile.
"""

from __future__ import annotations

import difflib
import sys
from pathlib import Path

import click

from app.cli.bench import bench
from app.cli.certify import certify
from app.cli.exercises import exercises
from app.cli.exit_code import BAD_INPUT
from app.cli.export import export
from app.cli.lessons import lessons
from app.cli.output import ensure_streams, lost_output
from app.cli.plan import plan
from app.cli.reproduce import reproduce
from app.cli.serve import serve
from app.cli.sweep import sweep
from app.cli.verify import verify
from app.process.versions import version_text


def _print_versions(ctx: click.Context, parameter: click.Parameter, asked: bool) -> None:
    if asked:
        click.echo(version_text())
        ctx.exit()


@click.group()
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_versions,
    help="Show the versions that matter and stop.",
)
def cli() -> None:
    """Plan a smooth, clear path for a robot's tool tip, and see every stage of it."""


for command in (serve, plan, verify, certify, export, sweep, reproduce, exercises, lessons, bench):
    cli.add_command(command)


def with_command(args: list[str]) -> list[str]:
    """The arguments with ``serve`` where they name no command, so that ``abi --port 8123`` works.

    Raises:
        UsageError: the first is nearly a command, and no file.
    """
    if args and args[0] in {*cli.commands, "--help", "--version"}:
        return args
    meant = difflib.get_close_matches(args[0], cli.commands, 1, 0.75) if args else []
    if meant and not Path(args[0]).exists():
        raise click.UsageError(f"There is no command {args[0]!r}; did you mean {meant[0]}?")
    return ["serve", *args]


def run() -> None:
    """Run the command; an expected error is one line on stderr and exit code 2."""
    ensure_streams()
    try:
        cli(with_command(sys.argv[1:]), standalone_mode=False)
        sys.stdout.flush()
    except click.ClickException as error:
        click.echo(f"abi: {error.format_message()}", err=True)
        sys.exit(BAD_INPUT)
    except click.Abort:
        sys.exit(130)
    except Exception as error:
        if isinstance(error, OSError) and (lost := lost_output(error)):
            click.echo(f"abi: {lost}", err=True)
            sys.exit(BAD_INPUT)
        from abi.errors import AbiError

        if not isinstance(error, AbiError):
            raise
        click.echo(f"abi: {error.message} {error.hint}".rstrip(), err=True)
        sys.exit(BAD_INPUT)
