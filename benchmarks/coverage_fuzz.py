"""Files that a fuzzer makes after the lines that they reach, read as the reader's process reads.

    python -m benchmarks.coverage_fuzz FOLDER -runs=100000

The folder keeps the files that reached something new; a new one begins with those of
:mod:`benchmarks.hostile_files`. The first byte of each says what it claims to be. Options are
libFuzzer's. An error that is no refusal, a crash or a hang over 20 s ends the run. atheris needs
Linux; ``benchmarks.fuzz`` does without it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["abi", "app", "yourdfpy"]):
    from abi.obstacles.triangle_mesh.mesh_reader import SUFFIXES
    from app.reading.reading import Kind, ReadingRequest, read, rehearse
    from benchmarks.hostile_files import hostile

_HANG = 20
"""Seconds in which a file must be dealt with: what is followed runs several times as slowly."""
_FIRST, _LONGEST = 300, 20_000
"""Hostile files to begin with, and bytes of the longest file."""
_CLAIMS: tuple[tuple[Kind, str], ...] = (
    *(("mesh", f"a{suffix}") for suffix in SUFFIXES),
    ("arm", "a.urdf"),
    ("arm", "a.zip"),
    ("scene", "a.yaml"),
    ("scene", "a.json"),
    ("scene", "a.zip"),
)


def read_one(content: bytes) -> None:
    """Read one file.

    Raises:
        AssertionError: it met an error that no reader should have raised.
    """
    if not content:
        return
    kind, name = _CLAIMS[content[0] % len(_CLAIMS)]
    answer = read(ReadingRequest(kind, name, content[1:]))
    assert not answer.fault, f"{name}: {answer.fault}"


def begin(folder: Path) -> None:
    """Make a folder of hostile files to begin with."""
    folder.mkdir(parents=True)
    claims = {(kind, Path(name).suffix): number for number, (kind, name) in enumerate(_CLAIMS)}
    for number in range(_FIRST):
        job = hostile(number, "nowhere")
        claim = claims.get((job.kind, Path(job.name).suffix.lower()))
        if claim is not None and len(job.content) < _LONGEST:
            (folder / str(number)).write_bytes(bytes([claim]) + job.content)


def main() -> None:
    """Fuzz until something is found, or as often as is asked."""
    folder = Path(sys.argv[1])
    if not folder.exists():
        begin(folder)
    rehearse()
    options = [f"-timeout={_HANG}", f"-max_len={_LONGEST}", *sys.argv[2:]]
    atheris.Setup([sys.argv[0], *options, str(folder)], read_one)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
