"""What no named effect explains, as a smooth function of the travel: a correction, not a cause.

Tests of one mode share it in proportion to their force, as they would another elastic law, and the
scale of each test is its own. A mode is corrected only if that is confirmed: if it takes a fifth of
the error of parts of the records that were left out when it was learned.

References
----------
C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cho_factor, cho_solve
from scipy.optimize import minimize_scalar

from softsample.loop.discrepancy import averaging
from softsample.loop.effects.base import Effect, Values
from softsample.loop.errors import Fold, fold_errors
from softsample.loop.fit import Fit, Problem
from softsample.loop.model import Material, Model, State
from softsample.loop.scale import Scales, by_specimen, most_likely, scale_of
from softsample.loop.specimen import Specimen

Array = NDArray[np.float64]
Kind = tuple[str, str]

NAME = "correction"
"""Of the effect that stands for it in a model."""

LAST = "last_quarter"
"""Fold that leaves out the end of the stroke of every test."""

CONFIRMED = 0.8
"""Part of the error of what was left out that may be left, if a correction is given."""

ONSET = 0.02
"""Part of the stroke over which it sets in."""

SIZES = (1e-3, 10.0)
"""Its standard deviation, as a part of the force, lies between these."""

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
    travel, weight : dict of (n,) float64
        Of each mode and channel, where it was learned [parts of the stroke], and its weights.
    unit, common : dict of float
        Of each mode and channel, the longest stroke of a test, and the shortest one [m].
    scale : dict of float
        Error of the scale of what was fitted, by specimen, mode and channel, as a part.
    size : dict of float
        RMS of the smooth part and of the scale in what was fitted, as parts of the peak.
    material : Material
        Of the model that it corrects.
    """

    travel: Mapping[Kind, Array]
    weight: Mapping[Kind, Array]
    unit: Mapping[Kind, float]
    common: Mapping[Kind, float]
    scale: Scales
    size: Mapping[str, float]
    material: Material

    def apply(self, specimen: Specimen, force: Array, travel: Array, values: Values) -> Array:
        """Corrected force (n,) [N] of any test."""
        kind = _kind(specimen)
        if kind not in self.unit:
            return force
        x = travel / self.unit[kind]
        strength = _strength(specimen, self.material, self.common[kind])
        smooth = _onset(x) * (_likeness(x, self.travel[kind]) @ self.weight[kind])
        return np.asarray(force * (1.0 + scale_of(specimen, self.scale)) + strength * smooth)

    def only(self, kinds: Collection[Kind]) -> Self:
        """Of some modes and channels alone."""
        return replace(self, unit={k: unit for k, unit in self.unit.items() if k in kinds})

    @property
    def effect(self) -> Effect:
        """It as the last effect of a model."""
        return Effect(NAME, "Correction", (), "P", __name__, "smooth in the travel",
                      tissue=self.apply)  # fmt: skip

    def of(self, fit: Fit) -> Fit:
        """A fit with it."""
        state = replace(fit.state, values={**fit.state.values, NAME: {}})
        return replace(fit, model=fit.model.with_effect(self.effect), state=state)


@dataclass(frozen=True)
class Confirmed:
    """What predicts best what is not measured, and how it did on what was left out.

    Parameters
    ----------
    problem : Problem
        The records.
    fit : Fit
        Of a model to them.
    learned : Correction or None
        Of that model; none if it is best as it is.
    folds : dict of Fold
        The models of the folds, each with a correction that was learned from its rest.
    error_before, error_after : float
        Error of what these leave out, of the first model that was tried and of this [% of peak].
    """

    problem: Problem
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
        corrected = self.learned.unit if self.learned else {}
        found = most_likely(self.problem, self.fit)
        return {key: error for key, error in found.items() if key[1:] not in corrected}

    @property
    def kind(self) -> str:
        """Class of what it corrects."""
        if self.learned is None:
            return _stage(self.fit.model.effects[0])
        if self.learned.size["smooth"] >= self.learned.size["scale"]:
            return "elastic_form"
        modes = [s.mode for s in self.problem.specimens]
        return "mode_ratio" if len(set(modes)) == len(modes) else "specimen_stiffness"

    def report(self) -> dict[str, Any]:
        """What `verdict.json` holds."""
        return {
            "class": self.kind,
            "smooth_part": self.learned is not None,
            "with": list(self.fit.model.names),
            "domain_mm": {
                label: float(1e3 * np.abs(s.travel[~s.held_out]).max(initial=0.0))
                for label, s in zip(self.problem.labels, self.problem.specimens, strict=True)
                if self.learned is None or _kind(s) in self.learned.unit
            },
            "left_out_before_percent": self.error_before,
            "left_out_after_percent": self.error_after,
            "separating_experiment": EXPERIMENTS[self.kind],
        }


def _stage(effect: Effect) -> str:
    """Class of what an effect stands for, if it is not taken for the cause."""
    if effect.crosses:
        return "cross_talk"
    if effect.only_instrument:
        return "drift"
    if effect.shifts_travel:
        return "zero"
    return "elastic_form" if effect.acts_on_law else "history"


def confirmed(
    models: Sequence[tuple[Problem, Fit, Mapping[str, Fold]]], noises: Sequence[float]
) -> Confirmed | None:
    """What predicts best what folds leave out; none if it is not far better than the first model.

    What is no more than the stated floor is not corrected.

    Parameters
    ----------
    models : sequence of (problem, fit, folds)
        Records, what was fitted to them, and the same fitted to what each fold leaves.
    noises : sequence of float
        Standard deviation of a block of each test [N].
    """
    found: list[Confirmed] = []
    reference = np.inf
    for place, (problem, fit, folds) in enumerate(models):
        told = [name for name, fold in folds.items() if _can_tell(problem, name, fold)]
        known = {name: learned(fold.problem, fold.fit) for name, fold in folds.items()}
        bare = _squares(problem, folds, told, noises)
        after = _squares(problem, _corrected(folds, known), told, noises)
        held = [kind for kind in bare if after[kind] <= CONFIRMED**2 * bare[kind]]
        corrected = _corrected(folds, {name: one.only(held) for name, one in known.items()})
        if place == 0:
            reference = _rms(bare)
            if reference <= problem.settings.floor_percent:
                return None
        else:
            found.append(Confirmed(problem, fit, None, folds, reference, _rms(bare)))
        left = _rms(_squares(problem, corrected, told, noises))
        own = learned(problem, fit).only(held)
        found.append(Confirmed(problem, fit, own, corrected, reference, left))
    best = None
    for one in found:  # the least changed first: another has to be far better than it
        if one.error_after <= CONFIRMED * (best.error_after if best else reference):
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


def _squares(
    problem: Problem, folds: Mapping[str, Fold], told: Sequence[str], noises: Sequence[float]
) -> dict[Kind, float]:
    """Sum of squares of the error of what folds leave out, by mode and channel [parts of peaks]."""
    kinds = {name: _kind(s) for name, s in zip(problem.labels, problem.specimens, strict=True)}
    found: dict[Kind, float] = {}
    for tests in fold_errors(problem, {name: folds[name] for name in told}, noises).values():
        for label, error in tests.items():
            kind = kinds[label]
            found[kind] = found.get(kind, 0.0) + (error.structured / error.peak) ** 2
    return found


def _rms(squares: Mapping[Kind, float]) -> float:
    """Root of the mean over modes and channels [%]."""
    return float(100.0 * np.sqrt(np.mean(list(squares.values())))) if squares else np.inf


def _kind(specimen: Specimen) -> Kind:
    return specimen.mode, specimen.channel


def learned(problem: Problem, fit: Fit) -> Correction:
    """The most likely correction of a fit: a conditional mean of Gaussian processes."""
    kinds: dict[Kind, list[int]] = {}
    for k, (s, w) in enumerate(zip(problem.specimens, problem.whiteners, strict=True)):
        if w.keep.any():
            kinds.setdefault(_kind(s), []).append(k)
    material = fit.state.material
    travel, weight, unit, common = {}, {}, {}, {}
    scale: list[tuple[Specimen, float]] = []
    squares = {"smooth": 0.0, "scale": 0.0}
    for kind, members in kinds.items():
        strokes = [problem.specimens[k].reach for k in members]
        unit[kind], common[kind] = max(strokes), (1.0 + 1e-6) * min(strokes)
        tests = [_Test.of(problem, fit, k, unit[kind], common[kind]) for k in members]
        travel[kind], weights = _conditional(tests)
        weight[kind] = weights * np.concatenate([t.strength * _onset(t.travel) for t in tests])
        parts = np.split(weights, np.cumsum([len(t.travel) for t in tests])[:-1])
        for k, test, part in zip(members, tests, parts, strict=True):
            specimen = problem.specimens[k]
            own = test.scale_variance * float(test.force @ part)
            scale.append((specimen, own))
            smooth = test.strength * _onset(test.travel)
            smooth = smooth * (_likeness(test.travel, travel[kind]) @ weight[kind])
            squares["smooth"] += float(np.mean(smooth**2)) / specimen.peak**2
            squares["scale"] += float(np.mean((own * test.force) ** 2)) / specimen.peak**2
    n = sum(map(len, kinds.values()))
    size = {k: float(np.sqrt(v / n)) for k, v in squares.items()}
    return Correction(travel, weight, unit, common, by_specimen(scale), size, material)


@dataclass(frozen=True)
class _Test:
    """Means of one test: travel (n,) [strokes], residual and force (n,) [N], noise (n, n) [N2]."""

    travel: Array
    residual: Array
    force: Array
    noise: Array
    strength: float
    scale_variance: float

    @classmethod
    def of(cls, problem: Problem, fit: Fit, k: int, unit: float, common: float) -> "_Test":
        """Of one test of a problem."""
        specimen, w = problem.specimens[k], problem.whiteners[k]
        force = fit.model.predict(specimen, fit.state)
        to = averaging(w.blocks(specimen.travel) / specimen.reach)
        apart = w.kept(w.known) + w.variances["rough"] * w.kept(w.discrepancy["rough"])
        return cls(
            to @ w.blocks(fit.model.travel(specimen, fit.state)) / unit,
            to @ w.blocks(specimen.force - force),
            to @ w.blocks(force),
            to @ apart @ to.T,
            _strength(specimen, fit.state.material, common),
            w.variances["scale"] * (0.01 * problem.settings.scale_percent) ** 2,
        )


def _conditional(tests: list[_Test]) -> tuple[Array, Array]:
    """Travels (n,) of all tests of one kind, and weights (n,) of the smooth part there."""
    x = np.concatenate([t.travel for t in tests])
    residual = np.concatenate([t.residual for t in tests])
    own = block_diag(*(t.noise + t.scale_variance * np.outer(t.force, t.force) for t in tests))
    along = np.concatenate([t.strength * _onset(t.travel) for t in tests])
    smooth = np.outer(along, along) * _likeness(x, x)
    own += 1e-9 * np.trace(own + smooth) / len(x) * np.eye(len(x))

    def unlikely(log_variance: float) -> float:
        factor = cho_factor(np.exp(log_variance) * smooth + own, lower=True)
        fitted = float(residual @ cho_solve(factor, residual))
        return 2.0 * float(np.log(np.diag(factor[0])).sum()) + fitted

    ends = 2.0 * np.log(SIZES)
    variance = np.exp(minimize_scalar(unlikely, bounds=tuple(ends), method="bounded").x)
    factor = cho_factor(variance * smooth + own, lower=True)
    return x, variance * cho_solve(factor, residual)


def _strength(specimen: Specimen, material: Material, common: float) -> float:
    """Largest force of the plain model up to the travel that all tests of a kind reach [N]."""
    force = Model().predict(specimen, State(material))
    return float(np.abs(force[np.abs(specimen.travel) <= common]).max(initial=0.0))


def _onset(travel: Array) -> Array:
    """Nothing where the platen has not moved [parts of the stroke]."""
    return np.asarray(np.clip(np.abs(travel) / ONSET, 0.0, 1.0))


def _likeness(here: Array, there: Array) -> Array:
    """Matern's correlation 5/2 over the stroke: it goes on where the records end."""
    apart = np.sqrt(5.0) * np.abs(np.subtract.outer(here, there))
    return np.asarray((1.0 + apart + apart**2 / 3.0) * np.exp(-apart))
