"""Profile likelihood: how far one parameter can move while the others make up for it.

References
----------
A. Raue et al., Bioinformatics 25 (2009) 1923, doi:10.1093/bioinformatics/btp358.
D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications, Wiley 1988,
doi:10.1002/9780470316757 (the signed root, in which a quadratic profile is a straight line).
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.optimize import minimize
from scipy.special import ndtri

from softsample.arrays import Array

AT_BOUND = 1e-3
"""Part of a range within which a parameter is at its bound."""


def end_met(part: float) -> str | None:
    """`minimum` or `maximum` where a parameter at a part of its range is at that end of it."""
    if part < AT_BOUND:
        return "minimum"
    return "maximum" if part > 1.0 - AT_BOUND else None


def normal_quantile(confidence: float) -> float:
    """Half-width of the central interval of a standard normal variable (1.645 for 0.9)."""
    return float(ndtri(0.5 + 0.5 * confidence))


def least(
    deviance: Callable[[Array], float],
    start: Array,
    held: Mapping[int, float],
    bounds: Sequence[tuple[float, float]],
) -> tuple[float, Array]:
    """Least deviance and where it is (p,), some parameters held, by SLSQP in the others.

    Parameters
    ----------
    deviance : callable
        -2 log likelihood of parameters (p,), up to a constant.
    start : (p,) float64
        Where the others start.
    held : dict of float
        Values of parameters by their index.
    bounds : sequence of (low, high)
        Of all parameters.
    """
    point = np.array(start, dtype=np.float64)
    point[list(held)] = list(held.values())
    free = [k for k in range(len(point)) if k not in held]

    def others(x: Array) -> float:
        point[free] = x
        return deviance(point)

    if not free:
        return deviance(point), point
    limits = [bounds[k] for k in free]
    found = minimize(others, point[free], method="SLSQP", bounds=limits, options={"ftol": 1e-10})
    return others(found.x), point


def profile(
    deviance: Callable[[Array], float],
    best: Array,
    index: int,
    values: Array,
    bounds: Sequence[tuple[float, float]],
) -> tuple[Array, Array]:
    """Least deviance with one parameter held at each of `values`.

    Parameters
    ----------
    deviance, bounds
        As in `least`.
    best : (p,) float64
        Where the deviance is least.
    index : int
        The parameter that is held.
    values : (k,) float64
        Its values; from `best` outwards each starts on the line through its two neighbours.

    Returns
    -------
    depths : (k,) float64
        Deviance at each value, less that at `best`.
    points : (k, p) float64
        Where it was found.
    """
    depths, points = np.empty(len(values)), np.empty((len(values), len(best)))
    above = values >= best[index]
    upwards = [k for k in np.argsort(values) if above[k]]
    downwards = [k for k in np.argsort(-values) if not above[k]]
    low, high = np.transpose(bounds)
    for side in (upwards, downwards):
        last, start = best, best
        for k in side:
            moved = start[index] - last[index]
            ahead = (values[k] - start[index]) / moved if moved else 0.0
            guess = np.clip(start + ahead * (start - last), low, high)
            last = start
            depths[k], start = least(deviance, guess, {index: values[k]}, bounds)
            points[k] = start
    return depths - deviance(best), points


def profile_interval(
    values: Array, depths: Array, best: float, confidence: float
) -> tuple[float, float]:
    """Where a profile crosses the level of `confidence`; infinite where it does not.

    The crossing is interpolated in the signed root of the deviance, against the parameter.
    """
    root = np.sign(values - best) * np.sqrt(np.maximum(depths, 0.0))
    values, root = np.append(values, best), np.append(root, 0.0)
    order = np.argsort(values, kind="stable")
    values, root = values[order], root[order]
    level, ends = normal_quantile(confidence), []
    for side in (-1.0, 1.0):
        outside = np.flatnonzero(side * root >= level)
        if not len(outside):
            ends.append(side * np.inf)
            continue
        k = outside.max() if side < 0.0 else outside.min()
        pair = [k, k - int(side)]
        pair.sort(key=lambda i: root[i])
        ends.append(float(np.interp(side * level, root[pair], values[pair])))
    return ends[0], ends[1]
