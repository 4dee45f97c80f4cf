"""Joint least squares of material and effects on whitened records."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from softsample.loop.model import (
    CONTACT_ZERO,
    FIXED,
    FRACTION,
    SOFTEST,
    STIFFEST,
    Material,
    Model,
    Packing,
    State,
)
from softsample.loop.noise import SIMILARITY, NoiseSettings, Whitener, memory
from softsample.loop.specimen import AHEAD, FORCE, Array, Mask, Specimen, blocks

BRIEF = 0.03
"""Part of the time over which what an effect adds is alike, over which its corners are rounded: a
platen leaves a relaxed sample bit by bit. The likeliest of 0.005 to 0.05 for the records of U10."""

FRACTIONS = (0.0, 0.2, 0.5, 0.8, 0.95, 1.0)
"""Modulus fractions from which fits set out that know nothing, each with its own modulus: a far
end of the range may be a minimum of its own."""

FLAT = 12.0
"""Information of a flat prior over a range of length one."""

RANGES = (np.log(STIFFEST / SOFTEST), 1.0, 2.0)
"""Ranges of the packed ln(mu), fraction and contact-point offset; all others are one long."""

DIFFERENCE, OF_FRACTION = 1e-5, 0.01
"""Step of the packed parameters for derivatives, and that of the modulus fraction: interpolated
curves go with the root of what is left to 1, where their slope is infinite."""

SETTLED = 0.01
"""Fall of half the sum of squares over each of two steps that ends a fit: evidence counts from
tens of this on."""


@dataclass(frozen=True)
class Fit:
    """Result of a joint calibration.

    Parameters
    ----------
    model : Model
        Its effects.
    state : State
        Material and values at the optimum.
    cost : float
        Sum of squares of the white residual.
    white : (n,) float64
        White residual of all tests, one after the other, then that of what has a prior.
    jacobian : (n, p) float64
        Its derivative by the packed parameters.
    problem : Problem
        Records, and the noise that makes residual and derivative white.
    folds : dict of Fit
        The same model fitted to what a fold leaves, as far as that was asked for.
    """

    model: Model
    state: State
    cost: float
    white: Array
    jacobian: Array
    problem: "Problem" = field(repr=False)
    folds: "dict[str, Fit]" = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def residual(self) -> list[Array]:
        """Block means of measured less predicted force of every test (n,) [N]."""
        return self.problem.coloured(self.white[: self.problem.count])

    @property
    def missed(self) -> float:
        """Error of what is fitted, as a part of the peaks: RMS over the tests."""
        tests = zip(self.residual, self.problem.specimens, strict=True)
        return float(np.sqrt(np.mean([np.mean((r / s.peak) ** 2) for r, s in tests if len(r)])))

    @property
    def slopes(self) -> list[Array]:
        """Derivatives (n, p) [N] of that by the packed parameters."""
        return self.problem.coloured(self.jacobian[: self.problem.count])

    @property
    def flat(self) -> Array:
        """Information (p,) of flat priors of the packed parameters over their ranges."""
        prior = np.full(self.jacobian.shape[1], FLAT)
        prior[: len(RANGES)] /= np.square(RANGES)
        return prior

    @property
    def at_end(self) -> Mask:
        """Which packed parameters (p,) lie at an end of their range."""
        return Packing(self.model, self.problem.fractions).at_end(self.state)

    @property
    def misfit(self) -> float:
        """Twice the negative logarithm of its likelihood, up to a constant."""
        return self.problem.misfit(self.white)

    @property
    def information(self) -> Array:
        """Inverse of the covariance (p, p) of the packed parameters, Laplace's approximation."""
        return np.asarray(self.jacobian.T @ self.jacobian + np.diag(self.flat))

    @property
    def covariance(self) -> Array:
        """Covariance (p, p) of the packed parameters."""
        return np.asarray(np.linalg.inv(self.information))


@lru_cache(maxsize=16)  # the tests of a group
def _alike(specimen: Specimen, size: int) -> tuple[Array, Array]:
    """Correlations (n, n) between blocks of errors in the form of effects: long and brief ones."""
    clock, way = blocks(specimen.time, size), blocks(specimen.travel, size)
    apart = np.subtract.outer(clock, clock) / memory(specimen, size)
    further = np.subtract.outer(way, way) / (0.25 * specimen.reach)
    both = np.hypot(apart, further)
    long = np.mean([alike(both, 1.0) for alike in SIMILARITY.values()], axis=0)
    return np.asarray(long), np.exp(-0.5 * (apart / BRIEF) ** 2)


def _error_of_form(*parts: tuple[Array, Array]) -> Array:
    """Sum of covariances (n, n) [N2] of errors of given sizes (n,) [N] and correlations (n, n)."""
    first, *more = (np.outer(size, size) * alike for size, alike in parts)
    return np.asarray(sum(more, start=first))


def labels(specimens: Sequence[Specimen]) -> list[str]:
    """Modes of tests and their channels, with the sample where a mode has several tests."""
    kinds = [s.mode if s.channel == FORCE else f"{s.mode}_normal" for s in specimens]
    named = [
        kind if kinds.count(kind) == 1 else f"{kind}_{s.name}"
        for kind, s in zip(kinds, specimens, strict=True)
    ]
    counts = [named[: k + 1].count(name) for k, name in enumerate(named)]
    return [name if n == 1 else f"{name}_{n}" for name, n in zip(named, counts, strict=True)]


class _Ended:
    """Ends a least-squares fit that hardly falls any more, or cannot get below others.

    Parameters
    ----------
    wanted : float
        Sum of squares above which a fit is of no use.
    evaluations : int
        Of the residual, at most.
    """

    def __init__(self, wanted: float, evaluations: int) -> None:
        self._wanted, self._evaluations = 0.5 * wanted, evaluations
        self._costs = [np.inf, np.inf]

    def __call__(self, intermediate_result: OptimizeResult) -> None:
        """After a step."""
        cost, left = intermediate_result.cost, self._evaluations - intermediate_result.nfev
        fall = self._costs[0] - cost  # of two steps: one may be short
        if fall < 2.0 * SETTLED or cost - left * fall > self._wanted:
            raise StopIteration
        self._costs = [self._costs[1], cost]


@dataclass(frozen=True, eq=False)
class Problem:
    """Records of one group with their noise.

    Parameters
    ----------
    specimens : sequence of Specimen
        Tests that share their material and machine.
    whiteners : sequence of Whitener
        One for each.
    settings : NoiseSettings
        Sizes of the discrepancy, how far they may differ from these, and where compression begins.
    start : Material, optional
        From which fits of the plain model set out too.
    common : sequence of (n,) float64, optional
        One standard deviation, per sample of every test [N], of an error that all tests share.
    unseen : sequence of Specimen, optional
        Tests of which something is held out: what a fit is to predict. Their forces are not used.
    """

    specimens: Sequence[Specimen]
    whiteners: Sequence[Whitener]
    settings: NoiseSettings
    start: Material | None = None
    common: Sequence[Array] = ()
    unseen: Sequence[Specimen] = ()

    def __post_init__(self) -> None:
        if not self.common:
            nothing = [np.zeros_like(s.force) for s in self.specimens]
            object.__setattr__(self, "common", nothing)

    @cached_property
    def _joint(self) -> tuple[Array, Array, Array]:
        """Orthonormal directions (n, k) in which tests share errors, and their variance (k,).

        Last what whitening takes from a unit of each direction (n, k).
        """
        columns = np.column_stack([
            self._own_white(self.common), np.concatenate([w.in_common for w in self.whiteners])
        ])  # fmt: skip
        directions, sizes, _ = np.linalg.svd(columns, full_matrices=False)
        variance = 1.0 + sizes**2
        return directions, variance, (1.0 - 1.0 / np.sqrt(variance)) * directions

    def each(self, *more: Sequence[Any]) -> Iterator[tuple[Specimen, Whitener, *tuple[Any, ...]]]:
        """Every test with its whitener, and what more there is of each."""
        return zip(self.specimens, self.whiteners, *more, strict=True)

    @property
    def labels(self) -> list[str]:
        """Names of the tests."""
        return labels(self.specimens)

    @property
    def fractions(self) -> tuple[float, float]:
        """Least and largest r that the response curves of all tests hold."""
        ends = [specimen.elastic.curves.bounds for specimen in self.specimens]
        return max(low for low, _ in ends), min(high for _, high in ends)

    def with_forces(self, forces: Sequence[Array]) -> "Problem":
        """The same tests and noise with other forces (n,) [N], one per test."""
        specimens = [replace(s, force=f) for s, f in zip(self.specimens, forces, strict=True)]
        return replace(self, specimens=specimens)

    def with_own(self, **known: Mapping[str, float]) -> "Problem":
        """The same tests with what is their specimens' own, see `Specimen.with_own`."""
        tests = self.specimens, self.unseen
        specimens, unseen = ([s.with_own(**known) for s in some] for some in tests)
        return replace(self, specimens=specimens, unseen=unseen)

    def with_open_contact(self) -> "Problem":
        """The same if the height of the samples did not say where compression begins."""
        return replace(self, settings=replace(self.settings, contact_zero_mm=np.inf))

    def with_variances(self, variances: Mapping[str, float]) -> "Problem":
        """The same with other sizes of the discrepancy."""
        return replace(self, whiteners=[replace(w, variances=variances) for w in self.whiteners])

    def with_least(self, least: Mapping[str, float]) -> "Problem":
        """The same with sizes of the discrepancy of at least these."""
        here = self.variances
        return self.with_variances({name: max(least.get(name, 0.0), v) for name, v in here.items()})

    def white(self, parts: Sequence[Array]) -> Array:
        """White residual (n, ...) of all tests from one (n_samples, ...) per test."""
        own, (directions, _, less) = self._own_white(parts), self._joint
        return np.asarray(own - less @ (directions.T @ own))

    def coloured(self, white: Array) -> list[Array]:
        """Block means [N] of every test with this noise from independent unit noise (n, ...)."""
        directions, variance, _ = self._joint
        own = white + (np.sqrt(variance) - 1.0) * directions @ (directions.T @ white)
        return [w.coloured(part) for w, part in zip(self.whiteners, self.by_test(own), strict=True)]

    @property
    def variance(self) -> list[Array]:
        """Of the block means of every test [N2]."""
        return [
            w.variance + w.blocks(common) ** 2
            for w, common in zip(self.whiteners, self.common, strict=True)
        ]

    @property
    def count(self) -> int:
        """Number of blocks of all tests; entries of a white residual beyond are of priors."""
        return sum(int(w.keep.sum()) for w in self.whiteners)

    def by_test(self, white: Array) -> list[Array]:
        """Parts of a white residual (n,) that belong to each test."""
        return np.split(white, np.cumsum([w.keep.sum() for w in self.whiteners])[:-1])

    def _own_white(self, parts: Sequence[Array]) -> Array:
        """The same if tests shared nothing."""
        return np.concatenate([w(part) for w, part in zip(self.whiteners, parts, strict=True)])

    @cached_property
    def _fitted(self) -> list[Specimen]:
        """Every test as far as what comes later changes nothing in its blocks that count."""
        found = []
        for s, w in self.each():
            n = w.size * (int(np.flatnonzero(w.keep).max(initial=-1)) + 1)
            end = s.time[n - 1] + AHEAD if n else -np.inf
            found.append(s.until(int(np.searchsorted(s.time, end, side="right"))))
        return found

    def predicted(self, model: Model, state: State) -> list[Array]:
        """Predicted force of every test (n,) [N]; nothing once no block that counts follows."""
        return [self._predicted(model, state, k) for k in range(len(self.specimens))]

    def _predicted(self, model: Model, state: State, k: int) -> Array:
        """That of test `k`."""
        force, test = np.zeros(len(self.specimens[k].force)), self._fitted[k]
        if n := len(test.force):
            force[:n] = model.predict(test, state)
        return force

    def departure(self, fit: Fit, other: Fit) -> float:
        """How far two fits differ in what is held out: RMS, as a part of the other one's peaks."""
        squares = []
        for specimen in self.unseen:
            one, two = (f.model.predict(specimen, f.state) for f in (fit, other))
            peak = max(float(np.abs(two[specimen.held_out]).max()), 1e-300)
            squares.append(np.mean(np.square((one - two)[specimen.held_out] / peak)))
        return float(np.sqrt(np.mean(squares))) if squares else 0.0

    def white_changes(
        self, here: Sequence[Array], there: Sequence[Sequence[Array]], model: Model
    ) -> Array:
        """White changes (n, k) from one prediction to k others; priors of a model stay."""
        changes = [
            np.stack([changed[t] - before for changed in there], axis=1)
            for t, before in enumerate(here)
        ]
        return np.concatenate([self.white(changes), np.zeros((1 + len(model.known), len(there)))])

    @property
    def variances(self) -> Mapping[str, float]:
        """Sizes squared of the discrepancy over those of the settings, by part."""
        return self.whiteners[0].variances

    def misfit(self, white: Array) -> float:
        """Twice the negative logarithm of the likelihood of a white residual, up to a constant.

        With the prior of the sizes of the discrepancy.
        """
        own = sum(w.log_determinant for w in self.whiteners)
        shared = np.log(self._joint[1]).sum()
        return float(white @ white + own + shared + self._unlikely_sizes)

    @property
    def _unlikely_sizes(self) -> float:
        """Twice the negative logarithm of the prior of the sizes of the discrepancy."""
        if self.settings.spread <= 1.0:
            return 0.0
        sizes = 0.5 * np.log(list(self.variances.values())) / np.log(self.settings.spread)
        return float(sizes @ sizes)

    def residual(self, model: Model, state: State) -> Array:
        """White residual of a state, its last entries those of priors, the contact zero's first."""
        return self._left(model, self.predicted(model, state), state)

    def _left(self, model: Model, predicted: Sequence[Array], state: State) -> Array:
        """White residual of a state whose predictions are known."""
        parts = [s.force - force for s, force in zip(self.specimens, predicted, strict=True)]
        priors = [(state.values[e.name][p.name] - mean) / d for e, p, (mean, d) in model.known]
        zero = state.contact_zero / self.settings.contact_zero_mm
        return np.concatenate([self.white(parts), [zero, *priors]])

    def _beside(self, model: Model, here: Sequence[Array], state: State, k: int) -> list[Array]:
        """Predictions of a state that differs in entry `k` from one whose predictions are known."""
        effect = model.parameters[k - FIXED][0] if k >= FIXED else None
        return [
            force
            if (effect and s.kind not in effect.modes)
            or (k == CONTACT_ZERO and not s.elastic.contact)
            else self._predicted(model, state, j)
            for j, (s, force) in enumerate(zip(self.specimens, here, strict=True))
        ]

    def doubting(self, fit: Fit) -> "Problem":
        """The same with room for error in the form of a fit's last effect.

        A part of what it adds is alike over a quarter of the stroke and of the time that is fitted;
        besides, its corners may be rounded over the part `BRIEF` of that time.
        """
        without = fit.model.without(fit.model.names[-1])
        whiteners = []
        for specimen, whitener in self.each():
            added = fit.model.predict(specimen, fit.state) - without.predict(specimen, fit.state)
            part = blocks(added, whitener.size)
            long, brief = _alike(specimen, whitener.size)
            size = 0.01 * self.settings.form_percent * part
            rounded = brief @ part / brief.sum(axis=1) - part
            form = partial(_error_of_form, (size, long), (rounded, brief))
            whiteners.append(whitener.with_form(form))
        return replace(self, whiteners=whiteners)

    def fit(self, model: Model, start: State, starts: Sequence[State] = ()) -> Fit:
        """Best fit of material and effects, from one or several starts."""
        return min(self.fits(model, (start, *starts)), key=lambda fit: fit.cost)

    def fits(
        self,
        model: Model,
        starts: Sequence[State],
        tie: float = 0.0,
        enough: float = -np.inf,
        found: Sequence[Fit] = (),
    ) -> list[Fit]:
        """Fits from several starts, and those that were found before.

        One that cannot come within `tie` of the least sum of squares so far is given up; the
        first below `enough` is the last.
        """
        fits = list(found)
        for state in starts:
            least = min((fit.cost for fit in fits), default=np.inf)
            fits.append(self._fit_from(model, state, wanted=least + tie))
            if fits[-1].cost < enough:
                break
        return fits

    def at(self, model: Model, state: State) -> Fit:
        """A state as it is, as a fit."""
        return self._fit_from(model, state, evaluations=1)

    def _fit_from(
        self, model: Model, start: State, evaluations: int = 20, wanted: float = np.inf
    ) -> Fit:
        packing = Packing(model, self.fractions)
        margin = 1e-6 * (packing.high - packing.low)
        first = np.clip(packing.pack(start), packing.low + margin, packing.high - margin)

        latest: list[tuple[bytes, list[Array]]] = []  # slopes are asked for where residuals were

        def predicted(vector: Array) -> list[Array]:
            if not latest or latest[0][0] != vector.tobytes():
                forces = self.predicted(model, packing.unpack(vector))
                latest[:] = [(vector.tobytes(), forces)]
            return latest[0][1]

        def white(vector: Array) -> Array:
            return self._left(model, predicted(vector), packing.unpack(vector))

        def slope(vector: Array) -> Array:
            steps = np.where(vector + DIFFERENCE > packing.high, -DIFFERENCE, DIFFERENCE)
            back = vector[FRACTION] >= packing.low[FRACTION] + OF_FRACTION
            steps[FRACTION] = -OF_FRACTION if back else OF_FRACTION
            moved = [packing.unpack(vector + step) for step in np.diag(steps)]
            here = predicted(vector)
            there = [self._beside(model, here, state, k) for k, state in enumerate(moved)]
            slopes = -self.white_changes(here, there, model) / steps
            slopes[self.count, CONTACT_ZERO] = 1.0 / self.settings.contact_zero_mm
            for k, (effect, p, (_, deviation)) in enumerate(model.known, start=self.count + 1):
                place = FIXED + model.parameters.index((effect, p))
                slopes[k, place] = (p.high - p.low) / deviation
            return slopes

        found = least_squares(
            white, first, slope, bounds=(packing.low, packing.high), x_scale=0.1, method="trf",
            ftol=1e-5, xtol=1e-5, gtol=1e-6, max_nfev=evaluations,
            callback=_Ended(wanted, evaluations),
        )  # fmt: skip
        return Fit(
            model,
            packing.unpack(found.x),
            float(2.0 * found.cost),
            np.asarray(found.fun),
            np.asarray(found.jac),
            self,
        )

    def of_own_modulus(self, model: Model, state: State) -> State:
        """A state with the modulus that the records ask for, all else as it is."""
        predicted = self.white(self.predicted(model, state))
        measured = self.white([specimen.force for specimen in self.specimens])
        factor = float(predicted @ measured) / max(float(predicted @ predicted), 1e-300)
        mu = float(np.clip(state.material.mu * factor, SOFTEST, STIFFEST))
        return replace(state, material=replace(state.material, mu=mu))

    def of_each_fraction(self, model: Model, state: State) -> list[State]:
        """A state with each of `FRACTIONS` and the modulus that goes with it."""
        low, high = self.fractions
        materials = [
            replace(state.material, mu1_fraction=min(max(r, low), high)) for r in FRACTIONS
        ]
        return [self.of_own_modulus(model, replace(state, material=m)) for m in materials]

    def fit_material(self) -> Fit:
        """The plain model, from all starts: what only finds a better one explains nothing."""
        known = [State(self.start)] if self.start else []
        states = known + self.of_each_fraction(Model(), State(Material(1.0, 0.5)))
        return self.fit(Model(), states[0], states[1:])
