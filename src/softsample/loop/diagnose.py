"""From the tests of one group to a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from softsample.loop.accept import Judged, objection_to
from softsample.loop.average import (
    Weighed,
    averaged,
    bond_deviation,
    log_modulus_deviation,
    weighed,
)
from softsample.loop.correction import Confirmed, confirmed, learned
from softsample.loop.effects import ends, library, specimen_stiffness
from softsample.loop.effects.base import Effect
from softsample.loop.errors import (
    Errors,
    Fold,
    cross_validated,
    errors,
    fold_errors,
    form_error,
    held_out_errors,
    log_density,
    repeat_error,
)
from softsample.loop.fit import Fit, Problem
from softsample.loop.limits import detection_limits
from softsample.loop.model import FIXED
from softsample.loop.noise import (
    FORM,
    Noise,
    NoiseSettings,
)
from softsample.loop.pool import Group, Others, Pooled, pooled
from softsample.loop.posed import LoopSettings, Posed
from softsample.loop.resample import confidence
from softsample.loop.scale import Scales, most_likely
from softsample.loop.select import (
    Candidate,
    Selection,
    Step,
    doubted,
    misfit_with_penalties,
    select,
    unusable,
)
from softsample.loop.specimen import Specimen

Array = NDArray[np.float64]

HELD_OUT = "held_out"
"""Fold of what a study holds out."""

ENDS = ends.EFFECT.name
"""Effect that stands for the model of sliding ends."""

STIFFNESS = specimen_stiffness.EFFECT.name
"""Effect that stands for what scattered specimens differ in."""

SHOWN = 0.005
"""Weight of a model, or change of the modulus, as a part, from which on it is named."""

NINETY = 1.6449
"""Standard deviations of a two-sided 90 % interval."""


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
    objection : str
        Why the selected effects do not hold as an explanation, or why nothing explains what is
        left; empty if there is no objection.
    stiffness : mapping of float
        Modulus of specimens over that of the group where they scatter; empty if not.
    first : tuple of Problem, Fit
        Records and plain model of one stiffness.
    before : Judged
        Errors of that.
    plain : Judged
        Errors of the plain model with the stiffness of each specimen.
    selected : Judged
        Errors with the selected effects, whether or not they are given.
    refused : Judged or None
        Errors with what the records ask for next, if it is not given.
    correction : Confirmed or None
        What folds confirm of what is left, if anything: a correction, not a cause.
    corrected : Judged or None
        Errors with it.
    told : Pooled or None
        What the other groups of the study have chosen, if the effects are theirs.
    slides : bool
        Whether the model is that of sliding ends, in place of the study's bonded ones.
    other_ends : Diagnosis or None
        That of the other ends, if the study leaves them open.
    slid : float
        Evidence of the other groups for sliding ends.
    """

    problem: Problem
    noises: list[Noise]
    selection: Selection
    objection: str
    stiffness: Mapping[str, float]
    first: tuple[Problem, Fit]
    before: Judged
    plain: Judged
    selected: Judged
    refused: Judged | None = None
    correction: Confirmed | None = None
    corrected: Judged | None = None
    told: Pooled | None = None
    slides: bool = False
    other_ends: "Diagnosis | None" = None
    slid: float = 0.0

    @property
    def origin(self) -> "Diagnosis":
        """The one whose plain model is the calibrated one, of bonded ends if they are open."""
        return self.other_ends if self.slides and self.other_ends else self

    @property
    def shows_sliding(self) -> bool:
        """Whether these records and those of the other groups show that open ends slide."""
        evidence = self.origin.left - self.left + self.slid
        return self.slides and (bool(self.told) or evidence >= self.selection.steps[0].threshold)

    @property
    def verdict(self) -> str:
        """`explained`, `explained_class`, `none` or `unknown`."""
        if self.objection:
            return "explained_class" if self.correction else "unknown"
        named = self.selection.classes or self.stiffness or self.shows_sliding
        return "explained" if named else "none"

    @property
    def after(self) -> Judged:
        """Errors of what is reported."""
        if self.corrected:
            return self.corrected
        return self.plain if self.objection else self.selected

    @property
    def final(self) -> Fit:
        """What is reported after: an explanation that does not hold is no better than none."""
        if self.correction:
            return self.correction.fit
        return self.selection.base if self.objection else self.selection.final

    @property
    def predicting(self) -> Fit:
        """What predicts best what is not measured: `final`, with a correction that holds."""
        return self.correction.whole if self.correction else self.final

    @cached_property
    def left(self) -> float:
        """Misfit of what is reported, with the penalties for effects and single specimens.

        Errors of geometry and mesh may look like other ends, so they are as large as is doubted.
        """
        plain = self.selection.plain, self.selection.base
        found = plain if self.objection else (self.selection.problem, self.selection.final)
        specimens = max(0, len(self.stiffness) - 1) * float(np.log(len(self.final.white)))
        return misfit_with_penalties(*doubted(*found)) + specimens

    @property
    def of_ends(self) -> "list[tuple[Diagnosis, float]]":
        """Diagnoses of both ends if they are open, the reported one first, with probabilities."""
        if self.other_ends is None or self.told:
            return [(self, 1.0)]
        against = self.other_ends.left - self.left + (self.slid if self.slides else -self.slid)
        part = float(expit(0.5 * against))
        return [(self, part), (self.other_ends, 1.0 - part)]

    @property
    def rest(self) -> Mapping[str, float]:
        """By mode, the modulus at small strain that what is left asks for, over that of `final`.

        What folds confirm of it or, where they confirm nothing, what is likeliest; empty where
        what is left is no objection.
        """
        if not self.objection:
            return {}
        plain = self.selection.plain, self.selection.base
        found = self.correction.learned if self.correction else learned(*plain)
        return found.of_modulus if found else {}

    @property
    def scales_before(self) -> Scales:
        """Errors of the scale of what the model of one stiffness predicts."""
        return {} if self.stiffness else most_likely(*self.first)

    @property
    def scales(self) -> Scales:
        """Errors of the scale of what `predicting` predicts."""
        if self.correction:
            return self.correction.scales
        posed = self.selection.plain if self.objection else self.selection.problem
        return most_likely(posed, self.final)

    def confidence(self, settings: LoopSettings, draws: int) -> float | None:
        """How often the first effect's class is found again; none without effect or draws."""
        if draws == 0 or self.objection or self.told or not self.selection.classes:
            return None
        return confidence(
            self.problem, self.selection, self.selection.library, settings.selection, draws
        )


def diagnose(
    specimens: Sequence[Specimen],
    settings: LoopSettings,
    effects: Sequence[Effect] | None = None,
    others: Others | None = None,
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
    others : Others, optional
        The other groups of the study, if all that was measured of them is known.
    """
    known = list(library(tests=specimens).values()) if effects is None else list(effects)
    posed = Posed.of(specimens, settings)
    problem, noises, first, stiffness = posed.problem, posed.noises, posed.first, posed.stiffness
    if stiffness:
        known = [effect for effect in known if effect.name != STIFFNESS]
    selection, told = select(problem, known, settings.selection), None
    if others:
        own = Group.of(posed, posed, known)
        told = pooled(own, others, selection.asked, settings.selection)
        selection = _told(selection, told) if told else selection
    judged = _Judge(posed.specimens, noises)
    plain, chosen = (selection.plain, selection.base), (selection.problem, selection.final)
    models = [plain, chosen] if selection.classes else [plain]
    folds = [cross_validated(*model) for model in models]
    rest, *more = (
        judged(*model, of, most_likely(*model)) for model, of in zip(models, folds, strict=True)
    )
    before = judged(*first, cross_validated(*first), {}) if stiffness else rest
    selected = more[0] if more else rest
    refused = selection.steps[-1].refused
    next_one = None
    if refused:
        asked = refused.posed, refused.settled
        next_one = judged(*asked, cross_validated(*asked), most_likely(*asked))
    objection = unusable(selection.final)
    if not told:
        objection = objection_to(selection, rest, selected, settings.selection, settings.noise)
    correction = corrected = None
    if not told and (objection or selection.classes):
        every = [(*model, of) for model, of in zip(models, folds, strict=True)]
        correction = confirmed(every if objection else every[-1:], judged.spread)
    if correction:
        corrected = judged(
            correction.problem, correction.whole, correction.folds, correction.scales
        )
    return Diagnosis(
        problem, noises, selection, objection, stiffness, first, before, rest, selected,
        next_one, correction, corrected, told,
    )  # fmt: skip


def _told(selection: Selection, told: Pooled) -> Selection:
    """A selection with the effects that other groups have chosen in place of its own."""
    problem, fit, threshold = told.problem, told.fit, selection.steps[0].threshold
    chosen = [
        Candidate(name, fit, problem, fit, evidence, evidence, False)
        for name, evidence in told.evidence.items()
    ]
    steps = [Step(threshold, [one], one, told.classes[one.name]) for one in chosen]
    return replace(
        selection,
        problem=problem,
        final=fit,
        classes=told.classes,
        steps=[*selection.steps, *steps],
    )


@dataclass(frozen=True)
class _Judge:
    """Errors of models of a group's tests (all of them), with the noise of the fitted ones."""

    specimens: Sequence[Specimen]
    noises: Sequence[Noise]

    @property
    def spread(self) -> list[float]:
        """Standard deviation of a block of each test [N]."""
        return [noise.block for noise in self.noises]

    def __call__(
        self, posed: Problem, fit: Fit, found: Mapping[str, Fold], scales: Scales
    ) -> Judged:
        """Errors of a fit, with those of the folds of its problem."""
        stiffness = {s.piece: s.stiffness for s in posed.specimens}
        tests = [specimen.of_stiffness(stiffness) for specimen in self.specimens]
        return Judged(
            errors(posed, fit, self.spread),
            fold_errors(posed, found, self.spread),
            held_out_errors(fit, tests, self.noises[0].white, scales),
            log_density(posed, fit, found),
            form_error(posed, fit, self.spread),
            repeat_error(posed, fit),
        )


def report(diagnosis: Diagnosis, settings: LoopSettings) -> dict[str, Any]:
    """What `verdict.json` holds."""
    found = judgement(diagnosis, settings)
    limits = detection_limits(diagnosis.selection, diagnosis.final)
    law = diagnosis.final.model.law
    unseen = {e.name for e in diagnosis.selection.library if law.admits(e)} - set(limits)
    return {
        **found,
        "recommended": _recommended(diagnosis, settings),
        "not_identifiable": sorted({*found["not_identifiable"], *unseen}),
        "detection_limits": {
            e.name: {
                **_first_size(e, limits[e.name].multiple),
                "modulus_percent": 100.0 * (limits[e.name].modulus - 1.0),
            }
            for e in diagnosis.selection.library
            if e.name in limits
        },
    }


def _recommended(diagnosis: Diagnosis, settings: LoopSettings) -> dict[str, Any]:
    """The modulus to quote: averaged over the models that the records leave open.

    Where the selected effects do not hold, or other groups chose them, it is that of what is
    reported; what an error without cause makes of it widens the interval.
    """
    rest, several = diagnosis.rest, not (diagnosis.objection or diagnosis.told)
    tried = [(one, model) for one, part in diagnosis.of_ends for model in _weighed(one, part)]
    tried.sort(key=lambda pair: -pair[1].weight)
    models = [model for _, model in tried]
    mu, low, high = averaged(models, settings.noise, diagnosis.stiffness)
    return {
        "mu": {
            "value": mu,
            "unit": "Pa",
            "low": low * min([1.0, *rest.values()]),
            "high": high * max([1.0, *rest.values()]),
        },
        "estimate": "averaged over the models fitted" if several else "of the model reported",
        "why": f"verdict {diagnosis.verdict}",
        "models": [
            {
                "effects": [*([ENDS] if one.slides else []), *model.fit.model.names],
                "weight": model.weight,
                "mu": model.fit.state.material.mu,
            }
            for one, model in tried
            if model.weight >= SHOWN
        ],
        "widened_by_rest": any(abs(factor - 1.0) > SHOWN for factor in rest.values()),
    }


def _weighed(diagnosis: Diagnosis, part: float) -> list[Weighed]:
    """Models of a diagnosis, whose weights add up to a part."""
    found = [Weighed(diagnosis.final, 1.0, bond_deviation(diagnosis.problem, diagnosis.final))]
    if not (diagnosis.objection or diagnosis.told):
        found = weighed(diagnosis.selection)
    return [replace(one, weight=part * one.weight) for one in found]


def _first_size(effect: Effect, multiple: float) -> dict[str, float | str]:
    """Distance of the first size from its neutral value at a multiple of the nominal one."""
    first = next(p for p in effect.sizes if p.nominal != p.neutral)
    return {"value": multiple * abs(first.nominal - first.neutral), "unit": first.unit}


def judgement(diagnosis: Diagnosis, settings: LoopSettings) -> dict[str, Any]:
    """What `verdict.json` holds, but for the sizes that would have been seen."""
    selection, final = diagnosis.selection, diagnosis.final
    fractions = diagnosis.problem.fractions
    named = [] if diagnosis.objection else final.model.effects
    whole = [
        *([_ends_report(diagnosis)] if diagnosis.shows_sliding else []),
        *([_stiffness_report(diagnosis, settings.noise)] if diagnosis.stiffness else []),
    ]
    origin = diagnosis.origin
    return {
        "verdict": diagnosis.verdict,
        "objection": diagnosis.objection or None,
        "effects": [
            *([] if diagnosis.objection else whole),
            *(_effect_report(effect, selection, settings.noise) for effect in named),
        ],
        "specimen_stiffness": dict(diagnosis.stiffness),
        "theta_before": _theta(origin.first[1], settings.noise, fractions),
        "theta_after": _theta(final, settings.noise, fractions, diagnosis.stiffness),
        "withheld": _withheld(diagnosis, settings),
        "pooled": diagnosis.told.report() if diagnosis.told else None,
        "other_ends": _other_ends(diagnosis),
        "correction": diagnosis.correction.report() if diagnosis.correction else None,
        "error_before": error_report(origin.before.fitted),
        "error_after": error_report(diagnosis.after.fitted),
        "folds_before": error_report(origin.before.folds),
        "folds_after": error_report(diagnosis.after.folds),
        "held_out_before": _declared(origin.before),
        "held_out_after": _declared(diagnosis.after),
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
        "discrepancy_percent": {
            when: settings.noise.sizes(posed.variances)
            for when, posed in (("before", origin.first[0]), ("after", selection.problem))
        },
        "reduced_chi_square": {
            "before": origin.first[1].cost / len(origin.first[1].white),
            "after": final.cost / len(final.white),
        },
        "path": _path(selection),
        "not_identifiable": sorted(
            {
                *selection.weak,
                *(e.name for e in library().values() if e.sizes and not e.identifiable),
            }
        ),
    }


def _path(selection: Selection) -> list[dict[str, Any]]:
    """Every round of a selection."""
    return [
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
    ]


def _declared(judged: Judged) -> dict[str, Any]:
    """What the study holds out, or the folds of what is fitted if it holds nothing out."""
    return error_report({HELD_OUT: judged.held_out} if judged.held_out else judged.folds)


def _withheld(diagnosis: Diagnosis, settings: LoopSettings) -> list[dict[str, Any]]:
    """Effects that the records ask for and are not given, why, and what they would do."""
    selection, found = diagnosis.selection, []
    if diagnosis.objection:
        found = [
            {
                **_effect_report(effect, selection, settings.noise),
                "reason": diagnosis.objection,
                "held_out_if_given": _declared(diagnosis.selected),
            }
            for effect in selection.final.model.effects
        ]
    last = selection.steps[-1]
    if (refused := last.refused) and diagnosis.refused:
        effect = refused.settled.model.effects[-1]
        values = refused.settled.state.values[effect.name]
        found.append(
            {
                "name": effect.name,
                "parameters": {
                    p.name: {"value": values[p.name], "unit": p.unit} for p in effect.parameters
                },
                "evidence": refused.evidence,
                "reason": last.why,
                "held_out_if_given": _declared(diagnosis.refused),
            }
        )
    return found


def error_report(found: Errors) -> dict[str, Any]:
    """Errors by two names, in newton and percent."""
    return {
        name: {part: error.report() for part, error in parts.items()}
        for name, parts in found.items()
    }


def _theta(
    fit: Fit,
    noise: NoiseSettings,
    fractions: tuple[float, float],
    stiffness: Mapping[str, float] | None = None,
) -> dict[str, dict[str, float | str]]:
    """Material with 90 % intervals."""
    of_modulus = log_modulus_deviation(fit, noise, stiffness or {})
    of_fraction = float(np.sqrt(fit.covariance[1, 1]))
    mu, r = fit.state.material.mu, fit.state.material.mu1_fraction
    return {
        "mu": {
            "value": mu,
            "unit": "Pa",
            "low": mu * float(np.exp(-NINETY * of_modulus)),
            "high": mu * float(np.exp(NINETY * of_modulus)),
        },
        "mu1_fraction": {
            "value": r,
            "unit": "1",
            "low": max(fractions[0], r - NINETY * of_fraction),
            "high": min(fractions[1], r + NINETY * of_fraction),
        },
    }


def _ends_report(diagnosis: Diagnosis) -> dict[str, Any]:
    """Sliding ends, which have no size."""
    return {
        "name": ENDS,
        "class": [ENDS],
        "parameters": {},
        "evidence": diagnosis.origin.left - diagnosis.left + diagnosis.slid,
        "separating_experiment": ends.EFFECT.experiment,
    }


def _other_ends(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """What the verdict would be with the other ends, if the study leaves them open."""
    if (other := diagnosis.other_ends) is None:
        return None
    return {
        "ends": "sliding" if other.slides else "bonded",
        "verdict": other.verdict,
        "effects": list(other.final.model.names),
        "mu": {"value": other.final.state.material.mu, "unit": "Pa"},
        "evidence": diagnosis.left - other.left,
        "evidence_of_other_groups": diagnosis.slid if other.slides else -diagnosis.slid,
        "held_out_if_given": _declared(other.after),
        "path": _path(other.selection),
    }


def _stiffness_report(diagnosis: Diagnosis, noise: NoiseSettings) -> dict[str, Any]:
    """Stiffness of each specimen over that of the group, which the scale of a test leaves open."""
    factor = float(np.exp(NINETY * 0.01 * noise.scale_percent))
    (problem, fit), selection = diagnosis.first, diagnosis.selection
    return {
        "name": STIFFNESS,
        "class": [STIFFNESS],
        "parameters": {
            piece: {"value": x, "unit": "1", "low": x / factor, "high": x * factor}
            for piece, x in diagnosis.stiffness.items()
        },
        "evidence": problem.misfit(fit) - selection.plain.misfit(selection.base),
        "separating_experiment": specimen_stiffness.EFFECT.experiment,
    }


def _effect_report(effect: Effect, selection: Selection, noise: NoiseSettings) -> dict[str, Any]:
    """Sizes with 90 % intervals: of the fit, and of an error of form that is a part of the size."""
    final = selection.final
    doubt = 0.01 * noise.sizes(selection.problem.variances).get(FORM, 0.0)
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
