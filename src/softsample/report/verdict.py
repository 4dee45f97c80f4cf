"""The verdict on one page, for people."""

from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Any

from softsample.arrays import root_mean_square
from softsample.loop.effects import ends, library
from softsample.report.loop import declared
from softsample.wording import (
    NO_ERROR,
    OVERLOADED,
    fitted,
    overload_told,
    significant,
    verdict_words,
)

Limits = list[tuple[str, Mapping[str, Any]]]

SAYING = {
    "explained": "The residual is explained.",
    "explained_class": "What is left is of a known class; its cause is open.",
    "none": "No missing effect was detected: noise and model discrepancy explain the residual.",
    "unknown": "**Unknown:** something is left that no effect of the library explains.",
}


OF_THE_MODEL = (
    "Before: the model without effects, fitted to these records allowing for model discrepancy, "
    "which calibration does not. After: the model with the effects above alone; the modulus to "
    "quote counts other likely models, too."
)
"""What the table of moduli is of."""

SCALED = "in the scale that the fitted records of each test show, which the figure leaves out"
"""How forces that are held out are predicted."""

PATH = (
    "One line for each round of the selection: the five effects with the highest penalised log "
    "evidence, given beside each, then the outcome. An effect needs more than the threshold."
)
"""How to read the lines of the path."""


def page(group: str, verdict: Mapping[str, Any]) -> str:
    """Markdown page of a `verdict.json`.

    Parameters
    ----------
    group : str
        Name of the group.
    verdict : mapping
        Report of a diagnosis, see `softsample.loop.verdict.report`.
    """
    parts = [f"# Verdict for {group}: {verdict_words(verdict['verdict'])}", ""]
    for text in _opening(verdict):
        parts += [text, ""] if text else []
    for effect in verdict["effects"]:
        other = verdict["other_ends"] if effect["name"] == ends.EFFECT.name else None
        against = effect["evidence"] < verdict["path"][0]["threshold"]
        parts += _effect(effect, bool(other and other["chosen_by_other_groups"] and against))
    if verdict["correction"]:
        tells = _beside if verdict["verdict"] == "explained" else _correction
        parts += [tells(verdict["correction"]), ""]
    parts += _withheld(verdict)
    parts += [
        "## Modulus",
        "",
        OF_THE_MODEL,
        "",
        *_moduli(verdict),
        "",
        *_wider(verdict["birge_ratio"]["after"]),
    ]
    parts += ["## Error", "", *_errors(verdict, "error", "test", "phase"), ""]
    rule, leaves = verdict.get("rule"), bool(verdict["held_out_before"])
    if rule and leaves:
        parts += [f"Held out, and predicted from the rest ({rule}) {SCALED}:", ""]
    elif leaves:
        parts += ["The study holds nothing out; parts of what is fitted, in turn:", ""]
    parts += [*_errors(verdict, "held_out", "left out", "test"), ""] if leaves else []
    if rule and verdict["folds_before"]:
        parts += ["Parts of what is fitted, left out in turn and predicted from the rest:", ""]
        parts += [*_errors(verdict, "folds", "left out", "test"), ""]
    limits = _worst_first(verdict["detection_limits"])
    parts += ["## Path", "", PATH, "", *_path(verdict), "", *_limits(verdict, limits)]
    parts += ["", "![before and after](verdict.png)", ""]
    return "\n".join(parts)


def _opening(verdict: Mapping[str, Any]) -> Iterator[str]:
    """Paragraphs before the effects; empty where there is nothing to say."""
    named = [effect["name"] for effect in verdict["effects"]]
    models = [one for one in verdict["recommended"]["models"] if one["weight"] >= WORTH_A_NAME]
    counted = {*named, *(name for one in models for name in one["effects"])}
    unseen = [x for x in _worst_first(verdict["detection_limits"]) if x[0] not in counted]
    if overloaded := verdict["overloaded_N"]:
        yield f"**{OVERLOADED}:** {overload_told(overloaded)}"
    yield _saying(verdict)
    yield _recommended(verdict["recommended"])
    yield _predicted(verdict)
    yield _scales(verdict)
    yield _unseen(*unseen[0]) if unseen else ""
    if verdict["specimen_stiffness"] and not named:
        yield _specimens(verdict["specimen_stiffness"])
    if verdict["specimen_contact_mm"]:
        yield _contact(verdict["specimen_contact_mm"])
    if verdict["pooled"]:
        yield _pooled(verdict["pooled"])
    if verdict["other_ends"]:
        yield _other_ends(verdict)


def _saying(verdict: Mapping[str, Any]) -> str:
    """The verdict in one sentence; `none` says how much more than expected is left."""
    ratio = verdict["birge_ratio"]["after"]
    if verdict["verdict"] != "none" or round(ratio, 2) == 1.0:
        return SAYING[verdict["verdict"]]
    return f"No effect is named; what is left is {ratio:.2f} times what the discrepancy predicts."


RELAXING = ("viscoelastic_relaxation", "poroelastic_drainage")
"""Effects beside which the modulus is that of a sudden load."""


WORTH_A_NAME = 0.05
"""Weight of a model in the modulus to quote from which on the page names it."""


def _recommended(found: Mapping[str, Any]) -> str:
    """One sentence on the modulus to quote."""
    mu = found["mu"]
    value, limits = (
        f"{significant(mu['value'])} {mu['unit']}",
        f"{significant(mu['low'])} to {significant(mu['high'])}, 90 %",
    )
    named = [one for one in found["models"] if one["weight"] >= WORTH_A_NAME]
    alone = round(sum(one["weight"] for one in named), 2) == 1.0
    rest = "others of less weight" if named else "many models"
    models = [*map(_model, named), *([] if alone else [rest])]
    whose = "of" if len(models) == 1 and alone else "averaged over"
    text = f"Modulus to quote: **{value}** ({limits}), {whose} {', '.join(models)}."
    if found["widened_by_models"]:
        text += " The interval allows for other models that the records leave open."
    if found["widened_by_rest"]:
        text += " It allows for what the error that is left makes of the modulus at small strain."
    relaxing = [f"`{e}`" for e in RELAXING if any(e in one["effects"] for one in named)]
    if relaxing:
        text += (
            f" It is the instantaneous modulus: with {' and '.join(relaxing)} the tissue is softer "
            "at the speed of these tests."
        )
    if relaxed := found.get("mu_relaxed"):
        value, low, high = (significant(relaxed[key]) for key in ("value", "low", "high"))
        text += f" Of it {value} Pa ({low} to {high}) are left at the end of the longest record."
    return text


NO_BETTER = 0.8
"""Part of the error without effects from which on what is held out is not predicted."""

HALF = 50.0
"""Error [% of peak] from which on it is not, whatever it was without effects."""

FAR = 3.0
"""Multiple of the stated floor up to which it is predicted all the same; of the stated scale up to
which tests differ no more than usual."""


def _predicted(verdict: Mapping[str, Any]) -> str:
    """How well a verdict with effects predicts what the study holds out, and what it does not."""
    if not verdict.get("rule") or verdict["verdict"] not in ("explained", "explained_class"):
        return ""
    pairs = {
        name: (error["rms_percent"], after["rms_percent"])
        for (name, error), (_, after) in zip(
            *(declared(verdict[f"held_out_{when}"]) for when in ("before", "after")), strict=True
        )
    }
    if not pairs:
        return ""
    before, after = (significant(root_mean_square(of)) for of in zip(*pairs.values(), strict=True))
    text = f"What is held out is predicted to {after} % of the peak, {before} % without effects."
    least = FAR * verdict["floor"]["floor_percent"]
    failed = [
        f"`{k}`"
        for k, (was, left) in pairs.items()
        if left > max(min(NO_BETTER * was, HALF), least)
    ]
    if failed:
        names = ", ".join(failed)
        text += f" **Not predicted:** {names}; what is quoted holds for what was fitted."
    return text


def _scales(verdict: Mapping[str, Any]) -> str:
    """That tests differ in scale by far more than stated, where effects explain the rest."""
    found, usual = verdict["discrepancy_percent"]["after"], verdict["floor"]["scale_percent"]
    if verdict["verdict"] != "explained" or found.get("scale", 0.0) <= FAR * usual:
        return ""
    size = f"{significant(found['scale'])} %** (usual: {significant(usual)} %)"
    return (
        f"**Beside these effects the scale of the tests differs by {size}, as specimens of unequal "
        "stiffness do."
    )


def _unseen(name: str, worst: Mapping[str, Any]) -> str:
    """Two sentences on what an effect that was not seen may make of the modulus."""
    return (
        "The interval holds if no undetected effect is present. The worst that these records could "
        f"hide is `{name}`: just below its detection limit it would bias the modulus by "
        f"{worst['modulus_percent']:+.0f} % (last table)."
    )


def _worst_first(limits: Mapping[str, Mapping[str, Any]]) -> Limits:
    """Smallest sizes that would have been seen, those first that change the modulus most."""
    return sorted(limits.items(), key=lambda item: -abs(item[1]["modulus_percent"]))


def _model(found: Mapping[str, Any]) -> str:
    """A model whose modulus counts, with its modulus and weight unless it is the only one."""
    names = " and ".join(f"`{name}`" for name in found["effects"])
    text = f"the model with {names}" if names else "the plain model"
    if round(found["weight"], 2) == 1.0:
        return text
    return f"{text} ({significant(found['mu'])} Pa, weight {found['weight']:.2f})"


def _pooled(found: Mapping[str, Any]) -> str:
    """One sentence on what other groups tell."""
    errors = [found[f"others_{when}_percent"] for when in ("before", "alone", "after")]
    before, alone, after = map(significant, errors)
    return (
        f"The {found['groups']} other groups choose the effects, and how large they may be: with "
        f"these, what is held out of each of them is predicted to {after} % of the peak ({alone} % "
        f"by its own diagnosis, {before} % without effects; geometric means)."
    )


def _other_ends(verdict: Mapping[str, Any]) -> str:
    """Two sentences on ends that the study leaves open, and whose choice they are."""
    other, here = verdict["other_ends"], {"bonded": "slide", "sliding": "are bonded"}
    told = other["evidence_of_other_groups"]
    others = f", and {told:.0f} in the other groups" if told else ""
    named = ", ".join(f"`{name}`" for name in other["effects"])
    effects = f" ({named})" if named else ""
    if other["chosen_by_other_groups"]:
        chosen = (
            " That is the choice of the other groups, by what is held out of them, whatever the "
            "evidence."
        )
    else:
        chosen = ""
    return (
        f"The study leaves the ends open; in this model they {here[other['ends']]}.{chosen} With "
        f"{other['ends']} ends the verdict would be {other['verdict']}{effects} and the modulus "
        f"{significant(other['mu']['value'])} Pa (evidence {other['evidence']:.0f}"
        f"{others})."
    )


def _specimens(stiffness: Mapping[str, float]) -> str:
    """One sentence on specimens that differ, where no effect is given."""
    named = ", ".join(f"{piece} {value:.3g}" for piece, value in stiffness.items())
    return f"The specimens differ in stiffness, over their geometric mean: {named}."


def _contact(offsets: Mapping[str, float]) -> str:
    """One sentence on specimens that the platen meets at displacements of their own."""
    named = ", ".join(f"{piece} {value:+.2f} mm" for piece, value in offsets.items())
    return f"The platen meets the specimens at displacements that differ, over their mean: {named}."


def _table(header: list[str], rows: list[list[str]]) -> list[str]:
    lines = [header, ["---"] * len(header), *rows]
    return ["| " + " | ".join(line) + " |" for line in lines]


def _effect(effect: Mapping[str, Any], told: bool) -> list[str]:
    """An effect, which is `told` if the other groups have chosen it against the evidence."""
    known = library()
    others = [name for name in effect["class"] if name != effect["name"]]
    lines = [f"## {known[effect['name']].title} (`{effect['name']}`)", ""]
    if others:
        named = ", ".join(f"`{name}`" for name in others)
        lines += [f"**Undecided:** these records cannot tell it from {named}.", ""]
    lines += [f"Signature: {known[effect['name']].signature}.", ""]
    sizes = [
        [name, fitted(p["value"]), f"{fitted(p['low'])} to {fitted(p['high'])}", p["unit"]]
        for name, p in effect["parameters"].items()
    ]
    if sizes:
        lines += [*_table(["parameter", "value", "90 % interval", "unit"], sizes), ""]
    experiment = effect["separating_experiment"]
    chosen = ", but the other groups choose it" if told else ""
    return [
        *lines,
        f"Evidence {effect['evidence']:.0f}{chosen}. Discriminating experiment: {experiment}.",
        "",
    ]


def _correction(found: Mapping[str, Any]) -> str:
    """What corrects the model in place of effects, and where it holds."""
    kind = found["class"].replace("_", " ")
    parts = [_sizes({"name": name, "parameters": of}) for name, of in found["parameters"].items()]
    if found["smooth_part"]:
        parts.append("a smooth part")
    factors = ", ".join(f"{mode} {factor:.3g}" for mode, factor in found["modulus_factors"].items())
    modulus = f"It multiplies the modulus at small strain ({factors}). " if factors else ""
    return (
        f"Correction, not cause (class: {kind}): {' and '.join(parts)}. It {_takes(found)}. "
        f"It was learned up to {_domain(found)}; beyond, it goes on smoothly. "
        f"{modulus}Discriminating experiment: {found['separating_experiment']}."
    )


def _beside(found: Mapping[str, Any]) -> str:
    """What corrects the model beside effects that explain the residual."""
    return (
        "What these effects leave is no further effect. A smooth correction of it "
        f'{_takes(found)}; errors under "after" include it. It was learned up to '
        f"{_domain(found)}; beyond, it goes on smoothly."
    )


def _takes(found: Mapping[str, Any]) -> str:
    """By how much a correction lowers the error."""
    before, after = found["left_out_before_percent"], found["left_out_after_percent"]
    left = "less than the noise" if after < NO_ERROR else f"{significant(after)} % of the peak"
    return (
        "takes the error of what was left out of a kind of test whose rest was fitted, noise taken "
        "out, from "
        f"{significant(before)} % of the peak to {left}"
    )


def _domain(found: Mapping[str, Any]) -> str:
    """Travels up to which a correction was learned."""
    return ", ".join(f"{test} {travel:.3g} mm" for test, travel in found["domain_mm"].items())


def _withheld(verdict: Mapping[str, Any]) -> list[str]:
    """What was selected and is not given, what was refused together in one paragraph.

    Errors are with all effects up to there. What corrects the model is told with the correction.
    """
    corrects = verdict["correction"]["with"] if verdict["correction"] else []
    lines: list[str] = []
    given: list[str] = []
    for (reason, would), together in groupby(
        verdict["withheld"], key=lambda effect: (effect["reason"], effect["held_out_if_given"])
    ):
        effects = list(together)
        given += [f"`{effect['name']}`" for effect in effects]
        shown = [_sizes(effect) for effect in effects if effect["name"] not in corrects]
        errors = [test["rms_percent"] for tests in would.values() for test in tests.values()]
        text = f"Not reported: {' and '.join(shown)}, since {reason}."
        if errors:
            left, whom = significant(root_mean_square(errors)), " and ".join(given)
            text += f" With {whom}, {left} % of the peak would be left of what is held out."
        lines += [text, ""] if shown else []
    return lines


def _sizes(effect: Mapping[str, Any]) -> str:
    """Name of an effect with its sizes."""
    sizes = ", ".join(
        f"{name} {fitted(p['value'])} {p['unit']}".removesuffix(" 1")
        for name, p in effect["parameters"].items()
    )
    return f"`{effect['name']}` ({sizes})"


def _moduli(verdict: Mapping[str, Any]) -> list[str]:
    before, after = verdict["theta_before"], verdict["theta_after"]
    return _table(
        ["", "before", "after", "90 % interval", "unit"],
        [
            [
                name,
                fitted(before[name]["value"]),
                fitted(after[name]["value"]),
                f"{fitted(after[name]['low'])} to {fitted(after[name]['high'])}",
                after[name]["unit"],
            ]
            for name in before
        ],
    )


def _wider(ratio: float) -> list[str]:
    """One sentence on intervals that are wider by what is left, if they are."""
    if round(ratio, 2) == 1.0:
        return []
    return [
        f"What the model leaves is {ratio:.2f} times what its discrepancy predicts; the intervals "
        "are as much wider.",
        "",
    ]


def _errors(verdict: Mapping[str, Any], key: str, *of: str) -> list[str]:
    """Errors `key` before and after, by what the two columns `of` name."""
    rows = []
    for one, parts in verdict[f"{key}_before"].items():
        for two, before in parts.items():
            both = before, verdict[f"{key}_after"][one][two]
            numbers = [1e3 * e["rms_N"] for e in both] + [e["rms_percent"] for e in both]
            rows.append([one, two, *map(significant, numbers)])
    return _table([*of, "RMS before [mN]", "after [mN]", "before [% of peak]", "after"], rows)


MOST_DECIMALS = 4
"""Of evidence beside a threshold, which are told apart."""


def _path(verdict: Mapping[str, Any]) -> list[str]:
    """Every round of the selection: the largest evidence, the choice and what was refused."""
    lines, found = [], [effect["name"] for effect in verdict["effects"]]
    for number, step in enumerate(verdict["path"], start=1):
        best, threshold = step["candidates"][:5], step["threshold"]
        told = [_apart(c["evidence"], threshold) for c in best]
        ranking = ", ".join(f"`{c['name']}` {e}" for c, (e, _) in zip(best, told, strict=True))
        outcome = []
        if step["refused"]:
            outcome.append(f"`{step['refused']}` refused: {step['why']}")
        if step["chosen"]:
            kept = "" if step["chosen"] in found else ", not kept"
            told.append(_apart(step["evidence"], threshold))
            outcome.append(f"`{step['chosen']}` chosen, evidence {told[-1][0]}{kept}")
        shown = max((one for _, one in told), key=len, default=f"{threshold:.0f}")
        lines.append(
            f"{number}. threshold {shown}: {ranking or 'no candidate'} - "
            f"{'; '.join(outcome) or 'no effect added'}"
        )
    return lines


def _apart(evidence: float, threshold: float) -> tuple[str, str]:
    """Evidence and threshold with the digits that tell on which side of the other each is."""
    for digits in range(MOST_DECIMALS):
        told, shown = (f"{number:.{digits}f}" for number in (evidence, threshold))
        if told != shown:
            return told, shown
    whole = f"{threshold:.0f}"
    return f"just below {whole}" if evidence < threshold else whole, whole


def _limits(verdict: Mapping[str, Any], limits: Limits) -> list[str]:
    names = ", ".join(verdict["not_identifiable"]) or "none"
    lines = [f"Not identifiable from these records: {names}."]
    if verdict["absent"]:
        lines += ["", "Known not to be there: " + ", ".join(verdict["absent"]) + "."]
    rows = [
        [f"`{name}`", significant(x["value"]), x["unit"], f"{x['modulus_percent']:+.1f}"]
        for name, x in limits
    ]
    header = ["effect", "smallest size that would have been seen", "unit", "error of mu then [%]"]
    return [*lines, "", *_table(header, rows)] if rows else lines
