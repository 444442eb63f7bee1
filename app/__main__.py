"""The ``abi`` command: serve the visualiser, or plan without a browser.

Each command imports what it needs: the method takes a second to load, the page loads meanwhile.
"""

from __future__ import annotations

import functools
import itertools
import json
import os
import sys
import threading
import webbrowser
from operator import attrgetter
from pathlib import Path

import click

INCOMPLETE, BAD_INPUT = 3, 2
_FILE_WIDTH = 150  # characters of a table that is written to a file


class _DefaultGroup(click.Group):
    """Commands with ``serve`` as the default: of ``abi``, and of ``abi --port 8123``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args or args[0] not in {*self.commands, "--help", "--version"}:
            args = ["serve", *args]
        return super().parse_args(ctx, args)


@click.group(cls=_DefaultGroup)
@click.version_option(package_name="abi-visualiser", prog_name="abi")
def cli() -> None:
    """Plan a smooth, clear path for a robot's tool, and see every stage of it."""


@cli.command()
@click.argument("scene", default="paper")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port", default=8080, show_default=True, type=click.IntRange(0, 65535), help="0: any free."
)
@click.option("--open/--no-open", "open_tab", default=True, help="Open a browser tab.")
@click.option("--dark/--light", default=False, help="How a new tab looks.")
def serve(scene: str, host: str, port: int, open_tab: bool, dark: bool) -> None:
    """Start the visualiser on SCENE (a shipped scene's name or a file) and print its URL."""
    from app.server import start

    announce = functools.partial(_announce, open_tab)
    server = start(host=host, port=port, scene=scene, dark=dark, announce=announce)
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        click.echo()
    finally:
        server.stop()


@cli.command()
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
        _print(text)
    else:
        _write(out, text)
    if result.error is not None:
        explained = reason or result.error
        click.echo(f"{explained.message} {explained.hint}", err=True)
        raise SystemExit(INCOMPLETE)


@cli.command()
@click.argument("plan", type=click.Path(path_type=Path))
@click.option(
    "--meshes",
    type=click.Path(file_okay=False, exists=True, path_type=Path),
    help="Folder of the scene's mesh files.  [default: the plan's, then the shipped scenes']",
)
def verify(plan: Path, meshes: Path | None) -> None:
    """Check every certificate in the file PLAN, a plan's JSON, again in exact arithmetic.

    Exit code 0: every curve is proven; 3: one is not, and its line says why; 2: bad input.
    """
    from abi.verify.verify import PlanMeshes
    from abi.verify.verify import verify as verify_plan

    found = PlanMeshes(plan.parent)
    verdicts = verify_plan(_read(plan), meshes or found)
    for name in dict.fromkeys(found.shipped):
        click.echo(f"{name!r} is not beside the plan; the shipped scenes' is taken.", err=True)
    click.echo("\n".join(map(str, verdicts)))
    if not all(verdict.proven for verdict in verdicts):
        raise SystemExit(INCOMPLETE)


@cli.command()
def reproduce() -> None:
    """Set the paper's figures and Table I beside ours, computed anew, as a table."""
    from rich.console import Console
    from rich.table import Table

    from abi.paper.reproduction import compare

    signs = {"holds": "✓", "depends on the mesh": "≈", "does not hold": "✗"}
    table = Table("where", "what", "printed", "ours", "")
    for section, comparisons in itertools.groupby(compare(), attrgetter("section")):
        table.add_section()
        for number, row in enumerate(comparisons):
            title = "" if number else section
            table.add_row(title, row.subject, row.printed, row.ours, signs[row.verdict])
    console = Console()
    if not console.is_terminal:
        console.width = max(console.width, _FILE_WIDTH)
    console.print(table)
    console.print("   ".join(f"{sign} {verdict}" for verdict, sign in signs.items()))


@cli.command()
@click.argument("parts", nargs=-1)
@click.option("--nodes", multiple=True, type=click.IntRange(100), help="Only these mesh sizes.")
@click.option("--scenes", default=30, show_default=True, type=click.IntRange(1))
@click.option("--out", default=Path("bench"), show_default=True, type=click.Path(path_type=Path))
def bench(parts: tuple[str, ...], nodes: tuple[int, ...], scenes: int, out: Path) -> None:
    """Measure speed and quality beside other libraries, in one run.

    PARTS: frames, quality, browser, start, tab; all when none is named. Peers that are not
    installed are left out: pip install '.[bench]' brings them.
    """
    try:
        from benchmarks import run
    except ImportError:
        raise click.ClickException(
            "The benchmarks are not installed. Run abi bench in the project's own folder."
        ) from None
    unknown = [part for part in parts if part not in run.PARTS]
    if unknown:
        raise click.ClickException(
            f"{unknown[0]!r} is no benchmark. There are {', '.join(run.PARTS)}."
        )
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        cause = _cause(error, "not writable")
        raise click.ClickException(f"--out: no folder {str(out)!r} ({cause}).") from None
    run.run(parts, nodes or run.SIZES, scenes, out)


def _announce(open_tab: bool, url: str) -> None:
    click.echo(f"The ABI visualiser is at {url} (Ctrl+C ends it)")
    if open_tab:
        webbrowser.open(url)


def _read(path: Path) -> object:
    name = repr(str(path))
    try:
        return json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse_constant)
    except OSError as error:
        raise click.ClickException(
            f"{name} cannot be read ({_cause(error, 'not readable')})."
        ) from None
    except (ValueError, RecursionError):
        raise click.ClickException(
            f"{name} is not JSON. Write one with: abi plan SCENE --out PLAN"
        ) from None


def _refuse_constant(constant: str) -> object:
    raise ValueError(constant)


def _cause(error: OSError, default: str) -> str:
    return (error.strerror or default).lower()


def _print(text: str) -> None:
    try:
        click.echo(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # the reader has closed the pipe, as head does; Python would flush once more at its end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        cause = _cause(error, "not writable")
        raise click.ClickException(f"The plan cannot be printed ({cause}).") from None


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        cause = _cause(error, "not writable")
        raise click.ClickException(f"--out: {str(path)!r} cannot be written ({cause}).") from None


def main() -> None:
    """Run the command; a foreseen error is one line on stderr and exit code 2."""
    try:
        cli(standalone_mode=False)
    except click.ClickException as error:
        click.echo(f"abi: {error.format_message()}", err=True)
        sys.exit(BAD_INPUT)
    except click.Abort:
        sys.exit(130)
    except Exception as error:
        from abi.errors import AbiError

        if not isinstance(error, AbiError):
            raise
        click.echo(f"abi: {error.message} {error.hint}".rstrip(), err=True)
        sys.exit(BAD_INPUT)


if __name__ == "__main__":
    main()
