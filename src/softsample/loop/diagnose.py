"""From the tests of one group to a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from softsample.loop.effects import library
from softsample.loop.effects.base import Effect
from softsample.loop.errors import Error, errors, held_out
from softsample.loop.fit import Fit, Problem
from softsample.loop.limits import detection_limits
from softsample.loop.model import FIXED
from softsample.loop.noise import (
    Noise,
    NoiseSettings,
    Whitener,
    block_size,
    covariance,
    measure_noise,
    shared,
)
from softsample.loop.resample import confidence
from softsample.loop.select import Selection, SelectionSettings, select
from softsample.loop.specimen import Specimen, blocks

Array = NDArray[np.float64]
Errors = Mapping[str, Mapping[str, Error]]

PER_BLOCK = 4
"""Points of a block at which predictions are computed."""

NINETY = 1.6449
"""Standard deviations of a two-sided 90 % interval."""


@dataclass(frozen=True)
class LoopSettings:
    """Mirrors config `loop:`."""

    noise: NoiseSettings = field(default_factory=NoiseSettings)
    selection: SelectionSettings = field(default_factory=SelectionSettings)

    @classmethod
    def of_config(
        cls, loop: Mapping[str, Mapping[str, Any]], noise: Mapping[str, Any] | None = None
    ) -> Self:
        """From the config's section `loop`; `noise` has what differs there."""
        return cls(
            NoiseSettings(**{**loop["noise"], **(noise or {})}),
            SelectionSettings(**loop["selection"]),
        )


@dataclass(frozen=True)
class Diagnosis:
    """Everything that is known of one group after the loop.

    Parameters
    ----------
    problem : Problem
        Records and their noise.
    noises : list of Noise
        One for each test.
    selection : Selection
        The path to the verdict.
    verdict : str
        `explained`, `none` or `unknown`.
    before, after : dict
        Error by mode and phase.
    held_out_before, held_out_after : dict
        Error by fold and mode.
    """

    problem: Problem
    noises: list[Noise]
    selection: Selection
    verdict: str
    before: Errors
    after: Errors
    held_out_before: Errors
    held_out_after: Errors

    @property
    def final(self) -> Fit:
        """What is reported after: an explanation that does not hold is no better than none."""
        return self.selection.base if self.verdict == "unknown" else self.selection.final

    def confidence(self, settings: LoopSettings, draws: int) -> float | None:
        """How often the first effect's class is found again; none without effect or draws."""
        if draws == 0 or self.verdict != "explained":
            return None
        return confidence(
            self.problem, self.selection, self.selection.library, settings.selection, draws
        )


def pose(specimens: Sequence[Specimen], settings: NoiseSettings) -> tuple[Problem, list[Noise]]:
    """The records with their noise; its floor needs a first fit of the material.

    The problem works with `PER_BLOCK` means of samples in a block, which say as much.
    """
    noises = shared([measure_noise(specimen, settings) for specimen in specimens])
    specimens = [
        specimen.reduced(max(1, noise.size // PER_BLOCK))
        for specimen, noise in zip(specimens, noises, strict=True)
    ]
    nothing = [np.zeros_like(s.force) for s in specimens]
    whiteners = _whiteners(specimens, noises, nothing, settings)
    rough = Problem(specimens, whiteners, settings.contact_zero_mm).fit_material()
    material = rough.state.material
    travels = [rough.model.travel(s, rough.state) for s in specimens]
    predicted = [rough.model.predict(s, rough.state) for s in specimens]
    whiteners = _whiteners(specimens, noises, predicted, settings)
    lower = [
        material.mu
        * s.elastic.ratio_change_per_mu(
            material.mixture, travel, s.elastic.poisson_ratio - settings.poisson_ratio
        )
        for s, travel in zip(specimens, travels, strict=True)
    ]
    return Problem(specimens, whiteners, settings.contact_zero_mm, material, lower), noises


def _whiteners(
    specimens: Sequence[Specimen],
    noises: Sequence[Noise],
    models: Sequence[Array],
    settings: NoiseSettings,
) -> list[Whitener]:
    """Whitener of every test, its scale by what a model predicts per sample [N]."""
    sizes = [block_size(s.time, settings) for s in specimens]
    return [
        Whitener(covariance(s, noise, blocks(model, size), settings), size)
        for s, noise, model, size in zip(specimens, noises, models, sizes, strict=True)
    ]


def diagnose(
    specimens: Sequence[Specimen],
    settings: LoopSettings,
    effects: Sequence[Effect] | None = None,
) -> Diagnosis:
    """Find the residual, trace it to effects, add them, and measure the error before and after.

    Parameters
    ----------
    specimens : sequence of Specimen
        Tests that share their material and machine.
    settings : LoopSettings
        Noise, floor and rules of the selection.
    effects : sequence of Effect, optional
        Library to choose from; all by default.
    """
    problem, noises = pose(specimens, settings.noise)
    known = list(library().values()) if effects is None else list(effects)
    selection = select(problem, known, settings.selection)
    base, final = selection.base, selection.final
    spread = [noise.block for noise in noises]
    before, after = errors(problem, base, spread), errors(problem, final, spread)
    held_out_before = held_out(problem, base, spread)
    verdict = _verdict(selection, settings.selection)
    explained = verdict == "explained"
    return Diagnosis(
        problem,
        noises,
        selection,
        verdict,
        before,
        after if explained else before,
        held_out_before,
        held_out(selection.problem, final, spread) if explained else held_out_before,
    )


def _verdict(selection: Selection, rules: SelectionSettings) -> str:
    """What is missing.

    An explanation that leaves the records further off than floor and doubt of its form allow is
    none. Nor is one to which the records ask loudly for something more that no effect serves.
    """
    n = len(selection.final.white)
    left, before = selection.final.cost, selection.base.cost
    if left / n > rules.unknown_ratio and left - n > rules.unknown_share * (before - n):
        return "unknown"
    if selection.problem.spoiled(selection.base, selection.final):
        return "unknown"
    if selection.unserved and left / n > rules.unserved_ratio:
        return "unknown"
    return "explained" if selection.final.model.effects else "none"


def report(diagnosis: Diagnosis, settings: LoopSettings) -> dict[str, Any]:
    """What `verdict.json` holds."""
    limits = detection_limits(diagnosis.problem, diagnosis.selection)
    found = judgement(diagnosis, settings)
    unseen = {e.name for e in diagnosis.selection.library} - set(limits)
    return {
        **found,
        "not_identifiable": sorted({*found["not_identifiable"], *unseen}),
        "detection_limits": {
            e.name: _first_size(e, limits[e.name])
            for e in diagnosis.selection.library
            if e.name in limits
        },
    }


def _first_size(effect: Effect, multiple: float) -> dict[str, float | str]:
    """Distance of the first size from its neutral value at a multiple of the nominal one."""
    first = next(p for p in effect.sizes if p.nominal != p.neutral)
    return {"value": multiple * abs(first.nominal - first.neutral), "unit": first.unit}


def judgement(diagnosis: Diagnosis, settings: LoopSettings) -> dict[str, Any]:
    """What `verdict.json` holds, but for the sizes that would have been seen."""
    selection, final = diagnosis.selection, diagnosis.final
    mixtures = diagnosis.problem.mixtures
    return {
        "verdict": diagnosis.verdict,
        "effects": [
            _effect_report(effect, selection, settings.selection.form_doubt)
            for effect in final.model.effects
        ],
        "theta_before": _theta(selection.base, settings.noise, mixtures),
        "theta_after": _theta(final, settings.noise, mixtures),
        "error_before": _report(diagnosis.before),
        "error_after": _report(diagnosis.after),
        "held_out_before": _report(diagnosis.held_out_before),
        "held_out_after": _report(diagnosis.held_out_after),
        "noise": {
            label: {
                "white_N": n.white,
                "slow_N": n.slow,
                "grain_percent": 100.0 * specimen.elastic.grain,
            }
            for label, n, specimen in zip(
                diagnosis.problem.labels, diagnosis.noises, diagnosis.problem.specimens, strict=True
            )
        },
        "floor": asdict(settings.noise),
        "white_mean_square": {
            "before": selection.base.cost / len(selection.base.white),
            "after": final.cost / len(final.white),
        },
        "path": [
            {
                "threshold": step.threshold,
                "chosen": step.chosen.name if step.chosen else None,
                "candidates": [
                    {
                        "name": c.name,
                        "gain": c.gain,
                        "evidence": c.evidence,
                        "cosine": c.cosine,
                        "values": c.fit.state.values[c.name],
                    }
                    for c in step.candidates
                ],
            }
            for step in selection.steps
        ],
        "not_identifiable": sorted(
            {*selection.weak, *(e.name for e in library().values() if not e.identifiable)}
        ),
    }


def _report(found: Errors) -> dict[str, Any]:
    return {
        name: {part: error.report() for part, error in parts.items()}
        for name, parts in found.items()
    }


def _theta(
    fit: Fit, noise: NoiseSettings, mixtures: tuple[float, float]
) -> dict[str, dict[str, float | str]]:
    """Material with 90 % intervals; the scale of a test can be that of all of them."""
    deviation = np.sqrt(np.diag(fit.covariance))
    deviation[0] = np.hypot(deviation[0], 0.01 * noise.scale_percent)
    mu, r = fit.state.material.mu, fit.state.material.mixture
    return {
        "mu": {
            "value": mu,
            "unit": "Pa",
            "low": mu * float(np.exp(-NINETY * deviation[0])),
            "high": mu * float(np.exp(NINETY * deviation[0])),
        },
        "mu1_fraction": {
            "value": r,
            "unit": "1",
            "low": max(mixtures[0], r - NINETY * float(deviation[1])),
            "high": min(mixtures[1], r + NINETY * float(deviation[1])),
        },
    }


def _effect_report(effect: Effect, selection: Selection, doubt: float) -> dict[str, Any]:
    """Sizes with 90 % intervals: of the fit, and of an error of form that is a part of the size."""
    final = selection.final
    deviation = np.sqrt(np.diag(final.covariance))[FIXED:]
    deviation[~final.jacobian[:, FIXED:].any(axis=0)] = np.inf  # nothing in the records shows it
    unit = {
        (e.name, p.name): float(d) * (p.high - p.low)
        for (e, p), d in zip(final.model.parameters, deviation, strict=True)
    }
    chosen = [
        step.chosen for step in selection.steps if step.chosen and step.chosen.name == effect.name
    ][-1]  # one that was dropped can come back
    parameters = {}
    for p in effect.parameters:
        value = final.state.values[effect.name][p.name]
        spread = np.hypot(unit[effect.name, p.name], doubt * abs(value - p.neutral))
        parameters[p.name] = {
            "value": value,
            "unit": p.unit,
            "low": max(p.low, value - NINETY * spread),
            "high": min(p.high, value + NINETY * spread),
        }
    return {
        "name": effect.name,
        "class": selection.classes[effect.name],
        "parameters": parameters,
        "evidence": chosen.evidence,
        "separating_experiment": effect.experiment,
    }
