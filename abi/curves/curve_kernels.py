"""Points and Bézier points of splines, and arc length of curves made of polynomials, both ways."""

from __future__ import annotations

import math

import numpy as np

from abi.arrays import FloatArray
from abi.compilation.jitable import jitable
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


_MOST_HALVINGS = 40
_MOST_STEPS = 60


@jitable
def _speed(derivative: FloatArray, first: int, width: int, v: float, work: list[float]) -> float:
    """Length of the Bézier curve's point at v, whose points begin at ``derivative[first]``."""
    for i in range(3 * width):
        work[i] = derivative[first + i]
    for last in range(width - 1, 0, -1):
        for i in range(3 * last):
            work[i] = (1 - v) * work[i] + v * work[i + 3]
    return math.sqrt(work[0] * work[0] + work[1] * work[1] + work[2] * work[2])


@jitable
def _speeds(
    derivative: FloatArray,
    span: int,
    extent: float,
    part: tuple[float, float],
    nodes: FloatArray,
    work: list[float],
    speeds: list[float],
) -> None:
    """Write the speeds at the Gauss points of a part of a polynomial.

    Args:
        derivative: as in :func:`measured_pieces`.
        span: number of the polynomial.
        extent: how much its parameter grows.
        part: the part's middle and half its width in [0, 1].
        nodes: as in :func:`measured_pieces`.
        work: for the derivative's points (3 degree,); overwritten.
        speeds: (g,), [unit] by the part's own parameter in (-1, 1); written.
    """
    middle, half = part
    width = len(work) // 3
    for i in range(len(nodes)):
        v = middle + half * nodes[i]
        speeds[i] = half * extent * _speed(derivative, 3 * width * span, width, v, work)


@jitable
def _weighted_sum(weights: FloatArray, first: int, speeds: list[float]) -> float:
    """Sum of the speeds, with the weights from ``first`` on."""
    total = 0.0
    for i in range(len(speeds)):
        total += weights[first + i] * speeds[i]
    return total


@jitable
def _halved(
    breaks: FloatArray,
    derivative: FloatArray,
    nodes: FloatArray,
    tails: FloatArray,
    work: list[float],
    negligible: float,
) -> tuple[list[float], list[float]]:
    """Cut the polynomials until the last coefficients of each piece's speed are negligible.

    Args:
        breaks, derivative, nodes, tails: as in :func:`measured_pieces`.
        work: as in :func:`_speeds`.
        negligible: sum of the last two coefficients' magnitudes that is small enough, [unit].

    Returns:
        Parameters at the beginnings of the m pieces and at the end of the last (m + 1,), and the
        speeds at their Gauss points (m g,).
    """
    gauss = len(nodes)
    speeds, starts, all_speeds = [0.0] * gauss, [0.0] * 0, [0.0] * 0
    for k in range(len(breaks) - 1):
        extent = breaks[k + 1] - breaks[k]
        pending = [(0.0, 1.0, 0)]
        while len(pending) > 0:
            start, end, halvings = pending.pop()
            middle = (start + end) / 2
            _speeds(derivative, k, extent, (middle, (end - start) / 2), nodes, work, speeds)
            last = abs(_weighted_sum(tails, 0, speeds)) + abs(_weighted_sum(tails, gauss, speeds))
            if halvings == _MOST_HALVINGS or last <= negligible:
                starts.append(breaks[k] + extent * start)
                all_speeds.extend(speeds)
            else:
                pending.append((middle, end, halvings + 1))
                pending.append((start, middle, halvings + 1))
    starts.append(breaks[len(breaks) - 1])
    return starts, all_speeds


@compiled(example=(FLOATS, FLOATS, FLOATS, FLOATS, FLOATS, FLOATS, 1.0))
def measured_pieces(
    breaks: FloatArray,
    derivative: FloatArray,
    nodes: FloatArray,
    weights: FloatArray,
    tails: FloatArray,
    integral: FloatArray,
    rounding: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Pieces of a curve so short that the speed on each is a Legendre series to rounding.

    Args:
        breaks: parameters between the s polynomials (s + 1,).
        derivative: Bézier points of the derivative by the parameter, flat (3 s degree,).
        nodes: Gauss points in (-1, 1), (g,).
        weights: their weights (g,).
        tails: factors of the speeds there in the last two coefficients, (2 g,).
        integral: factors of the speeds there in the coefficients of the integral from -1, flat
            (g t,).
        rounding: largest contribution of the last coefficients by rounding, [unit]; a curve that
            is no longer has no length at all.

    Returns:
        Of the m pieces the parameters at their ends (m + 1,), the arc length up to these (m + 1,),
        [unit], the Legendre coefficients of the arc length within each, flat (m t,), the
        parameters of the Gauss points (m g,) and the arc length each stands for (m g,), [unit].
    """
    spans, gauss = len(breaks) - 1, len(nodes)
    work, speeds = [0.0] * (len(derivative) // spans), [0.0] * gauss
    total = 0.0
    for k in range(spans):
        _speeds(derivative, k, breaks[k + 1] - breaks[k], (0.5, 0.5), nodes, work, speeds)
        total += _weighted_sum(weights, 0, speeds)
    starts, all_speeds = _halved(breaks, derivative, nodes, tails, work, 1e-13 * total + rounding)
    count, terms = len(starts) - 1, len(integral) // gauss
    edges, travelled = np.empty(count + 1), np.empty(count + 1)
    series, places = np.zeros(count * terms), np.empty(count * gauss)
    lengths = np.empty(count * gauss)
    scale = 1.0 if total > rounding else 0.0
    edges[0], travelled[0] = starts[0], 0.0
    for k in range(count):
        middle, half = (starts[k] + starts[k + 1]) / 2, (starts[k + 1] - starts[k]) / 2
        length = 0.0
        for i in range(gauss):
            speed = scale * all_speeds[k * gauss + i]
            places[k * gauss + i] = middle + half * nodes[i]
            lengths[k * gauss + i] = weights[i] * speed
            length += weights[i] * speed
            for j in range(terms):
                series[k * terms + j] += speed * integral[i * terms + j]
        edges[k + 1], travelled[k + 1] = starts[k + 1], travelled[k] + length
    return edges, travelled, series, places, lengths


@jitable
def _piece_at(edges: FloatArray, value: float) -> int:
    """Number of the piece between ``edges`` that a value is on, the later where two meet."""
    low, high = 0, len(edges) - 2
    while low < high:
        middle = (low + high + 1) // 2
        if edges[middle] <= value:
            low = middle
        else:
            high = middle - 1
    return low


@jitable
def _factors(terms: int) -> tuple[list[float], list[float]]:
    """Factors of Clenshaw's recurrence at each term of a Legendre series."""
    first, second = [0.0] * terms, [0.0] * terms
    for n in range(terms):
        first[n], second[n] = (2 * n + 1) / (n + 1), (n + 1) / (n + 2)
    return first, second


@jitable
def _derive(series: FloatArray, start: int, terms: int, derived: list[float]) -> None:
    """Write the coefficients of a series' derivative: P'_n = (2 n - 1) P_n-1 + P'_n-2."""
    for n in range(terms - 1, 0, -1):
        passed_on = derived[n + 1] / (2 * n + 3) if n + 1 < terms - 1 else 0.0
        derived[n - 1] = (2 * n - 1) * (series[start + n] + passed_on)


@compiled(example=(FLOATS, FLOATS, FLOATS, FLOATS, NEW_FLOATS))
def arc_lengths(
    edges: FloatArray,
    travelled: FloatArray,
    series: FloatArray,
    parameters: FloatArray,
    distances: FloatArray,
) -> None:
    """Arc lengths up to parameters, (n,) written; other arguments as in :func:`parameters_at`."""
    last = len(edges) - 1
    terms = len(series) // last
    first, second = _factors(terms)
    for i in range(len(parameters)):
        u = parameters[i]
        if u <= edges[0]:
            distances[i] = 0.0
        elif u >= edges[last]:
            distances[i] = travelled[last]
        else:
            k = _piece_at(edges, u)
            place = 2 * (u - edges[k]) / (edges[k + 1] - edges[k]) - 1
            value, before = 0.0, 0.0
            for n in range(terms - 1, -1, -1):
                ahead = series[k * terms + n] + first[n] * place * value - second[n] * before
                value, before = ahead, value
            distances[i] = min(max(travelled[k] + value, 0.0), travelled[last])


@jitable
def _significant(series: FloatArray, start: int, terms: int, negligible: float) -> int:
    """Number of a series' terms without the last that are too small to matter."""
    while terms > 2 and abs(series[start + terms - 1]) <= negligible:
        terms -= 1
    return terms


@jitable
def _steepest(derived: list[float], count: int) -> float:
    """Bound of a series' slope on [-1, 1], where abs(P'_n) <= n (n + 1) / 2."""
    bound = 0.0
    for n in range(count):
        bound += abs(derived[n]) * (n * (n + 1) / 2)
    return bound


@compiled(example=(FLOATS, FLOATS, FLOATS, FLOATS, FLOATS, FLOATS, NEW_FLOATS))
def parameters_at(
    edges: FloatArray,
    travelled: FloatArray,
    series: FloatArray,
    nodes: FloatArray,
    weights: FloatArray,
    distances: FloatArray,
    parameters: FloatArray,
) -> None:
    """Parameters at which arc lengths have been travelled, by Newton's method within a bracket.

    Args:
        edges: parameters between the m pieces (m + 1,).
        travelled: arc length up to each (m + 1,), [unit].
        series: Legendre coefficients of the arc length within each piece, flat (m t,), [unit].
        nodes: parameters of each piece's g Gauss points, flat (m g,).
        weights: arc length that each stands for, flat (m g,), [unit].
        distances: (n,), [unit].
        parameters: (n,); written.
    """
    last = len(edges) - 1
    terms, gauss = len(series) // last, len(nodes) // last
    length = travelled[last]
    tolerance = 1e-13 * length
    first, second = _factors(terms)
    derived, curvature, used, current = [0.0] * terms, 0.0, terms, -1
    for i in range(len(distances)):
        distance = distances[i]
        if distance >= length:
            parameters[i] = edges[last]
            continue
        if distance <= 0:
            parameters[i] = edges[0]
            continue
        k = _piece_at(travelled, distance)
        left, right = edges[k], edges[k + 1]
        remaining = distance - travelled[k]
        if k != current:
            current = k
            used = _significant(series, k * terms, terms, 1e-16 * length)
            _derive(series, k * terms, used, derived)
            curvature = _steepest(derived, used - 1)
        # first guess: linear between the Gauss points; inline, as a call costs a fifth of the whole
        passed, here, u = 0.0, 0.0, left
        for j in range(k * gauss, (k + 1) * gauss):
            there = passed + weights[j] / 2
            if there >= remaining:
                if there > here:
                    u += (nodes[j] - u) * (remaining - here) / (there - here)
                break
            passed, here, u = passed + weights[j], there, nodes[j]
        place = 2 * (u - left) / (right - left) - 1
        # a little wider, so that Newton may step on an end
        low, high = -1.0 - 1e-9, 1.0 + 1e-9
        for _ in range(_MOST_STEPS):
            value, before, slope, slope_before = series[k * terms + used - 1], 0.0, 0.0, 0.0
            for n in range(used - 2, -1, -1):
                ahead = series[k * terms + n] + first[n] * place * value - second[n] * before
                value, before = ahead, value
                ahead = derived[n] + first[n] * place * slope - second[n] * slope_before
                slope, slope_before = ahead, slope
            error = value - remaining
            if abs(error) <= tolerance:
                break
            if error < 0:
                low = place
            else:
                high = place
            step = place - error / slope if slope > 0 else low
            if low < step < high and -1 <= step <= 1:
                # Taylor's theorem bounds the error that is left after a step
                left_over = curvature / 2 * (step - place) ** 2
                place = step
                if left_over <= tolerance:
                    break
            else:
                place = step if low < step < high else (low + high) / 2
        place = min(max(place, -1.0), 1.0)
        parameters[i] = min(left + (right - left) * (place + 1) / 2, right)
