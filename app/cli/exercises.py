"""``abi exercises``: checks what students write on hidden scenes."""

from __future__ import annotations

import json
from pathlib import Path

import click

from app.cli.exit_code import INCOMPLETE
from app.cli.output import cause, print_text

_NOTEBOOK = ".ipynb"


@click.command(short_help="Check functions that students have written.")
@click.argument("file", required=False, type=click.Path(path_type=Path))
@click.option(
    "--begin",
    is_flag=True,
    help="Write FILE, a Python file or a notebook (.ipynb), with the beginning of each function.",
)
@click.option(
    "--grader",
    type=click.Choice(["nbgrader", "otter"]),
    help="With --begin: write the notebook of a course that this program grades.",
)
@click.option("--only", multiple=True, metavar="NAME", help="Exercise to take; all without it.")
@click.option("--seed", type=click.IntRange(0), help="Of the hidden scenes that grade a class.")
@click.option(
    "--results",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the results to this file as Gradescope's autograder reads them.",
)
def exercises(
    file: Path | None,
    begin: bool,
    grader: str | None,
    only: tuple[str, ...],
    seed: int | None,
    results: Path | None,
) -> None:
    """List the exercises, or check the functions in the Python file FILE.

    Each function is run on 20 hidden scenes, in a process of its own that has little time and
    memory, and neither network nor files to write to. What is wrong is told with a case.

    Exit code 0: all functions are right; 3: one is not; 2: bad input.
    """
    from abi.teach.catalogue import exercise
    from abi.teach.catalogue import exercises as all_exercises
    from abi.teach.exercise_file import beginning, exercises_in
    from abi.teach.exercise_notebook import GRADED, notebook
    from abi.teach.gradescope import results as results_of
    from abi.teach.verdict import SEED, check

    asked = tuple(map(exercise, only))
    if file is None:
        if begin or results is not None:
            raise click.UsageError("--begin and --results need a FILE.")
        print_text("\n\n\n".join(map(str, asked or all_exercises().values())))
        return
    if grader is not None and not (begin and file.suffix == _NOTEBOOK):
        raise click.UsageError("--grader needs --begin and a FILE that ends in .ipynb.")
    if not begin and file.suffix == _NOTEBOOK:
        raise click.UsageError(
            "Only Python files (.py) are checked: a notebook checks itself, in its cells with "
            "abi.teach.check, or save it as an executable script first."
        )
    if begin and file.suffix == _NOTEBOOK:
        made = notebook(only, grader=grader or "", seed=GRADED if seed is None else seed)
        _write(file, json.dumps(made, indent=1, ensure_ascii=False) + "\n", new=True)
        return
    if begin:
        _write(file, beginning(asked or tuple(all_exercises().values())), new=True)
        return
    verdicts = [
        check(one.name, file, seed=SEED if seed is None else seed)
        for one in asked or exercises_in(file)
    ]
    print_text("\n".join(map(str, verdicts)))
    if results is not None:
        _write(results, json.dumps(results_of(verdicts), indent=1))
    if not all(one.passed for one in verdicts):
        raise SystemExit(INCOMPLETE)


def _write(file: Path, text: str, new: bool = False) -> None:
    """Write a file; with ``new`` only if it does not exist yet."""
    try:
        with file.open("x" if new else "w", encoding="utf-8") as target:
            target.write(text)
    except FileExistsError:
        raise click.ClickException(
            f"{str(file)!r} is there already; choose another name."
        ) from None
    except OSError as error:
        why = cause(error, "not writable")
        raise click.ClickException(f"{str(file)!r} cannot be written ({why}).") from None
