"""How likely a fit is with all its effects, and whether it may explain anything."""

from collections.abc import Mapping

import numpy as np

from softsample.loop.fit import Fit
from softsample.loop.model import FIXED
from softsample.loop.screen import LEAST_SIGNATURE, penalty

OPEN_MODULUS = float(np.log(2.0))
"""Standard deviation of ln(mu) above which a fit leaves the modulus open: a factor of two."""


def misfit_with_penalties(fit: Fit) -> float:
    """Twice the negative logarithm of the likelihood, with the penalties for all effects."""
    return fit.misfit + sum(penalty(e, len(fit.white)) for e in fit.model.effects)


def doubted(fit: Fit, doubt: Mapping[str, float] | None = None) -> Fit:
    """A model fitted with errors of at least the sizes that are doubted.

    By default those of geometry and mesh that no record may show.
    """
    if doubt is None:
        doubt = fit.problem.settings.doubt({}, geometry=True)
    return fit.problem.with_least(doubt).fit(fit.model, fit.state)


def driven_to_an_end(fit: Fit) -> str:
    """A size, exponent or period at an end of its range at which it is not absent; else empty.

    One that the records do not show, as an exponent of no modulus, may lie anywhere.
    """
    shown = np.linalg.norm(fit.jacobian[:, FIXED:], axis=0) >= LEAST_SIGNATURE
    of_effects = zip(fit.model.parameters, shown, fit.at_end[FIXED:], strict=True)
    for (effect, p), seen, at_end in of_effects:
        value = fit.state.values[effect.name][p.name]
        allowed = any(abs(value - end) < 0.01 * (p.high - p.low) for end in (p.neutral, *p.limits))
        if seen and (p.is_size or p.inside) and not allowed and at_end:
            return f"{effect.name}.{p.name}"
    return ""


def unusable(fit: Fit) -> str:
    """Why a fit explains nothing; empty if it may."""
    if at_end := driven_to_an_end(fit):
        return f"{at_end} lies at the end of its range"
    for effect in fit.model.effects:
        if effect.exceeds_the_whole(fit.state.values[effect.name]):
            return f"the parts of {effect.name} together exceed the whole"
    if np.sqrt(fit.covariance[0, 0]) > OPEN_MODULUS:
        return "the modulus is open with these effects"
    return ""
