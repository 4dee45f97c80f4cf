"""Profile likelihood: how far one parameter can move while the others make up for it.

References
----------
A. Raue et al., Bioinformatics 25 (2009) 1923, doi:10.1093/bioinformatics/btp358.
D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications, Wiley 1988,
doi:10.1002/9780470316757 (the signed root, in which a quadratic profile is a straight line).
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import ndtri

Array = NDArray[np.float64]


def normal_quantile(confidence: float) -> float:
    """Half-width of the central interval of a standard normal variable (1.645 for 0.9)."""
    return float(ndtri(0.5 + 0.5 * confidence))


def profile(
    deviance: Callable[[Array], float],
    best: Array,
    index: int,
    values: Array,
    bounds: Sequence[tuple[float, float]],
) -> tuple[Array, Array]:
    """Least deviance with one parameter held at each of `values`, by SLSQP in the others.

    Parameters
    ----------
    deviance : callable
        -2 log likelihood of parameters (p,), up to a constant.
    best : (p,) float64
        Where it is least.
    index : int
        The parameter that is held.
    values : (k,) float64
        Its values; from `best` outwards each starts where its neighbour ended.
    bounds : sequence of (low, high)
        Of all parameters.

    Returns
    -------
    least : (k,) float64
        Deviance at each value, less that at `best`.
    points : (k, p) float64
        Where it was found.
    """
    best = np.asarray(best, dtype=np.float64)
    others = [k for k in range(len(best)) if k != index]
    limits = [bounds[k] for k in others]
    points = np.tile(best, (len(values), 1))
    points[:, index] = values
    least = np.empty(len(values))
    above = values >= best[index]
    upwards = [k for k in np.argsort(values) if above[k]]
    downwards = [k for k in np.argsort(-values) if not above[k]]
    for side in (upwards, downwards):
        start = best[others]
        for k in side:

            def held(x: Array, point: Array = points[k]) -> float:
                point[others] = x
                return deviance(point)

            if others:
                found = minimize(
                    held, start, method="SLSQP", bounds=limits, options={"ftol": 1e-10}
                )
                start = found.x
            least[k] = held(start)
    return least - deviance(best), points


def profile_interval(
    values: Array, least: Array, best: float, confidence: float
) -> tuple[float, float]:
    """Where a profile crosses the level of `confidence`; infinite where it does not.

    The crossing is interpolated in the signed root of the deviance, against the parameter.
    """
    root = np.sign(values - best) * np.sqrt(np.maximum(least, 0.0))
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
