"""The modulus averaged over the models that records leave open.

A model that was not chosen may be nearly as likely as the one that was, and have another modulus.

References
----------
J. A. Hoeting, D. Madigan, A. E. Raftery, C. T. Volinsky, Statistical Science 14 (1999) 382,
doi:10.1214/ss/1009212519.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import norm

from softsample.loop.fit import Fit, Problem
from softsample.loop.noise import NoiseSettings
from softsample.loop.scale import scatter
from softsample.loop.select import Selection, misfit_with_penalties, unusable
from softsample.response.floor import rectangular

Array = NDArray[np.float64]

INTERVAL = (0.05, 0.95)
"""Quantiles at the ends of a 90 % interval."""

FURTHEST = 10.0
"""Standard deviations from the outermost means within which quantiles are sought."""


@dataclass(frozen=True)
class Weighed:
    """A model that the search came to.

    Parameters
    ----------
    fit : Fit
        Of it.
    weight : float
        Its probability; those of all models add up to 1.
    bond : float
        Standard deviation of ln(mu) by what the bonded area leaves open.
    """

    fit: Fit
    weight: float
    bond: float = 0.0


def weighed(selection: Selection) -> list[Weighed]:
    """Models that the selection fitted, the likeliest first.

    Each set of effects counts once. Each effect makes a model less probable beforehand by the
    number of effects in the library, so that no effect is as probable as any one of them. If what
    the plain model is known to leave out was selected, no model without it counts.
    """
    known = {effect.name for effect in selection.final.model.effects if effect.idealised}
    likeliest: dict[frozenset[str], tuple[float, Problem, Fit]] = {}
    odds = 2.0 * np.log(len(selection.library) or 1)
    for problem, fit in _models(selection):
        effects = fit.model.effects
        names = frozenset(fit.model.names)
        if (effects and unusable(fit)) or not known <= names:
            continue
        left = misfit_with_penalties(problem, fit) + odds * len(effects)
        if names not in likeliest or left < likeliest[names][0]:
            likeliest[names] = left, problem, fit
    least = min(left for left, *_ in likeliest.values())
    weights = [float(np.exp(-0.5 * (left - least))) for left, *_ in likeliest.values()]
    found = [
        Weighed(fit, weight / sum(weights), bond_deviation(problem, fit))
        for (_, problem, fit), weight in zip(likeliest.values(), weights, strict=True)
    ]
    return sorted(found, key=lambda one: -one.weight)


def _models(selection: Selection) -> Iterator[tuple[Problem, Fit]]:
    yield selection.plain, selection.base
    yield selection.problem, selection.final
    for step in selection.steps:
        for candidate in step.candidates:
            yield candidate.posed, candidate.settled


def averaged(
    models: Sequence[Weighed], noise: NoiseSettings, stiffness: Mapping[str, float]
) -> tuple[float, float, float]:
    """Modulus and the ends of its 90 % interval [Pa]: log-normal in each model, weighted."""
    weights = np.array([one.weight for one in models])
    means = np.log([one.fit.state.material.mu for one in models])
    deviations = np.array(
        [np.hypot(log_modulus_deviation(one.fit, noise, stiffness), one.bond) for one in models]
    )

    def above(x: float, part: float) -> float:
        return float(weights @ norm.cdf((x - means) / deviations)) - part

    reach = FURTHEST * float(deviations.max())
    low, high = float(means.min()) - reach, float(means.max()) + reach
    ends = [float(np.exp(brentq(above, low, high, args=(part,)))) for part in INTERVAL]
    return float(np.exp(weights @ means)), ends[0], ends[1]


def log_modulus_deviation(fit: Fit, noise: NoiseSettings, stiffness: Mapping[str, float]) -> float:
    """Standard deviation of ln(mu): of the fit, and of a scale that all tests share.

    Where the stiffness of specimens scatters, the modulus is their geometric mean.
    """
    found = float(np.hypot(np.sqrt(fit.covariance[0, 0]), 0.01 * noise.scale_percent))
    if stiffness:
        found = float(np.hypot(found, scatter(stiffness) / np.sqrt(len(stiffness))))
    return found


def bond_deviation(problem: Problem, fit: Fit) -> float:
    """Standard deviation of ln(mu) by what the bonded area leaves open.

    The step from the model's bonded area to that of the other rule, the same part of it in all
    tests, is one parameter more, linearly; either rule is a limit (`rectangular`). Records that
    show it, as tension beside compression may, leave less open.
    """
    forces = problem.predicted(fit.model, fit.state)
    change = problem.white([s.bond * f for s, f in zip(problem.specimens, forces, strict=True)])
    beside = fit.jacobian[: problem.count].T @ change
    known = float(change @ change) + rectangular(1.0) ** -2
    with_it = fit.information - np.outer(beside, beside) / known
    more = np.linalg.inv(with_it)[0, 0] - fit.covariance[0, 0]
    return float(np.sqrt(max(more, 0.0)))
