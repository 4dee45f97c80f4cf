"""What no named effect explains, as a smooth function of the strain: a correction, not a cause.

It is a part of the model's force, as the difference of two elastic laws is, which tests of one mode
share; the scale of each test is its own. A mode is corrected only if folds bear it out: if it takes
a fifth of the error of parts of the records that were left out when it was learned.

References
----------
C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from scipy.linalg import block_diag, eigh
from scipy.optimize import minimize_scalar

from softsample.loop.discrepancy import averaging
from softsample.loop.effects.base import Effect, Values
from softsample.loop.errors import Fold, fold_errors
from softsample.loop.fit import Fit, Problem
from softsample.loop.noise import SIMILARITY
from softsample.loop.scale import Scales, by_specimen, most_likely, scale_of
from softsample.loop.specimen import FORCE, Array, Specimen

Kind = tuple[str, str]
Ways = dict[bool, float]
"""Errors of what folds leave out [parts of the peak], by whether that is the end of the stroke."""

NAME = "correction"
"""Of the effect that stands for it in a model."""

LAST = "last_quarter"
"""Fold that leaves out the end of the stroke of every test."""

MAY_BE_LEFT = 0.8
"""Part of the error of what was left out that may be left, if a correction is given."""

TINY = 1e-3
"""Part of the peak below which an error is none: no sample and no cell is known better."""

LENGTH = 1.0
"""Strain over which it changes: the ratio of two laws changes where strains are of order one."""

SIZES = (1e-3, 10.0)
"""Its standard deviation, as a part of the force, lies between these."""

LOCAL = (1.0, 0.1, 0.01, 1e-3, 0.0)
"""Variances of each test's local discrepancy that are tried, as parts of that of the smooth one."""

EXPERIMENTS = {
    "elastic_form": "another mode on the same sample, and a larger stroke",
    "specimen_stiffness": "the same test on more samples, and each sample twice",
    "mode_ratio": "more modes on the same sample",
    "history": "holds, and several speeds",
    "zero": "contact found anew before each test",
    "drift": "the machine without a sample",
    "cross_talk": "both directions of shear",
}


@dataclass(frozen=True)
class Correction:
    """A correction that was learned from records.

    Parameters
    ----------
    strain, weight : dict of (n,) float64
        Of each mode and channel, where it was learned, and its weights.
    scale : dict of float
        Error of the scale of what was fitted, by specimen, mode and channel, as a part.
    size : dict of float
        RMS of the smooth part and of the scale in what was fitted, as parts of the peak.
    """

    strain: Mapping[Kind, Array]
    weight: Mapping[Kind, Array]
    scale: Scales
    size: Mapping[str, float]

    def apply(self, specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
        """Corrected force (n,) [N] of any test."""
        kind = _kind(specimen)
        if kind not in self.strain:
            return force
        smooth = _likeness(_strain(specimen, travel), self.strain[kind]) @ self.weight[kind]
        return np.asarray(force * (1.0 + scale_of(specimen, self.scale) + smooth))

    @property
    def of_modulus(self) -> dict[str, float]:
        """By mode, the corrected modulus at small strain over that of the model, not below zero."""
        start = np.zeros(1)
        return {
            mode: max(0.0, 1.0 + float((_likeness(start, x) @ self.weight[mode, channel])[0]))
            for (mode, channel), x in self.strain.items()
            if channel == FORCE
        }

    def only(self, kinds: Collection[Kind]) -> Self:
        """Of some modes and channels alone."""
        return replace(self, strain={k: x for k, x in self.strain.items() if k in kinds})

    def of(self, fit: Fit) -> Fit:
        """A fit with it."""
        model = fit.model.with_effect(_effect(self.apply))
        return replace(fit, model=model, state=fit.state.with_values(NAME, {}))


@dataclass(frozen=True)
class Predictor:
    """What predicts best what is not measured, and how it did on what was left out.

    Parameters
    ----------
    fit : Fit
        Of a model to the records.
    learned : Correction or None
        Of that model; none if it is best as it is.
    folds : dict of Fold
        The models of the folds, each with a correction that was learned from its rest.
    error_before, error_after : float
        Error of what these leave out, of the first model that was tried and of this [% of peak].
    """

    fit: Fit
    learned: Correction | None
    folds: Mapping[str, Fold] = field(repr=False)
    error_before: float
    error_after: float

    @property
    def whole(self) -> Fit:
        """The model with its correction."""
        return self.learned.of(self.fit) if self.learned else self.fit

    @property
    def scales(self) -> Scales:
        """Errors of the scale of what the whole predicts; what is corrected has its own."""
        corrected = self.learned.strain if self.learned else {}
        found = most_likely(self.fit)
        return {key: error for key, error in found.items() if key[1:] not in corrected}

    @property
    def kind(self) -> str:
        """Class of what it corrects."""
        if self.learned is None:
            return _stage(self.fit.model.effects[0])
        ways = [s.way for s in self.fit.problem.specimens]
        if len(ways) == 1 or self.learned.size["smooth"] >= self.learned.size["scale"]:
            return "elastic_form"
        once = len(set(ways)) == len(ways)
        return "mode_ratio" if once or _within(self.learned.scale) else "specimen_stiffness"

    def report(self) -> dict[str, Any]:
        """What `verdict.json` holds."""
        problem = self.fit.problem
        return {
            "class": self.kind,
            "smooth_part": self.learned is not None,
            "with": list(self.fit.model.names),
            "parameters": {
                e.name: e.report(self.fit.state.values[e.name]) for e in self.fit.model.effects
            },
            "domain_mm": {
                label: float(1e3 * np.abs(s.travel[~s.held_out]).max(initial=0.0))
                for label, s in zip(problem.labels, problem.specimens, strict=True)
                if self.learned is None or _kind(s) in self.learned.strain
            },
            "modulus_factors": self.learned.of_modulus if self.learned else {},
            "left_out_before_percent": self.error_before,
            "left_out_after_percent": self.error_after,
            "separating_experiment": EXPERIMENTS[self.kind],
        }


def _within(scales: Scales) -> bool:
    """Whether scales differ more between the tests of one specimen than between specimens."""
    of: dict[str, list[float]] = {}
    for (piece, *_), error in scales.items():
        of.setdefault(piece, []).append(error)
    between = np.var([np.mean(errors) for errors in of.values()])
    return bool(np.mean([np.var(errors) for errors in of.values()]) > between)


def _stage(effect: Effect) -> str:
    """Class of what an effect stands for, if it is not taken for the cause."""
    if effect.name in EXPERIMENTS:
        return effect.name
    if effect.crosstalk:
        return "cross_talk"
    if effect.tissue:  # by its history, or in proportion to the force, as geometry may
        return "mode_ratio" if effect.like_geometry else "history"
    if effect.elastic:
        return "elastic_form"
    return "drift" if effect.only_instrument else "zero"


def best_predictor(
    models: Sequence[tuple[Fit, Mapping[str, Fold]]], noises: Sequence[float]
) -> Predictor | None:
    """What predicts best what folds leave out; none if it is not far better than the first model.

    What is no more than the stated floor is not corrected.

    Parameters
    ----------
    models : sequence of (fit, folds)
        What was fitted to the records, and the same fitted to what each fold leaves.
    noises : sequence of float
        Standard deviation of a block of each test [N].
    """
    found: list[Predictor] = []
    reference = np.inf
    for place, (fit, folds) in enumerate(models):
        problem = fit.problem
        told = {name: fold for name, fold in folds.items() if _can_tell(problem, name, fold)}
        bare = _left_out(problem, told, noises)
        if place == 0:
            reference = _mean(bare)
            if not problem.settings.floor_percent < reference < np.inf:
                return None
        else:
            found.append(Predictor(fit, None, folds, reference, _mean(bare)))
        known = {name: learned(fold.fit) for name, fold in told.items()}
        after = _left_out(problem, _corrected(told, known), noises)
        held = [kind for kind in bare if _better(after[kind], bare[kind])]
        if not held:
            continue
        for name in folds.keys() - told.keys():
            known[name] = learned(folds[name].fit)
        only = {name: known[name].only(held) for name in folds}
        left = _mean(_left_out(problem, _corrected(told, only), noises))
        own, corrected = learned(fit).only(held), _corrected(folds, only)
        found.append(Predictor(fit, own, corrected, reference, left))
    best = None
    for one in found:  # the least changed first: another has to be far better than it
        if one.error_after <= MAY_BE_LEFT * (best.error_after if best else reference):
            best = one
    return best


def _corrected(folds: Mapping[str, Fold], known: Mapping[str, Correction]) -> dict[str, Fold]:
    """Folds, each with a correction."""
    return {name: replace(f, fit=known[name].of(f.fit)) for name, f in folds.items()}


def _can_tell(problem: Problem, name: str, fold: Fold) -> bool:
    """Whether a fold leaves out what others of its kind, or the rest of its record, tell of."""
    left = [_kind(s) for s, mask in zip(problem.specimens, fold.masks, strict=True) if mask.any()]
    kinds = [_kind(s) for s in problem.specimens]
    told = all(kinds.count(kind) > left.count(kind) for kind in left)
    return bool(left) and (name == LAST or told)


def _left_out(
    problem: Problem, folds: Mapping[str, Fold], noises: Sequence[float]
) -> dict[Kind, Ways]:
    """RMS error of what folds leave out, by mode and channel, and by whether it is `LAST`."""
    kinds = {name: _kind(s) for name, s in zip(problem.labels, problem.specimens, strict=True)}
    found: dict[Kind, dict[bool, list[float]]] = {}
    for name, tests in fold_errors(problem, folds, noises).items():
        for label, error in tests.items():
            ways = found.setdefault(kinds[label], {})
            ways.setdefault(name == LAST, []).append((error.structured / error.peak) ** 2)
    return {
        kind: {way: float(np.sqrt(np.mean(squares))) for way, squares in ways.items()}
        for kind, ways in found.items()
    }


def _better(after: Ways, before: Ways) -> bool:
    """Whether an error has fallen far enough on the mean, and in no way has risen as far."""
    ratios = [max(after[way], TINY) / max(before[way], TINY) for way in before]
    on_the_mean = np.exp(np.mean(np.log(ratios)))
    return bool(on_the_mean <= MAY_BE_LEFT and max(ratios) <= 1.0 / MAY_BE_LEFT)


def _mean(errors: Mapping[Kind, Ways]) -> float:
    """Root mean square over modes and channels [%], its geometric mean over the ways."""
    ways: dict[bool, list[float]] = {}
    for of in errors.values():
        for way, error in of.items():
            ways.setdefault(way, []).append(error**2)
    logs = [0.5 * np.log(max(float(np.mean(squares)), TINY**2)) for squares in ways.values()]
    return float(100.0 * np.exp(np.mean(logs))) if logs else np.inf


def _kind(specimen: Specimen) -> Kind:
    return specimen.mode, specimen.channel


def _effect(tissue: Callable[[Specimen, Array, Array, Values], Array]) -> Effect:
    """Change of the force of the sample, as the last effect of a model."""
    return Effect(NAME, "Correction", (), __name__, "smooth in the strain", tissue=tissue)


def learned(fit: Fit) -> Correction:
    """The most likely correction of a fit: a conditional mean of Gaussian processes."""
    problem = fit.problem
    kinds: dict[Kind, list[int]] = {}
    for k, (s, w) in enumerate(problem.each()):
        if w.keep.any():
            kinds.setdefault(_kind(s), []).append(k)
    strain, weight = {}, {}
    scale: list[tuple[Specimen, float]] = []
    squares = {"smooth": 0.0, "scale": 0.0}
    for kind, members in kinds.items():
        tests = [_Test.of(fit, k) for k in members]
        strain[kind], variance, weights = _conditional(tests)
        weight[kind] = variance * weights * np.concatenate([t.force for t in tests])
        parts = np.split(weights, np.cumsum([len(t.strain) for t in tests])[:-1])
        for k, test, part in zip(members, tests, parts, strict=True):
            specimen = problem.specimens[k]
            own = test.scale_variance * float(test.force @ part)
            scale.append((specimen, own))
            smooth = test.force * (_likeness(test.strain, strain[kind]) @ weight[kind])
            squares["smooth"] += float(np.mean(smooth**2)) / specimen.peak**2
            squares["scale"] += float(np.mean((own * test.force) ** 2)) / specimen.peak**2
    n = sum(map(len, kinds.values()))
    size = {k: float(np.sqrt(v / n)) for k, v in squares.items()}
    return Correction(strain, weight, by_specimen(scale), size)


@dataclass(frozen=True)
class _Test:
    """Means of one test: strain (n,), residual and force (n,) [N], noise and local (n, n) [N2].

    The force is what a change of the sample's force by its whole would add. The local part is as
    large as the smooth discrepancy, but goes a little way only.
    """

    strain: Array
    residual: Array
    force: Array
    noise: Array
    local: Array
    scale_variance: float

    @classmethod
    def of(cls, fit: Fit, k: int) -> "_Test":
        """Of one test of a fit."""
        problem = fit.problem
        specimen, w = problem.specimens[k], problem.whiteners[k].alone
        force = fit.model.predict(specimen, fit.state)
        double = fit.model.with_effect(_effect(lambda s, force, travel, values: 2.0 * force))
        state = fit.state.with_values(NAME, {})
        x = w.blocks(specimen.travel) / specimen.reach
        to = averaging(specimen, w)
        part = {name: v * w.kept(w.part(name)) for name, v in w.variances.items()}
        apart = w.kept(w.known) + part["rough"] + part["history"] + part["wander"]
        spread = np.sqrt(sum(np.diag(part[name]) for name in SIMILARITY))
        near = np.exp(-np.abs(np.subtract.outer(x, x)) / problem.settings.fine_length)
        return cls(
            to @ w.blocks(_strain(specimen, fit.model.travel(specimen, fit.state))),
            to @ w.blocks(specimen.force - force),
            to @ w.blocks(double.predict(specimen, state) - force),
            to @ apart @ to.T,
            to @ (np.outer(spread, spread) * near) @ to.T,
            w.variances["scale"] * (0.01 * problem.settings.scale_percent) ** 2,
        )


def _conditional(tests: list[_Test]) -> tuple[Array, float, Array]:
    """Strains (n,) of all tests of one kind, variance of the smooth part, and weights (n,).

    The weights [1/N] times a covariance with the residuals are the most likely value.
    """
    x = np.concatenate([t.strain for t in tests])
    residual = np.concatenate([t.residual for t in tests])
    force = np.concatenate([t.force for t in tests])
    shared = np.outer(force, force) * _likeness(x, x)
    scale = block_diag(*(t.scale_variance * np.outer(t.force, t.force) for t in tests))
    apart = block_diag(*(t.noise for t in tests)) + scale
    local = block_diag(*(t.local for t in tests))

    tried = (_most_likely(shared, apart + part * local, residual) for part in LOCAL)
    _, variance, weights = min(tried, key=lambda found: found[0])
    return x, variance, weights


def _most_likely(shared: Array, apart: Array, residual: Array) -> tuple[float, float, Array]:
    """Minus twice the log likelihood at the best variance of the shared part, that, and weights.

    With both covariances (n, n) diagonal at once it costs nothing to try a variance. Weights (n,)
    are the residual over its covariance.
    """
    apart = apart + 1e-9 * np.trace(apart + shared) / len(apart) * np.eye(len(apart))
    values, vectors = eigh(shared, apart)
    values, projected = values.clip(0.0), vectors.T @ residual
    constant = np.linalg.slogdet(apart)[1]

    def unlikely(log_variance: float) -> float:
        grown = 1.0 + np.exp(log_variance) * values
        return float(constant + np.log(grown).sum() + (projected**2 / grown).sum())

    found = minimize_scalar(unlikely, bounds=tuple(2.0 * np.log(SIZES)), method="bounded")
    grown = 1.0 + np.exp(found.x) * values
    return float(found.fun), float(np.exp(found.x)), np.asarray(vectors @ (projected / grown))


def _strain(specimen: Specimen, travel: Array) -> Array:
    """Nominal strain (n,) either way; a stroke counts as one where the height is not known."""
    return np.asarray(np.abs(travel) / (specimen.elastic.height or specimen.reach))


def _likeness(here: Array, there: Array) -> Array:
    """Matern's correlation 5/2 of strains: it goes on where the records end."""
    apart = np.sqrt(5.0) / LENGTH * np.abs(np.subtract.outer(here, there))
    return np.asarray((1.0 + apart + apart**2 / 3.0) * np.exp(-apart))
