"""The modulus averaged over the models that records leave open.

A model that was not chosen may be nearly as likely as the one that was, and have another modulus.

References
----------
J. A. Hoeting, D. Madigan, A. E. Raftery, C. T. Volinsky, Statistical Science 14 (1999) 382,
doi:10.1214/ss/1009212519.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import norm

from softsample.loop.deviation import bond_deviation, log_modulus_deviation
from softsample.loop.fit import Fit
from softsample.loop.select import Selection, misfit_with_penalties, unusable

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
    deviation : float
        Standard deviation of ln(mu), with what the bonded area leaves open.
    """

    fit: Fit
    weight: float
    deviation: float

    @classmethod
    def of(cls, fit: Fit, weight: float, stiffness: Mapping[str, float]) -> "Weighed":
        """A fit with the sizes of its discrepancy, and the stiffness of specimens."""
        alone = log_modulus_deviation(fit, stiffness)
        return cls(fit, weight, float(np.hypot(alone, bond_deviation(fit))))


def weighed(selection: Selection, stiffness: Mapping[str, float]) -> list[Weighed]:
    """Models that the selection fitted, the likeliest first.

    Each set of effects counts once. Each effect makes a model less probable beforehand by the
    number of effects in the library, so that no effect is as probable as any one of them. Those of
    a class, which the records do not tell apart, are as probable as the one that was chosen. If
    what the plain model is known to leave out was selected, no model without it counts.
    """
    known = {effect.name for effect in selection.final.model.effects if effect.idealised}
    likeliest: dict[frozenset[str], tuple[float, Fit]] = {}
    odds = 2.0 * np.log(len(selection.library) or 1)
    fits = selection.base, selection.final, *selection.visited
    tried = [(fit, misfit_with_penalties(fit)) for fit in fits]
    for step in selection.steps:
        for c in step.candidates:
            alike = (c, step.chosen) if step.chosen and c.name in step.members else (c,)
            tried.append((c.settled, min(misfit_with_penalties(one.settled) for one in alike)))
    for fit, misfit in tried:
        effects = fit.model.effects
        names = frozenset(fit.model.names)
        if (effects and unusable(fit)) or not known <= names:
            continue
        left = misfit + odds * len(effects)
        if names not in likeliest or left < likeliest[names][0]:
            likeliest[names] = left, fit
    least = min(left for left, _ in likeliest.values())
    weights = [float(np.exp(-0.5 * (left - least))) for left, _ in likeliest.values()]
    found = [
        Weighed.of(fit, weight / sum(weights), stiffness)
        for (_, fit), weight in zip(likeliest.values(), weights, strict=True)
    ]
    return sorted(found, key=lambda one: -one.weight)


def averaged(models: Sequence[Weighed]) -> tuple[float, float, float]:
    """Modulus and the ends of its 90 % interval [Pa]: log-normal in each model, weighted."""
    weights = np.array([one.weight for one in models])
    means = np.log([one.fit.state.material.mu for one in models])
    deviations = np.array([one.deviation for one in models])

    def above(x: float, part: float) -> float:
        return float(weights @ norm.cdf((x - means) / deviations)) - part

    reach = FURTHEST * float(deviations.max())
    low, high = float(means.min()) - reach, float(means.max()) + reach
    ends = [float(np.exp(brentq(above, low, high, args=(part,)))) for part in INTERVAL]
    return float(np.exp(weights @ means)), ends[0], ends[1]
