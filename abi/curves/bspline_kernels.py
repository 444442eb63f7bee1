"""Points and Bézier points of splines."""

from __future__ import annotations

from abi.arrays import FloatArray
from abi.compiled import FLOATS, NEW_FLOATS, compiled


@compiled(example=(FLOATS, FLOATS, 1, FLOATS, 0, NEW_FLOATS, NEW_FLOATS))
def spline(
    knots: FloatArray,
    control: FloatArray,
    degree: int,
    parameters: FloatArray,
    order: int,
    local: FloatArray,
    points: FloatArray,
) -> None:
    """Points of a spline or its derivative, by de Boor's recursion on differences of its points.

    Args:
        knots: (n + degree + 1,), clamped.
        control: flat (3 n,), [unit].
        degree: p.
        parameters: (m,), not outside the knots.
        order: of the derivative, at most p.
        local: room for the points of the recursion, flat (3 (p + 1),); written.
        points: flat (3 m,); written.
    """
    count = len(control) // 3
    span = degree
    for number in range(len(parameters)):
        u = parameters[number]
        if u < knots[span]:
            span = degree
        while span < count - 1 and knots[span + 1] <= u:
            span += 1
        first = span - degree
        for i in range(3 * (degree + 1)):
            local[i] = control[3 * first + i]
        for step in range(1, degree + 1):
            for j in range(degree, step - 1, -1):
                left, right = knots[first + j], knots[first + j + degree + 1 - step]
                if step <= order:
                    rate = (degree + 1 - step) / (right - left)
                    for i in range(3 * j, 3 * j + 3):
                        local[i] = rate * (local[i] - local[i - 3])
                else:
                    share = (u - left) / (right - left)
                    rest, i = 1 - share, 3 * j
                    # written out: a loop over the axes takes a third as long again
                    local[i] = rest * local[i - 3] + share * local[i]
                    local[i + 1] = rest * local[i - 2] + share * local[i + 1]
                    local[i + 2] = rest * local[i - 1] + share * local[i + 2]
        for i in range(3):
            points[3 * number + i] = local[3 * degree + i]


@compiled(example=(FLOATS, FLOATS, 1, NEW_FLOATS, NEW_FLOATS))
def bezier(
    knots: FloatArray, control: FloatArray, degree: int, breaks: FloatArray, points: FloatArray
) -> int:
    """Bézier points of a spline's polynomials, by convex combinations only.

    Args:
        knots: (n + degree + 1,).
        control: flat (3 n,), [unit].
        degree: p.
        breaks: parameters between the s polynomials, of (n - p + 1,) the first s + 1; written.
        points: flat, of (3 (n - p) (p + 1),) the first 3 s (p + 1); written.

    Returns:
        s, the number of polynomials.
    """
    width = degree + 1
    local = [0.0] * (3 * width)
    k = 0
    for first in range(len(control) // 3 - degree):
        start, end = knots[first + degree], knots[first + width]
        if not start < end:
            continue
        breaks[k], breaks[k + 1] = start, end
        for point in range(width):
            for i in range(3 * width):
                local[i] = control[3 * first + i]
            for step in range(1, width):
                at = start if step <= degree - point else end
                for j in range(degree, step - 1, -1):
                    left, right = knots[first + j], knots[first + j + width - step]
                    share = (at - left) / (right - left)
                    for i in range(3 * j, 3 * j + 3):
                        local[i] = (1 - share) * local[i - 3] + share * local[i]
            for i in range(3):
                points[3 * (k * width + point) + i] = local[3 * degree + i]
        k += 1
    return k
