"""Which effects could explain a residual: signatures that no change of the material imitates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from softsample.loop.effects.base import Effect, Parameter, Values
from softsample.loop.fit import Fit
from softsample.loop.model import Model
from softsample.loop.specimen import Array

LEVEL = 0.95
"""Part of records of noise alone in which no effect passes the threshold."""

LEAST_SIGNATURE = 1.0
"""A signature at nominal size below one standard deviation, all blocks together, says nothing."""


@dataclass(frozen=True, eq=False)
class Signature:
    """What an effect does to the white records beyond what the fitted parameters can imitate.

    Parameters
    ----------
    effect : Effect
        The effect.
    start : dict
        Values of the parameters that say how it acts; sizes are neutral.
    columns : (n, p) float64
        Projected change per nominal size, one column per size.
    basis : (n, q) float64
        Orthonormal basis of the columns.
    """

    effect: Effect
    start: Values
    columns: Array
    basis: Array

    @property
    def strength(self) -> float:
        """Length of the signature at nominal size, in standard deviations."""
        sizes = [abs(p.nominal - p.neutral) > 0.0 for p in self.effect.sizes]
        return float(np.linalg.norm(self.columns[:, sizes].sum(axis=1)))

    def gain(self, white: Array) -> float:
        """Fall of the sum of squares of a residual when the sizes are fitted to it."""
        size, *_ = np.linalg.lstsq(self.columns, white, rcond=None)
        allowed = [
            (x >= 0.0 or p.low < p.neutral) if p.nominal >= p.neutral else
            (x >= 0.0 or p.high > p.neutral)
            for x, p in zip(size, self.effect.sizes, strict=True)
        ]  # fmt: skip
        if not any(allowed):
            return 0.0
        basis = self.basis
        if not all(allowed):
            basis = orthonormal(self.columns[:, allowed])
        return float(np.sum((basis.T @ white) ** 2))


STEPS = (0.1, 1.0)
"""Parts of the nominal size at which signatures are taken: by how far it shifts, a toe bends."""


def signatures(base: Fit, effects: Sequence[Effect]) -> list[Signature]:
    """Signatures of all effects beside a fit, one for every point of the grid of how each acts."""
    problem = base.problem
    explained = orthonormal(base.jacobian)
    here = problem.predicted(base.model, base.state)
    travels = [base.model.travel(specimen, base.state) for specimen in problem.specimens]
    found = []

    def predicted(effect: Effect, values: Values) -> list[Array]:
        """With an effect that comes last, so that one of the instrument needs no new forces."""
        if effect.only_instrument:
            alone = Model((effect,))
            return [
                alone.reading(*of_test, {effect.name: values})
                for of_test in zip(problem.specimens, here, travels, strict=True)
            ]
        state = base.state.with_values(effect.name, values)
        return problem.predicted(base.model.with_effect(effect), state)

    for effect in effects:
        starts = [{**effect.neutral(), **point} for point in effect.points]
        for step in STEPS[: 1 + (not effect.only_instrument)]:
            changed = [
                predicted(effect, {**start, p.name: p.neutral + step * nominal_step(p)})
                for start in starts
                for p in effect.sizes
            ]
            columns = problem.white_changes(here, changed, base.model) / step
            columns -= explained @ (explained.T @ columns)
            for start, part in zip(starts, np.split(columns, len(starts), axis=1), strict=True):
                found.append(Signature(effect, start, part, orthonormal(part)))
    return found


def nominal_step(parameter: Parameter) -> float:
    """From the neutral to the nominal value; a tenth of the range where these are the same."""
    return parameter.nominal - parameter.neutral or 0.1 * (parameter.high - parameter.neutral)


def faint(effect: Effect) -> dict[str, float]:
    """Sizes of an effect at which it hardly acts: a hundredth of the nominal ones."""
    return {p.name: p.neutral + 0.01 * nominal_step(p) for p in effect.sizes}


def orthonormal(columns: Array) -> Array:
    """Orthonormal basis of the columns, those that vanish left out."""
    if columns.shape[1] == 0:
        return columns
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, singular > 1e-8 * max(singular[0], 1e-12)])


def penalty(effect: Effect, n: int) -> float:
    """Fall of the sum of squares that an effect's parameters must earn (Schwarz's criterion)."""
    return float(len(effect.parameters) * np.log(n))


def family_wise(found: Sequence[Signature], n: int, draws: int, seed: int, least: float) -> float:
    """Gain less penalty, `least` or more, that the best effect reaches by noise in 5 % of records.

    Draws are not needed where the sum of the chances of all signatures to pass `least` is below
    5 % already: the gain of each is distributed as chi-square.
    """
    seen = [s for s in found if s.basis.size]
    chances = [chdtrc(s.basis.shape[1], least + penalty(s.effect, n)) for s in seen]
    if sum(chances) <= 1.0 - LEVEL:
        return least
    return max(least, null_threshold(found, n, draws, seed))


def null_threshold(found: Sequence[Signature], n: int, draws: int, seed: int) -> float:
    """Largest gain less penalty among all effects that pure noise exceeds in 5 % of draws."""
    rng = np.random.default_rng(seed)
    span = orthonormal(np.hstack([signature.basis for signature in found]))
    noise = rng.standard_normal((span.shape[1], draws))  # all of it that the signatures see
    best = np.full(draws, -np.inf)
    for signature in found:
        gains = np.sum((signature.basis.T @ span @ noise) ** 2, axis=0)
        best = np.maximum(best, gains - penalty(signature.effect, n))
    return float(np.quantile(best, LEVEL))


def best_of_each(found: Sequence[Signature], white: Array) -> Mapping[str, tuple[float, Signature]]:
    """For every effect the gain and the signature of its best point."""
    best: dict[str, tuple[float, Signature]] = {}
    for signature in found:
        gain, name = signature.gain(white), signature.effect.name
        if name not in best or gain > best[name][0]:
            best[name] = gain, signature
    return best
