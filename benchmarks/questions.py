"""Campaign over generated questions: every key beside what another library or brute force says.

``python -m benchmarks.questions --count 10000``
"""

from __future__ import annotations

import argparse
import sys
import time

from abi.teach.quiz.templates import question, templates
from benchmarks.question_oracles import answer


def wrong_keys(count: int, first: int = 0) -> list[tuple[str, int]]:
    """Template and seed of the questions whose key is wrong, of ``count`` over all templates."""
    names = list(templates())
    found = []
    for number in range(count):
        name, seed = names[number % len(names)], first + number // len(names)
        made = question(name, seed)
        if answer(name, made) != made.right:
            found.append((name, seed))
    return found


def main() -> None:
    """Print how many questions were made, and which keys are wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="Seed of the first question.")
    given = parser.parse_args()
    begin = time.perf_counter()
    wrong = wrong_keys(given.count, given.first)
    seconds = time.perf_counter() - begin
    print(f"{given.count} questions of {len(templates())} templates in {seconds:.0f} s:")
    print(f"{len(wrong)} wrong keys{': ' if wrong else ''}{wrong[:20] or ''}")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
