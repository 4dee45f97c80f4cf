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
from scipy.special import ndtr

from softsample.loop.deviation import bond_deviation, log_modulus_deviation, relaxed_modulus
from softsample.loop.effects.base import Effect
from softsample.loop.fit import Fit
from softsample.loop.select import Selection
from softsample.loop.specimen import Array
from softsample.loop.usable import misfit_with_penalties, unusable

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
    weight, alike : float
        Its probability, and that if the models of a class are as probable as the one that was
        chosen, and that one as any refused; those of all models add up to 1.
    deviation : float
        Standard deviation of ln(mu), with what the bonded area leaves open.
    left : tuple of float
        The same modulus at the end of the longest record [Pa], and the deviation of its logarithm.
    """

    fit: Fit
    weight: float
    alike: float
    deviation: float
    left: tuple[float, float]

    @property
    def mu(self) -> float:
        """Its modulus [Pa]."""
        return self.fit.state.material.mu

    @classmethod
    def of(cls, fit: Fit, weight: float, alike: float, stiffness: Mapping[str, float]) -> "Weighed":
        """A fit with the sizes of its discrepancy, and the stiffness of specimens."""
        bond = bond_deviation(fit)
        deviation = float(np.hypot(log_modulus_deviation(fit, stiffness), bond))
        relaxed = relaxed_modulus(fit, stiffness)
        left = (
            (relaxed[0], float(np.hypot(relaxed[1], bond)))
            if relaxed
            else (fit.state.material.mu, deviation)
        )
        return cls(fit, weight, alike, deviation, left)


def weighed(selection: Selection, stiffness: Mapping[str, float]) -> list[Weighed]:
    """Models that the selection fitted, the likeliest first.

    Each set of effects counts once. Beforehand the study's law is as probable as all other laws of
    the library together, and none of its other effects as any one of them. If what the plain model
    is known to leave out was selected, no model without it counts. What explains nothing does not
    count either, but for what was selected: records may be far from all others.
    """
    known = {effect.name for effect in selection.final.model.effects if effect.idealised}
    laws = sum(effect.is_law for effect in selection.library)

    def price(effect: Effect) -> float:
        return 2.0 * np.log(laws if effect.is_law else len(selection.library) - laws)

    def counts(fit: Fit) -> bool:
        usable = fit is selection.final or not fit.model.effects or not unusable(fit)
        return usable and known <= set(fit.model.names)

    tried = [[fit] for fit in (selection.base, selection.final, *selection.visited)]
    for step in (*selection.steps, *selection.beside):
        members = step.members if step.chosen else []
        tried += [[c.settled] for c in step.candidates if c.name not in members]
        tried.append([c.settled for c in step.candidates if c.name in members])
    likeliest: dict[frozenset[str], tuple[float, float, Fit]] = {}
    for alike in tried:
        fits = [fit for fit in alike if counts(fit)]
        lefts = [misfit_with_penalties(fit) + sum(map(price, fit.model.effects)) for fit in fits]
        for fit, left in zip(fits, lefts, strict=True):
            names = frozenset(fit.model.names)
            was = likeliest.get(names, (np.inf, np.inf, fit))
            better = fit if left < was[0] else was[2]
            likeliest[names] = min(left, was[0]), min(*lefts, was[1]), better
    least = np.array([of[:2] for of in likeliest.values()])
    reported = [*likeliest].index(frozenset(selection.final.model.names))
    least[reported, 1] = least[:, 1].min()  # a refused model is no likelier than what is reported
    odds = np.exp(-0.5 * (least - least.min(axis=0)))
    found = [
        Weighed.of(fit, float(one), float(equal), stiffness)
        for (*_, fit), (one, equal) in zip(likeliest.values(), odds / odds.sum(axis=0), strict=True)
    ]
    return sorted(found, key=lambda one: -one.weight)


def averaged(models: Sequence[Weighed], relaxed: bool = False) -> tuple[float, float, float]:
    """Modulus and the ends of its 90 % interval [Pa]: log-normal in each model, weighted.

    It holds the interval with all members of a class as probable: records do not tell them apart.
    With `relaxed` of what is left of the modulus at the end of the longest record.
    """
    of_each = [one.left if relaxed else (one.mu, one.deviation) for one in models]
    means, deviations = np.log([mu for mu, _ in of_each]), np.array([sd for _, sd in of_each])
    reach = FURTHEST * float(deviations.max())
    within = float(means.min()) - reach, float(means.max()) + reach
    weights = np.array([(one.weight, one.alike) for one in models]).T

    def end(of: Array, part: float) -> float:
        return float(brentq(lambda x: of @ ndtr((x - means) / deviations) - part, *within))

    low, high = ([end(of, part) for of in weights] for part in INTERVAL)
    return float(np.exp(weights[0] @ means)), float(np.exp(min(low))), float(np.exp(max(high)))
