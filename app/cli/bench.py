"""``abi bench``: speed and quality beside other libraries."""

from __future__ import annotations

from pathlib import Path

import click

from app.cli.output import cause


@click.command(short_help="Measure speed and quality beside other libraries.")
@click.argument("parts", nargs=-1)
@click.option("--nodes", multiple=True, type=click.IntRange(100), help="Only these mesh sizes.")
@click.option("--scenes", default=30, show_default=True, type=click.IntRange(1))
@click.option("--out", default=Path("bench"), show_default=True, type=click.Path(path_type=Path))
def bench(parts: tuple[str, ...], nodes: tuple[int, ...], scenes: int, out: Path) -> None:
    """Measure speed and quality beside other libraries, in one run.

    PARTS: frames, quality, browser, start, tab, tabs, crowds, shapes, arm; all
    when none is named.
    Peers that are not installed are left out: pip install '.[bench]' brings them.
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
        reason = cause(error, "not writable")
        raise click.ClickException(f"--out: no folder {str(out)!r} ({reason}).") from None
    run.run(parts, nodes or run.SIZES, scenes, out)
