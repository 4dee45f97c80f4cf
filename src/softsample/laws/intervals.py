"""Intervals of a law's parameters by profile likelihood; parameters that the data leave open."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from softsample.arrays import Array
from softsample.calibration.profile import normal_quantile
from softsample.laws.candidates import Shape
from softsample.laws.fit import LawFit, Problem

OPEN = 1.0
"""Singular value of the white changes by whole ranges below which a direction is open: all
of the range then changes the deviance by less than this."""

LEADING = 0.5
"""Part of an open direction from which a parameter is named."""

STEPS = (0.002, 0.25)
"""Least and largest first step of a profile, as a part of the range or of the modulus."""

REFINED = 8
"""Corrections of where a profile crosses its level, at most."""

NEAR = 0.03
"""Distance from the level, in the signed root of the deviance, that needs no correction."""


@dataclass(frozen=True)
class Interval:
    """Of one parameter; an end is None where the data set none within the range."""

    value: float
    low: float | None
    high: float | None


def intervals(problem: Problem, fit: LawFit, confidence: float) -> dict[str, Interval]:
    """Profile intervals of `mu` [Pa] and of each shape parameter.

    Parameters
    ----------
    problem : Problem
        With the weights of the residual model.
    fit : LawFit
        Its optimum.
    confidence : float
        Of each interval.
    """
    level = normal_quantile(confidence)

    def of_shape(k: int, s: Shape) -> Callable[[float], LawFit]:
        return lambda part: problem.fit(fit.candidate, [fit.shape], 1, held={k: s.value(part)})

    def of_modulus(value: float) -> LawFit:
        return problem.fit(fit.candidate, [fit.shape], 1, modulus=float(np.exp(value)))

    steps = np.clip(level * np.sqrt(np.diag(covariance(problem, fit))), *STEPS)
    centre = float(np.log(fit.mu))
    ends = [
        _end(of_modulus, fit.cost, centre, side * steps[0], side * np.inf, level)
        for side in (-1.0, 1.0)
    ]
    found = {"mu": Interval(fit.mu, *(None if e is None else float(np.exp(e)) for e in ends))}
    for k, s in enumerate(fit.candidate.shape):
        part, step = s.part(fit.shape[k]), steps[1 + k]
        parts = (
            _end(of_shape(k, s), fit.cost, part, side * step, limit, level)
            for side, limit in ((-1.0, 0.0), (1.0, 1.0))
        )
        found[s.name] = Interval(
            float(fit.shape[k]), *(None if end is None else s.value(end) for end in parts)
        )
    return found


def simpler_laws(
    problem: Problem, fit: LawFit, others: Sequence[LawFit], confidence: float
) -> list[str]:
    """Laws of fewer parameters that a likelihood-ratio test does not reject beside a law.

    Parameters
    ----------
    problem : Problem
        With the weights of the law's residual model.
    fit : LawFit
        Its optimum.
    others : sequence of LawFit
        All laws, each at its own optimum.
    confidence : float
        Of the test.
    """
    found = []
    for other in others:
        fewer = fit.candidate.size - other.candidate.size
        if fewer > 0:
            alike = problem.fit(other.candidate, [other.shape], 1)
            if alike.cost - fit.cost <= chdtri(fewer, 1.0 - confidence):
                found.append(other.candidate.name)
    return found


def covariance(problem: Problem, fit: LawFit) -> Array:
    """Covariance (1 + n_shape, 1 + n_shape) of ln(mu) and of shapes in parts of their ranges.

    That of the linearised problem, large without end in directions without information.
    """
    jacobian = problem.jacobian(fit)
    values, directions = np.linalg.eigh(jacobian.T @ jacobian)
    return np.asarray(directions / np.maximum(values, 1e-12) @ directions.T)


def covariance_of_shape(problem: Problem, fit: LawFit) -> Array:
    """Covariance (n_shape, n_shape) of the shape parameters, see `covariance`."""
    low, high = fit.candidate.bounds
    return np.asarray(covariance(problem, fit)[1:, 1:] * np.outer(high - low, high - low))


def _end(
    at: Callable[[float], LawFit],
    least: float,
    best: float,
    step: float,
    limit: float,
    level: float,
) -> float | None:
    """Where the signed root of the deviance reaches a level, going from the optimum by steps."""
    inner, below = best, 0.0
    for _ in range(8):
        outer = min(best + step, limit) if step > 0.0 else max(best + step, limit)
        above = float(np.sqrt(max(at(outer).cost - least, 0.0)))
        if abs(above - level) < NEAR:
            return outer
        if above >= level:
            break
        if outer == limit:
            return None
        inner, below, step = outer, above, 2.0 * step
    else:
        return None
    for _ in range(REFINED):
        middle = inner + (outer - inner) * (level - below) / (above - below)
        found = float(np.sqrt(max(at(middle).cost - least, 0.0)))
        if abs(found - level) < NEAR:
            return middle
        if found >= level:
            outer, above = middle, found
        else:
            inner, below = middle, found
    return inner + (outer - inner) * (level - below) / (above - below)


def left_open(problem: Problem, fit: LawFit) -> list[str]:
    """Parameters whose whole range these data would not show, alone or against others.

    Parameters
    ----------
    problem : Problem
        With the weights of the residual model.
    fit : LawFit
        Its optimum.
    """
    names = [s.name for s in fit.candidate.shape]
    jacobian = problem.jacobian(fit)
    scale = jacobian[:, :1]
    changes = jacobian[:, 1:] - scale @ np.linalg.lstsq(scale, jacobian[:, 1:], rcond=None)[0]
    _, values, directions = np.linalg.svd(changes, full_matrices=False)
    found: list[str] = []
    for value, direction in zip(values, directions, strict=True):
        if value < OPEN:
            found += [n for n, part in zip(names, direction, strict=True) if abs(part) > LEADING]
    return list(dict.fromkeys(found))
