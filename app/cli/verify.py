"""``abi verify``: a plan's certificates, checked again."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from app.cli.exit_code import INCOMPLETE
from app.cli.given_scene import STANDARD
from app.cli.output import cause, print_text

if TYPE_CHECKING:
    from abi.obstacles.triangle_mesh.mesh_source import MeshSource


@click.command(short_help="Check a plan's certificates again, exactly.")
@click.argument("plan", type=click.Path(path_type=Path))
@click.option(
    "--meshes",
    type=click.Path(exists=True, path_type=Path),
    help="Folder or zip of the scene's files.  [default: the plan's folder, then the shipped "
    "scenes']",
)
def verify(plan: Path, meshes: Path | None) -> None:
    """Check every certificate in the file PLAN again in exact arithmetic.

    PLAN is a plan's JSON, or the verdict on a motion that abi certify writes.

    PLAN may be - for standard input.

    The last line names what PLAN states besides, and no certificate proves.

    Exit code 0: every curve is proven; 3: one is not, and its line says why; 2: bad input.
    """
    from abi.verify.plan_obstacles import meshes_beside
    from abi.verify.unchecked import unchecked
    from abi.verify.verify import verify as verify_plan

    data, shipped = _read(plan), list[str]()
    source = meshes_beside(plan.parent, shipped) if meshes is None else _files(meshes)
    verdicts = verify_plan(data, source)
    for name in dict.fromkeys(shipped):
        click.echo(f"{name!r} is not beside the plan; the shipped scenes' is taken.", err=True)
    lines = [str(verdict) for verdict in verdicts]
    if names := unchecked(data):
        lines.append(f"not checked: {', '.join(names)}")
    print_text("\n".join(lines))
    if not all(verdict.proven for verdict in verdicts):
        raise SystemExit(INCOMPLETE)


def _files(path: Path) -> Path | MeshSource:
    """The folder of a scene's files, or those in its zip."""
    from abi.obstacles.triangle_mesh.mesh_source import MeshSource
    from abi.scene.scene_archive import unpack

    if path.is_dir():
        return path
    try:
        content = path.read_bytes()
    except OSError as error:
        reason = cause(error, "not readable")
        raise click.ClickException(f"{str(path)!r} cannot be read ({reason}).") from None
    return MeshSource(unpack(content, path.name)[1])


def _read(path: Path) -> object:
    from abi.errors import SceneError
    from abi.scene.scene_file import unique

    name = repr(str(path))
    try:
        given = sys.stdin.buffer.read() if str(path) == STANDARD else path.read_bytes()
        data: object = msgspec.json.decode(given)
        json.loads(given, object_pairs_hook=unique)  # readers could take either of two
        return data
    except SceneError as error:
        raise click.ClickException(f"{name} is ambiguous; expected {error.expected}.") from None
    except OSError as error:
        raise click.ClickException(
            f"{name} cannot be read ({cause(error, 'not readable')})."
        ) from None
    except (msgspec.MsgspecError, ValueError, RecursionError):
        raise click.ClickException(
            f"{name} is not JSON. Write one with: abi plan SCENE --out PLAN"
        ) from None
