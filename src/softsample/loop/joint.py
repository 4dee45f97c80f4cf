"""Joint fits of the material and one effect more, from several initial guesses."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from softsample.loop.effects.base import Effect
from softsample.loop.fit import Fit, Problem
from softsample.loop.model import Model, State
from softsample.loop.screen import Signature, faint, nominal_step, orthonormal

FAR_MORE = 2.0
"""How much more than another a fit changes what is held out for the other to be preferred."""

LADDER, RUNGS = 1.25, (-6, 11)
"""Ratio of the sizes at which an effect of one parameter is looked at, and their powers over the
nominal size."""

TRIED = 3
"""Initial guesses of a law, those of which least is left, from which it is fitted."""

PARTS = (0.5, 1.0)
"""Of the nominal sizes of a law, from which it sets out."""


def joint_fit(current: Fit, signature: Signature, tie: float) -> Fit:
    """Joint fit from the linear estimate of the sizes, or from a size that leaves less.

    Small sizes and the other points of the grid are tried until one fit earns what the linear
    estimate promises; starts of the effect's own are all tried. Where contact has moved further
    than is likely, the effect may be what moved it: an effect of one parameter and a law set out
    from none, too. A law sets out from points of its grid, those of which least is left, at an
    even modulus fraction.

    Parameters
    ----------
    current : Fit
        Without the effect.
    signature : Signature
        Of the effect, there.
    tie : float
        Sum of squares within which fits of a law are as good as each other.
    """
    problem, effect = current.problem, signature.effect
    sizes, *_ = np.linalg.lstsq(signature.columns, current.white, rcond=None)
    estimate = dict(signature.start)
    for x, p in zip(sizes, effect.sizes, strict=True):
        margin = 0.02 * (p.high - p.low)
        size = p.neutral + x * nominal_step(p)
        estimate[p.name] = float(np.clip(size, p.low + margin, p.high - margin))
    starts = [estimate, signature.start | faint(effect)]
    if len(effect.sizes) < 3 and not effect.is_law:
        starts += [{**estimate, **point} for point in effect.points]
    promised = current.cost - 0.95 * signature.gain(current.white)
    model = current.model.with_effect(effect)
    states = [current.state.with_values(effect.name, values) for values in starts]
    moved = abs(current.state.contact_zero) > problem.settings.contact_zero_mm
    if effect.is_law:  # changes all of the force, of which a linear estimate says little
        here = [current.state, replace(current.state, contact_zero=0.0)][: 1 + moved]
        own = [one for state in here for one in _law_starts(problem, model, state)]
        own = sorted(own, key=partial(_left, current, model))[:TRIED]
    else:
        own = [current.state.with_values(effect.name, start) for start in effect.starts]
    if effect.idealised:  # a change so large that the material found without it says little
        states = [states[0], *problem.of_each_fraction(model, states[0])]
        promised = -np.inf
    elif len(effect.parameters) == 1:
        ladder = _ladder(states[0], effect)
        best = _least_left(current, model, [states[0], *ladder])
        states = states if best is states[0] else [best, *states]
        if moved:
            unmoved = [replace(state, contact_zero=0.0) for state in ladder]
            own = [*own, _least_left(current, model, unmoved)]
    elif effect.shifts_travel:
        own = [*own, _least_left(current, model, _either_way(states[0], signature))]
    fits = problem.fits(model, states, tie, promised)
    return _likeliest(current, problem.fits(model, own, tie, found=fits), tie)


def _ladder(state: State, effect: Effect) -> list[State]:
    """The state with sizes of an effect of one parameter, from small to the end of its range."""
    (p,) = effect.parameters
    steps = nominal_step(p) * LADDER ** np.arange(*RUNGS)
    sizes = [p.neutral + step for step in steps if p.low < p.neutral + step < p.high]
    return [state.with_values(effect.name, {p.name: float(x)}) for x in sizes]


def _either_way(state: State, signature: Signature) -> list[State]:
    """The state with sizes of an effect at their nominal values, each of either sign.

    A platen off the sample has no force, and one that presses on it has: from none, a shift of
    either sign looks as bad as the worse of them. Sizes for tests that are not there stay.
    """
    effect, here = signature.effect, state.values[signature.effect.name]
    acting = [
        p for p, column in zip(effect.sizes, signature.columns.T, strict=True) if column.any()
    ]
    ways = [
        [p.neutral + step for step in (nominal_step(p), -nominal_step(p))
         if p.low < p.neutral + step < p.high]
        for p in acting
    ]  # fmt: skip
    names = [p.name for p in acting]
    return [
        state.with_values(effect.name, here | dict(zip(names, way, strict=True)))
        for way in product(*ways)
    ]


def _left(current: Fit, model: Model, state: State) -> float:
    """What is left of a state that the material could not take over linearly: sum of squares."""
    directions = orthonormal(current.jacobian)
    white = current.problem.residual(model, state)[: len(directions)]
    rest = white - directions @ (directions.T @ white)
    return float(rest @ rest)


def _least_left(current: Fit, model: Model, states: Sequence[State]) -> State:
    """The state of which least is left.

    Where contact sets in late, what a small size does tells little of what a large one does.
    """
    return min(states, key=partial(_left, current, model))


def law_fit(base: Fit, law: Effect, tie: float) -> Fit:
    """Joint fit of a law from each point of its grid.

    Parameters
    ----------
    base, tie
        As `current` and `tie` of `joint_fit`.
    law : Effect
        Another elastic law.
    """
    model = base.model.with_effect(law)
    states = _law_starts(base.problem, model, base.state)
    return _likeliest(base, base.problem.fits(model, states, tie), tie)


def nearest(current: Fit, alike: Sequence[Fit]) -> Fit:
    """The first of several fits, but for those that change far more of what is held out.

    Of opposite exponents, which shear hardly tells, one predicts a push and the other a pull. What
    the fit without them misses of what is fitted, it may miss of the rest as well.

    Parameters
    ----------
    current : Fit
        Without what is compared.
    alike : sequence of Fit
        Fits of laws that the records hardly tell apart, the best first.
    """
    changes = [current.problem.departure(fit, current) for fit in alike]
    most = FAR_MORE * max(min(changes), current.missed)
    return next(fit for fit, change in zip(alike, changes, strict=True) if change <= most)


def _likeliest(current: Fit, fits: Sequence[Fit], tie: float) -> Fit:
    """The best of several fits of one effect; of a law one that changes little, see `nearest`."""
    ranked = sorted(fits, key=lambda fit: fit.cost)
    if not ranked[0].model.effects[-1].is_law:
        return ranked[0]
    return nearest(current, [fit for fit in ranked if fit.cost < ranked[0].cost + tie])


def _law_starts(problem: Problem, model: Model, state: State) -> list[State]:
    """A state with a model's last effect, a law, at each of its starts or points of its grid.

    At some and all of its nominal sizes, with its own modulus, evenly.
    """
    law = model.effects[-1]
    starts = law.starts or [
        {p.name: p.neutral + part * nominal_step(p) for p in law.sizes} | dict(point)
        for part, point in product(PARTS, law.points)
    ]
    even = replace(state, material=replace(state.material, mu1_fraction=0.5))
    return [problem.of_own_modulus(model, even.with_values(law.name, start)) for start in starts]
