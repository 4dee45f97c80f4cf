"""Sizes from which on effects would have been seen."""

from dataclasses import replace

import numpy as np

from softsample.loop.effects.base import Values
from softsample.loop.fit import Fit, Problem
from softsample.loop.model import Model, State
from softsample.loop.screen import Signature, penalty
from softsample.loop.select import Selection

CLOSE = 0.1
"""Relative error of a size that is good enough for a limit."""

ROUNDS = 6
"""Corrections of a limit, at most."""

ZEROS = (-2.0, -1.0, 1.0, 2.0, 4.0)
"""Contact-point offsets from which fits to a shifted travel set out too, in standard deviations."""


def detection_limits(selection: Selection, final: Fit) -> dict[str, tuple[float, float]]:
    """Sizes at which an effect alone would just pass the first threshold.

    What the material and the effect predict is taken for a record and fitted by the material alone:
    what that leaves, not what derivatives say it would leave, has to earn penalty and threshold.
    The material is that of the plain model, or has the law that was found.
    The fit follows contact that comes late, for one, further than its derivative knows. Errors of
    geometry, mesh and form are as large as those that a candidate has to exceed.

    Parameters
    ----------
    selection : Selection
        What was found in the records.
    final : Fit
        What is reported of it.

    Returns
    -------
    dict of tuple
        By effect, its size as a multiple of the nominal one, and the modulus that the plain model
        finds beside it, over the true one. Without weak effects and those that no size within the
        range would show; without other laws where one was found.
    """
    law, found = final.model.law, final.state
    plain = State(found.material, {name: found.values[name] for name in law.names})
    threshold, n = selection.steps[0].threshold, len(selection.base.white)
    problem = selection.final.problem
    doubting = {
        geometry: problem.with_least(problem.settings.doubt(problem.variances, geometry))
        for geometry in (False, True)
    }
    limits = {
        name: _limit(
            doubting[signature.effect.like_geometry],
            law,
            plain,
            signature,
            threshold + penalty(signature.effect, n),
        )
        for name, signature in selection.strongest.items()
        if name not in selection.weak and law.admits(signature.effect)
    }
    return {name: limit for name, limit in limits.items() if limit is not None}


def _limit(
    problem: Problem, law: Model, plain: State, signature: Signature, need: float
) -> tuple[float, float] | None:
    """Where as much is left as is needed, None beyond the range."""
    effect, highest = signature.effect, _highest(signature)
    model, zeros = law.with_effect(effect), ZEROS if effect.shifts_travel else ()
    starts = [replace(plain, contact_zero=z * problem.settings.contact_zero_mm) for z in zeros]
    size = min(float(np.sqrt(need)) / signature.strength, highest)
    for _ in range(ROUNDS):
        state = plain.with_values(effect.name, _sized(signature, size))
        made = problem.with_forces(problem.predicted(model, state))
        fit = made.fit(law, plain, starts)
        limit = size, fit.state.material.mu / plain.material.mu
        further = size * float(np.sqrt(need / max(fit.cost, 1e-12)))
        if abs(further / size - 1.0) < CLOSE:
            break
        if size == highest and further > size:
            return None
        size = min(further, highest)
    return limit


def _sized(signature: Signature, multiple: float) -> Values:
    """Values of an effect at a multiple of its nominal size."""
    moved = {p.name: p.neutral + multiple * (p.nominal - p.neutral) for p in signature.effect.sizes}
    return {**signature.start, **moved}


def _highest(signature: Signature) -> float:
    """Multiple of the nominal size at which the first of the sizes is at the end of its range.

    Sizes that are parts of one whole are so together.
    """
    effect = signature.effect
    ends = [
        ((p.high if p.nominal > p.neutral else p.low) - p.neutral) / (p.nominal - p.neutral)
        for p in effect.sizes
        if p.nominal != p.neutral
    ]
    if effect.whole is not None:
        ends.append(max(p.high for p in effect.sizes) / effect.whole(_sized(signature, 1.0)))
    return min(ends)
