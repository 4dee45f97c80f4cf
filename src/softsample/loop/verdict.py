"""The document `verdict.json`: a diagnosis, the model it is of, and what was held out."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from scipy.special import ndtri

from softsample.constitutive.material import Material
from softsample.loop.accept import Judged
from softsample.loop.average import INTERVAL, Weighed, averaged, weighed
from softsample.loop.deviation import (
    birge_ratio,
    deviations,
    log_modulus_deviation,
    relaxing,
)
from softsample.loop.diagnose import Diagnosis
from softsample.loop.effects import ends, library, specimen_stiffness
from softsample.loop.effects.base import Effect, Values
from softsample.loop.errors import Errors
from softsample.loop.fit import Fit
from softsample.loop.limits import detection_limits
from softsample.loop.model import FIXED
from softsample.loop.noise import FORM, NoiseSettings
from softsample.loop.posed import LoopSettings
from softsample.loop.select import Selection
from softsample.loop.specimen import FORCE, Specimen
from softsample.records import is_clipped
from softsample.response.curves import FOLLOWED

HELD_OUT = "held_out"
"""Fold of what a study holds out."""

ENDS = ends.EFFECT.name
"""Effect that stands for the model of sliding ends."""

SHOWN = 0.005
"""Weight of a model, or change of the modulus, as a part, from which on it is named."""

NINETY = float(ndtri(INTERVAL[1]))
"""Standard deviations from the middle to the ends of a 90 % interval."""


def document(
    found: Diagnosis,
    left_out: tuple[Errors, Errors],
    settings: LoopSettings,
    solid: Material,
    rows: Sequence[Mapping[str, str]],
    rule: str,
) -> dict[str, Any]:
    """What `verdict.json` holds.

    Parameters
    ----------
    left_out : tuple of dict
        Errors of parts left out in turn, before and after, by fold and test.
    solid : Material
        Law of the model.
    rows : sequence of mapping
        Of the study table.
    rule : str
        What the study holds out, in words; the verdict has it if that is anything of this group.

    Returns
    -------
    dict
        `held_out_before` and `held_out_after` are of what the study holds out; if it holds nothing
        out, they are the cross-validated errors of the fitted records, `folds_before` and
        `folds_after`.
    """
    verdict = report(found, settings)
    for key, judged, errors in zip(
        ("held_out_before", "held_out_after"),
        (found.origin.before, found.after),
        left_out,
        strict=True,
    ):
        if errors:
            own = verdict[key] if judged.held_out else {}
            verdict[key] = {**own, **error_report(errors)}
    in_model = "sliding" if found.slides else "bonded"
    return {
        **verdict,
        "rule": rule if found.origin.before.held_out or left_out[0] else "",
        "elastic_law": elastic_law(found.final.state.values, solid),
        "ends": sorted({row["ends"].replace("unknown", in_model) for row in rows}),
    }


def elastic_law(values: Mapping[str, Values], solid: Material) -> dict[str, Any]:
    """Name and numbers of the law after a diagnosis, from the values of its effects."""
    foam = values.get("compressible_foam")
    if foam is not None:
        return {"name": "foam", "alpha": [foam["alpha"]], "poisson_ratio": foam["nu"],
                "share": foam["share"]}  # fmt: skip
    one_term = values.get("elastic_law")
    if one_term is not None:
        return {"name": "ogden", "alpha": [one_term["alpha"]],
                "poisson_ratio": solid.poisson_ratio, "share": one_term["share"]}  # fmt: skip
    alpha = list(values.get("ogden_exponents", {}).values()) or list(solid.alpha)
    return {"name": "ogden", "alpha": alpha, "poisson_ratio": solid.poisson_ratio}


def report(diagnosis: Diagnosis, settings: LoopSettings) -> dict[str, Any]:
    """What `verdict.json` holds."""
    found = judgement(diagnosis, settings)
    limits = detection_limits(diagnosis.selection, diagnosis.final)
    law = diagnosis.final.model.law
    unseen = {e.name for e in diagnosis.selection.library if law.admits(e)} - set(limits)
    unseen -= {*diagnosis.final.model.names, *(effect["name"] for effect in found["effects"])}
    rounds = [step.candidates for step in diagnosis.selection.steps]
    seen = {c.name for candidates in rounds for c in candidates if c.evidence > 0.0}
    return {
        **found,
        "recommended": recommended(diagnosis),
        "not_identifiable": sorted({*found["not_identifiable"], *unseen} - seen),
        "detection_limits": {
            name: {
                **_first_size(diagnosis.selection.strongest[name].effect, multiple),
                "modulus_percent": 100.0 * (modulus - 1.0),
            }
            for name, (multiple, modulus) in limits.items()
        },
    }


def recommended(diagnosis: Diagnosis) -> dict[str, Any]:
    """The modulus to quote: averaged over the models that the records leave open.

    Where the selected effects do not hold, or other groups chose them, it is that of what is
    reported; what an error without cause makes of it widens the interval.
    """
    rest, several = diagnosis.rest, not (diagnosis.objection or diagnosis.told)
    tried = [(one, model) for one, part in diagnosis.of_ends for model in _weighed(one, part)]
    tried.sort(key=lambda pair: -pair[1].weight)
    models = [model for _, model in tried]

    def quoted(relaxed: bool) -> dict[str, float | str]:
        mu, low, high = averaged(models, relaxed)
        factors = [1.0, *rest.values()]
        return _sized(mu, "Pa", low * min(factors), high * max(factors))

    return {
        "mu": quoted(relaxed=False),
        "mu_relaxed": quoted(relaxed=True) if relaxing(diagnosis.final) else None,
        "estimate": "averaged over the models fitted" if several else "of the model reported",
        "models": [
            {
                "effects": [*([ENDS] if one.slides else []), *model.fit.model.names],
                "weight": model.weight,
                "mu": model.fit.state.material.mu,
            }
            for one, model in tried
            if model.weight >= SHOWN
        ],
        "widened_by_models": any(one.alike > one.weight + SHOWN for _, one in tried),
        "widened_by_rest": any(abs(factor - 1.0) > SHOWN for factor in rest.values()),
    }


def _weighed(diagnosis: Diagnosis, part: float) -> list[Weighed]:
    """Models of a diagnosis, whose weights add up to a part."""
    reported = Weighed.of(diagnosis.final, 1.0, 1.0, diagnosis.posed.stiffness)
    selection = diagnosis.selection
    if diagnosis.correction:  # of a model that may have been refused
        selection = replace(selection, final=diagnosis.final)
    found = [] if diagnosis.told else weighed(selection, diagnosis.posed.stiffness)
    if diagnosis.objection or diagnosis.told:  # what does not hold may still be there
        rest = [replace(one, weight=0.0, alike=one.weight) for one in found]
        found = [replace(reported, alike=0.0 if rest else 1.0), *rest]
    return [replace(one, weight=part * one.weight, alike=part * one.alike) for one in found]


def _first_size(effect: Effect, multiple: float) -> dict[str, float | str]:
    """Distance of the first size from its neutral value at a multiple of the nominal one."""
    first = next(p for p in effect.sizes if p.nominal != p.neutral)
    return {"value": multiple * abs(first.nominal - first.neutral), "unit": first.unit}


def judgement(diagnosis: Diagnosis, settings: LoopSettings) -> dict[str, Any]:
    """What `verdict.json` holds, but for the sizes that would have been seen."""
    posed, selection, final = diagnosis.posed, diagnosis.selection, diagnosis.final
    named = [] if diagnosis.objection else final.model.effects
    whole = [
        *([_ends_report(diagnosis)] if diagnosis.shows_sliding else []),
        *([_stiffness_report(diagnosis, settings.noise)] if posed.stiffness else []),
    ]
    effects = [
        *([] if diagnosis.objection else whole),
        *(_effect_report(effect, selection, settings.noise) for effect in named),
    ]
    weak = {
        *selection.weak,
        *(e.name for e in library().values() if e.sizes and not e.identifiable),
    }
    origin = diagnosis.origin
    reported = ("before", origin.posed.first), ("after", final)
    return {
        "verdict": diagnosis.verdict,
        "objection": diagnosis.objection or None,
        "effects": effects,
        "overloaded_N": overloaded(posed.specimens),
        "extrapolated_mm": extrapolated(posed.specimens),
        "specimen_stiffness": dict(posed.stiffness),
        "specimen_contact_mm": dict(posed.contact),
        "theta_before": _theta(origin.posed.first, {}),
        "theta_after": _theta(final, posed.stiffness),
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
                posed.problem.labels, posed.noises, posed.problem.specimens, strict=True
            )
        },
        "absent": list(settings.absent),
        "floor": asdict(settings.noise),
        "discrepancy_percent": {
            when: settings.noise.sizes(fit.problem.variances)
            for when, fit in (("before", origin.posed.first), ("after", selection.final))
        },
        "birge_ratio": {when: birge_ratio(fit) for when, fit in reported},
        "reduced_chi_square": {when: fit.cost / len(fit.white) for when, fit in reported},
        "path": _path(selection),
        "not_identifiable": sorted(weak - {effect["name"] for effect in effects}),
    }


def overloaded(specimens: Sequence[Specimen]) -> dict[str, float]:
    """Largest forces [N] at which load cells stayed in what is fitted, by sample."""
    found = {}
    for specimen in specimens:
        force = specimen.force[(specimen.phase == "ramp") & ~specimen.held_out]
        if len(force) and is_clipped(force):
            along = specimen.channel == FORCE
            peak = float(force[np.abs(force).argmax()]) * (specimen.axis_sign if along else 1.0)
            found[specimen.name if along else f"{specimen.name}, normal force"] = peak
    return found


def extrapolated(specimens: Sequence[Specimen]) -> dict[str, dict[str, float]]:
    """By sample, displacements [mm] that were simulated and are fitted, if these go far beyond."""
    found = {}
    for s in specimens:
        simulated = s.elastic.curves.displacement[-1]
        fitted = np.abs(s.travel[~s.held_out]).max(initial=0.0)
        if fitted > (1.0 + FOLLOWED) * simulated:
            found[s.name] = {"simulated": float(1e3 * simulated), "fitted": float(1e3 * fitted)}
    return found


def _path(selection: Selection) -> list[dict[str, Any]]:
    """Every round of a selection."""
    return [
        {
            "threshold": step.threshold,
            "chosen": step.chosen.name if step.chosen else None,
            "evidence": step.chosen.evidence if step.chosen else None,
            "refused": step.refused.name if step.refused else None,
            "why": step.why or None,
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
        found.append(
            {
                "name": effect.name,
                "parameters": effect.report(refused.settled.state.values[effect.name]),
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


def _sized(value: float, unit: str, low: float, high: float) -> dict[str, float | str]:
    """A number with its 90 % interval."""
    return {"value": value, "unit": unit, "low": low, "high": high}


def _named(
    effect: Effect, members: list[str], parameters: Mapping[str, Any], evidence: float
) -> dict[str, Any]:
    """An effect that is given, with its class."""
    return {
        "name": effect.name,
        "class": members,
        "parameters": parameters,
        "evidence": evidence,
        "separating_experiment": effect.experiment,
    }


def _theta(fit: Fit, stiffness: Mapping[str, float]) -> dict[str, dict[str, float | str]]:
    """Material with 90 % intervals."""
    of_log, of_fraction = log_modulus_deviation(fit, stiffness), float(deviations(fit)[1])
    near, factor = NINETY * of_fraction, float(np.exp(NINETY * of_log))
    mu, r = fit.state.material.mu, fit.state.material.mu1_fraction
    least, most = fit.problem.fractions
    return {
        "mu": _sized(mu, "Pa", mu / factor, mu * factor),
        "mu1_fraction": _sized(r, "1", max(least, r - near), min(most, r + near)),
    }


def _ends_report(diagnosis: Diagnosis) -> dict[str, Any]:
    """Sliding ends, which have no size."""
    evidence = diagnosis.origin.left - diagnosis.left + diagnosis.elsewhere
    return _named(ends.EFFECT, [ENDS], {}, evidence)


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
        "evidence_of_other_groups": (1.0 if other.slides else -1.0) * diagnosis.elsewhere,
        "chosen_by_other_groups": diagnosis.ends_are_told,
        "held_out_if_given": _declared(other.after),
        "path": _path(other.selection),
    }


def _stiffness_report(diagnosis: Diagnosis, noise: NoiseSettings) -> dict[str, Any]:
    """Stiffness of each specimen over that of the group, which the scale of a test leaves open."""
    factor = float(np.exp(NINETY * 0.01 * noise.scale_percent))
    sizes = {
        piece: _sized(x, "1", x / factor, x * factor)
        for piece, x in diagnosis.posed.stiffness.items()
    }
    evidence = diagnosis.posed.first.misfit - diagnosis.selection.base.misfit
    return _named(specimen_stiffness.EFFECT, [specimen_stiffness.EFFECT.name], sizes, evidence)


def _effect_report(effect: Effect, selection: Selection, noise: NoiseSettings) -> dict[str, Any]:
    """Sizes with 90 % intervals: of the fit, and of an error of form that is a part of the size."""
    final = selection.final
    doubt = 0.01 * noise.sizes(final.problem.variances).get(FORM, 0.0)
    deviation = deviations(final)[FIXED:]
    deviation[~final.jacobian[:, FIXED:].any(axis=0)] = np.inf  # nothing in the records shows it
    unit = {
        (e.name, p.name): float(d) * (p.high - p.low)
        for (e, p), d in zip(final.model.parameters, deviation, strict=True)
    }
    # one that was dropped can come back
    chosen = [s.chosen for s in selection.steps if s.chosen and s.chosen.name == effect.name][-1]
    parameters = {}
    for p in effect.parameters:
        value = final.state.values[effect.name][p.name]
        spread = np.hypot(unit[effect.name, p.name], doubt * abs(value - p.neutral))
        low, high = max(p.low, value - NINETY * spread), min(p.high, value + NINETY * spread)
        parameters[p.name] = _sized(value, p.unit, low, high)
    return _named(effect, selection.classes[effect.name], parameters, chosen.evidence)
