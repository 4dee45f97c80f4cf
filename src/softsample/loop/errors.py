"""Error of a model on the records: per mode and phase, and held out."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsample.loop.fit import Fit, Problem, labels
from softsample.loop.model import FIXED, State, residuals
from softsample.loop.noise import STILL, Noise
from softsample.loop.same_piece import same_piece
from softsample.loop.scale import Scales, scale_of
from softsample.loop.screen import LEAST_SIGNATURE, faint
from softsample.loop.specimen import Array, Mask, Specimen, blocks

TOUCHED = 0.1
"""Change by an effect of what a fold leaves out, over that of all, from which on it is touched."""

MOST_LEFT_OUT = 5
"""Folds that leave out tests, at most: each is a fit of all the others."""


@dataclass(frozen=True)
class Error:
    """Root mean square of block means.

    Parameters
    ----------
    rms, structured : float
        With and without the noise of the record [N].
    peak : float
        Largest measured force of the test [N].
    """

    rms: float
    structured: float
    peak: float

    def report(self) -> dict[str, float]:
        """In newton and percent of the peak."""
        return {
            "rms_N": self.rms,
            "rms_percent": 100.0 * self.rms / self.peak,
            "rms_N_structured": self.structured,
            "rms_percent_structured": 100.0 * self.structured / self.peak,
        }


Errors = Mapping[str, Mapping[str, Error]]
"""By two names, as fold and test, or test and phase."""


def error_of(residual: Array, noise: float, peak: float) -> Error:
    """Error of residuals (n,) [N] whose noise has a standard deviation [N]."""
    square = float(np.mean(residual**2))
    return Error(np.sqrt(square), float(np.sqrt(max(0.0, square - noise**2))), peak)


def phase_of_blocks(problem: Problem, k: int) -> NDArray[np.str_]:
    """Phase in which each block of test `k` begins."""
    whitener, phase = problem.whiteners[k], problem.specimens[k].phase
    starts = whitener.size * np.arange(len(phase) // whitener.size)
    return phase[starts]


def errors(fit: Fit, noises: Sequence[float]) -> dict[str, dict[str, Error]]:
    """Error of a fit by test and phase; `all` stands for the whole record."""
    problem = fit.problem
    parts = residuals(fit.model, problem.specimens, fit.state)
    report: dict[str, dict[str, Error]] = {}
    for k, (specimen, part) in enumerate(zip(problem.specimens, parts, strict=True)):
        means, phase = blocks(part, problem.whiteners[k].size), phase_of_blocks(problem, k)
        kept = problem.whiteners[k].keep
        choices = {"all": kept}
        choices |= {name: kept & (phase == name) for name in dict.fromkeys(phase[kept].tolist())}
        report[problem.labels[k]] = {
            name: error_of(means[chosen], noises[k], specimen.peak)
            for name, chosen in choices.items()
        }
    return report


def form_errors(fit: Fit, noises: Sequence[float]) -> tuple[float, float]:
    """Error of the form of the records [% of peak]: without noise, and whatever their scale.

    That of whole records, and that of a phase in which the platen moves if that is larger: a long
    rest repeats one force.
    """
    problem = fit.problem
    squares: dict[str, list[float]] = {}
    forces = problem.predicted(fit.model, fit.state)
    for k, (specimen, w, force, noise) in enumerate(problem.each(forces, noises)):
        left, model = w.blocks(specimen.force - force), w.blocks(force)
        left = left - model * (left @ model) / max(float(model @ model), 1e-300)
        phase = phase_of_blocks(problem, k)[w.keep]
        for name in ("all", *sorted({*phase} - {*STILL})):
            of_phase = left[(phase == name) | (name == "all")]
            error = error_of(of_phase, noise, specimen.peak).structured / specimen.peak
            squares.setdefault(name, []).append(error**2)
    found = {name: float(100.0 * np.sqrt(np.mean(of))) for name, of in squares.items()}
    return found["all"], max(found.values())


def repeat_error(fit: Fit) -> float:
    """Difference in scale of tests of one piece [%]: RMS about their means, 0 without repeats."""
    problem = fit.problem
    factors: dict[int | None, list[float]] = {}
    forces = problem.predicted(fit.model, fit.state)
    for specimen, w, force, piece in problem.each(forces, same_piece(problem.specimens)):
        model, measured = w.blocks(force), w.blocks(specimen.force)
        factor = float(measured @ model) / max(float(model @ model), 1e-300)
        factors.setdefault(piece, []).append(factor)
    apart = [np.var(of) / np.mean(of) ** 2 for piece, of in factors.items() if piece is not None]
    return float(100.0 * np.sqrt(np.mean(apart))) if apart else 0.0


def folds(problem: Problem) -> dict[str, list[Mask]]:
    """What each fold leaves out, blocks as one mask a test: a test, what follows the ramp, ...

    Of more than `MOST_LEFT_OUT` tests, several are left out together.
    """
    n = len(problem.specimens)
    phases = [phase_of_blocks(problem, k) for k in range(n)]
    kept = [whitener.keep for whitener in problem.whiteners]
    none = [np.zeros(len(phase), bool) for phase in phases]
    found = {}
    for k in range(min(n, MOST_LEFT_OUT) if n > 1 else 0):
        left_out = [j % MOST_LEFT_OUT == k for j in range(n)]
        name = "_and_".join(x for x, out in zip(problem.labels, left_out, strict=True) if out)
        found[f"leave_out_{name}"] = [
            own if out else mask for own, mask, out in zip(kept, none, left_out, strict=True)
        ]
    after = [
        np.isin(phase, ("hold", "unloading")) & own for phase, own in zip(phases, kept, strict=True)
    ]
    rest = any((own & ~mask).any() for own, mask in zip(kept, after, strict=True))
    if rest and all(mask.any() for mask in after):
        found["after_ramp"] = after
    last = []
    for k, specimen in enumerate(problem.specimens):
        travel = np.abs(blocks(specimen.travel, problem.whiteners[k].size))
        fitted = np.abs(specimen.travel[(specimen.phase == "ramp") & ~specimen.held_out])
        last.append(kept[k] & (phases[k] == "ramp") & (travel > 0.75 * fitted.max(initial=0.0)))
    return found | ({"last_quarter": last} if any(mask.any() for mask in last) else {})


@dataclass(frozen=True)
class Fold:
    """A model fitted to what a fold leaves.

    Parameters
    ----------
    masks : list of (n_blocks,) bool
        What it leaves out of each test.
    fit : Fit
        To the records without that.
    """

    masks: list[Mask]
    fit: Fit


def touched(fit: Fit, name: str) -> list[str]:
    """Folds that leave out what an effect of a fit changes, on the whole or more."""
    problem, without, parts = fit.problem, fit.model.without(name), []
    for specimen, w in problem.each():
        change = fit.model.predict(specimen, fit.state) - without.predict(specimen, fit.state)
        parts.append(blocks(change, w.size) / specimen.peak)
    kept = [part[w.keep] for part, w in zip(parts, problem.whiteners, strict=True)]
    usual = TOUCHED**2 * np.mean(np.square(np.concatenate(kept)))
    return [
        fold
        for fold, masks in folds(problem).items()
        if np.mean(np.square(np.concatenate([p[m] for p, m in zip(parts, masks, strict=True)])))
        > usual
    ]


def cross_validated(fit: Fit, names: Collection[str] | None = None) -> dict[str, Fold]:
    """The model of a fit, fitted to what each fold leaves; to those of some names, or to all.

    The noise of its problem has to allow for errors in the form of its effects.
    """
    problem, found = fit.problem, {}
    for name, masks in folds(problem).items():
        if names is not None and name not in names:
            continue
        if name not in fit.folds:
            kept = [w.on(w.keep & ~mask) for w, mask in zip(problem.whiteners, masks, strict=True)]
            rest, state = replace(problem, whiteners=kept), fit.state
            fewer = [
                state.with_values(e.name, {**state.values[e.name], **faint(e)})
                for e in fit.model.effects  # of which the rest may have none
            ]
            fit.folds[name] = rest.fit(fit.model, state, fewer)
        found[name] = Fold(masks, fit.folds[name])
    return found


def fold_errors(
    problem: Problem, found: Mapping[str, Fold], noises: Sequence[float]
) -> dict[str, dict[str, Error]]:
    """Error on what each fold leaves out, by fold and test.

    Sizes that the rest does not show are neutral, so that nothing of what was left out is known.
    """
    report = {}
    for name, fold in found.items():
        parts = residuals(fold.fit.model, problem.specimens, informed(fold.fit))
        report[name] = {
            label: error_of(blocks(part, w.size)[mask], noise, specimen.peak)
            for specimen, w, label, part, mask, noise in problem.each(
                problem.labels, parts, fold.masks, noises
            )
            if mask.any()
        }
    return report


def log_densities(fit: Fit, found: Mapping[str, Fold]) -> Array:
    """Logarithm of the predictive density of what each fold leaves out.

    Of what is left out given the rest: the evidence of all over that of the rest, each by
    Laplace's approximation. Parameters of effects have flat priors over their ranges. Where
    compression begins is measured too, by the height of the sample: it is left out last.
    """
    rests = [fold.fit for fold in found.values()]
    if any(specimen.elastic.contact for specimen in fit.problem.specimens):
        rests.append(fit.problem.with_open_contact().fit(fit.model, fit.state))
    every = _evidence(fit)
    return np.array([every - _evidence(rest) for rest in rests])


def _evidence(fit: Fit) -> float:
    """Logarithm of the evidence of a model, up to a constant of the model."""
    _, determinant = np.linalg.slogdet(fit.information)
    return -0.5 * (fit.misfit + float(determinant))


def white_of(problem: Problem, noises: Sequence[Noise]) -> dict[str, float]:
    """Standard deviation of a sample [N], by what the cell of a test measures; of most tests."""
    of: dict[str, list[float]] = {}
    for specimen, noise in zip(problem.specimens, noises, strict=True):
        of.setdefault(specimen.cell, []).append(noise.white)
    return {cell: float(np.median(whites)) for cell, whites in of.items()}


def held_out_errors(
    fit: Fit, specimens: Sequence[Specimen], noise: Mapping[str, float], scales: Scales
) -> dict[str, Error]:
    """Error of a fit on what is held out of tests, by test; percent are of its own peak.

    A specimen whose fitted records are stiffer than the model is so in what is held out too.

    Parameters
    ----------
    fit : Fit
        To what is not held out.
    specimens : sequence of Specimen
        All tests of the group.
    noise : mapping of float
        Standard deviation of a sample [N], by what the cell measures; none if unknown.
    scales : mapping
        Errors of the scale of what the fit predicts.
    """
    state, found = informed(fit), {}
    for label, specimen in zip(labels(specimens), specimens, strict=True):
        chosen = specimen.held_out
        if chosen.any():
            predicted = fit.model.predict(specimen, state)
            predicted = predicted * (1.0 + scale_of(specimen, scales))
            left = (specimen.force - predicted)[chosen]
            peak = float(np.abs(specimen.force[chosen]).max())
            found[label] = error_of(left, noise.get(specimen.cell, 0.0), peak)
    return found


def informed(fit: Fit) -> State:
    """State of a fit with sizes neutral whose whole range would not show in its records."""
    values = {name: dict(of) for name, of in fit.state.values.items()}
    shown = np.linalg.norm(fit.jacobian[:, FIXED:], axis=0) >= LEAST_SIGNATURE
    for (effect, p), seen in zip(fit.model.parameters, shown, strict=True):
        if p.is_size and not seen:
            values[effect.name][p.name] = p.neutral
    return replace(fit.state, values=values)
