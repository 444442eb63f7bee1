"""Campaign over random curves, many of them near misses: certificates against dense sampling.

    python -m benchmarks.certificates --curves 20000

Each curve passes one to six obstacles of every shape. Its true clearance is found by dense
sampling, refined; most margins are that clearance times 1 ± 10^-k with k from 1 to 7. What is
counted: certified curves that the sampling refutes (must be 0), false rejects (not certified though
the clearance is above the margin by over 1e-6 of the scene's size), wrong witnesses, and
certificates that the exact checker refuses.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import abi
from abi.curves.bspline import BSpline
from abi.curves.clearance.certificate import Certificate, Refutation, certify
from abi.curves.quadratic import Quadratic
from abi.obstacles.obstacle_set import Obstacles, ObstacleSet
from abi.verify.verify import Verdict, verify
from tests.random_geometry import SIZE, random_curve, random_obstacle

DENSE = 2001
CLOSE = 1e-6 * SIZE


@dataclass
class Figures:
    """Results of a campaign; the four faults are lists of the curves' numbers."""

    curves: int = 0
    certified: int = 0
    refuted: int = 0
    undecided: int = 0
    checked: int = 0
    planes: list[int] = field(default_factory=list)
    microseconds: list[float] = field(default_factory=list)
    false_accepts: list[int] = field(default_factory=list)
    false_rejects: list[int] = field(default_factory=list)
    wrong_witnesses: list[int] = field(default_factory=list)
    wrongly_refused: list[int] = field(default_factory=list)

    def __str__(self) -> str:
        median, most = np.percentile(self.microseconds, [50, 95])
        planes = np.percentile(self.planes or [0], [50, 95])
        return "\n".join(
            [
                f"curves                             {self.curves:7}",
                f"certified                          {self.certified:7}",
                f"refuted by a witness               {self.refuted:7}",
                f"undecided                          {self.undecided:7}",
                f"certified, yet sampling refutes    {len(self.false_accepts):7}",
                f"false rejects                      {len(self.false_rejects):7}",
                f"wrong witnesses                    {len(self.wrong_witnesses):7}",
                f"checked again in rationals         {self.checked:7}",
                f"of these refused                   {len(self.wrongly_refused):7}",
                f"time per curve                     median {median:.0f} µs, 95 % {most:.0f} µs",
                f"planes per certificate             median {planes[0]:.0f}, 95 % {planes[1]:.0f}",
            ]
        )


def campaign(curves: int, seed: int = 0, check_every: int = 50) -> Figures:
    """Certify random curves and compare with dense sampling.

    Args:
        curves: how many.
        seed: of the first; the next have the next numbers.
        check_every: one certificate of so many is checked again in exact rationals.
    """
    figures = Figures()
    for number in range(seed, seed + curves):
        random = np.random.default_rng(number)
        curve = random_curve(random)
        obstacles = tuple(random_obstacle(random) for _ in range(random.integers(1, 7)))
        clearance = true_clearance(curve, obstacles)
        margin = _margin(random, clearance)
        begin = time.perf_counter()
        result = certify(curve, ObstacleSet(obstacles), margin)
        figures.microseconds.append(1e6 * (time.perf_counter() - begin))
        figures.curves += 1
        if isinstance(result, Refutation):
            figures.refuted += result.decided
            figures.undecided += not result.decided
            if clearance > margin + CLOSE:
                figures.false_rejects.append(number)
            there = ObstacleSet(obstacles).nearest(curve(np.array([result.parameter])))[0][0]
            if result.decided and not there < margin + 1e-12 * SIZE:
                figures.wrong_witnesses.append(number)
            continue
        figures.certified += 1
        figures.planes.append(len(result.pieces))
        if clearance <= margin:
            figures.false_accepts.append(number)
        if figures.certified % check_every == 0:
            figures.checked += 1
            if not checked(curve, obstacles, result).proven:
                figures.wrongly_refused.append(number)
    return figures


def true_clearance(curve: BSpline | Quadratic, obstacles: Obstacles) -> float:
    """Least distance at 2,001 parameters, and at ever finer ones around the four least of these."""
    parameters = np.linspace(0, 1, DENSE)
    distance = ObstacleSet(obstacles).nearest(curve(parameters))[0]
    inner = np.pad(distance, 1, constant_values=np.inf)
    lowest = np.flatnonzero((distance <= inner[:-2]) & (distance <= inner[2:]))
    lowest = lowest[np.argsort(distance[lowest])[:4]]
    least = float(distance.min())
    middle, width = parameters[lowest], 1 / (DENSE - 1)
    for _ in range(6):
        around = np.clip(middle[:, None] + width * np.linspace(-1, 1, 41), 0, 1)
        distance = ObstacleSet(obstacles).nearest(curve(around.ravel()))[0].reshape(around.shape)
        least = min(least, float(distance.min()))
        middle, width = around[np.arange(len(around)), distance.argmin(axis=1)], width / 10
    return least


def checked(curve: BSpline | Quadratic, obstacles: Obstacles, result: Certificate) -> Verdict:
    """Verdict of the exact checker on a curve, as it would stand in a plan."""
    return next(v for v in verify(as_plan(curve, obstacles, result)) if v.curve == name_of(curve))


def name_of(curve: BSpline | Quadratic) -> str:
    """Name of the curve's section in a plan."""
    return "bspline" if isinstance(curve, BSpline) else "quadratic"


def as_plan(
    curve: BSpline | Quadratic, obstacles: Obstacles, result: Certificate
) -> dict[str, Any]:
    """A plan of nothing but the obstacles, this curve and its certificate."""
    columns = (result.pieces.tolist(), result.obstacle.tolist(), result.directions.tolist())
    section: dict[str, Any] = {
        "clearance": result.margin,
        "certified": True,
        "certificate": {
            "margin": result.margin,
            "planes": [
                {"t0": t0, "t1": t1, "obstacle": obstacle, "direction": direction}
                for (t0, t1), obstacle, direction in zip(*columns, strict=True)
            ],
        },
    }
    if isinstance(curve, BSpline):
        section["degree"] = curve.degree
        section["knots"] = curve.knots.tolist()
        section["control_points"] = curve.control_points.tolist()
    else:
        section["pieces"] = [
            {"t0": t0, "t1": t1, "coefficients": rows.tolist()} for t0, t1, rows in curve.pieces
        ]
    shapes = [obstacle.model_dump(mode="json") for obstacle in obstacles]
    required = max(result.margin, 0.0)
    ends = curve(np.array(curve.interval))
    low, high = ends.min(axis=0) - 1, ends.max(axis=0) + 1
    scene = {
        "version": 1,
        "obstacles": shapes,
        "spline": {"clearance": required},
        "workspace": {"min": low.tolist(), "max": high.tolist()},
        "start": ends[0].tolist(),
        "goal": ends[1].tolist(),
        "mesh": {"pitch": float((high - low).max())},
    }
    plan: dict[str, Any] = {"version": 1, "scene": scene}
    return {**plan, "bspline": None, "quadratic": None, name_of(curve): section}


def _margin(random: np.random.Generator, clearance: float) -> float:
    if clearance <= 0 or random.random() < 0.2:
        return float(random.choice([0.0, 0.05, 0.3]))
    return float(clearance * (1 + random.choice([-1, 1]) * 10.0 ** -random.integers(1, 8)))


def main() -> None:
    """Run a campaign and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--curves", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    abi.compile()
    print(campaign(options.curves, options.seed))


if __name__ == "__main__":
    main()
