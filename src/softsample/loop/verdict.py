"""The document `verdict.json`: a diagnosis, the model it is of, and what was held out."""

from collections.abc import Mapping, Sequence
from typing import Any

from softsample.constitutive.material import Material
from softsample.loop.diagnose import Diagnosis, error_report, report
from softsample.loop.effects.base import Values
from softsample.loop.leave_out import Errors
from softsample.loop.posed import LoopSettings


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
    found : Diagnosis
        Of the group.
    left_out : tuple of dict
        Errors of parts left out in turn, before and after, by fold and test.
    settings : LoopSettings
        Of the diagnosis.
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
    return {
        **verdict,
        "rule": rule if found.origin.before.held_out or left_out[0] else "",
        "elastic_law": elastic_law(found.final.state.values, solid),
        "ends": sorted({_ends(row["ends"], found) for row in rows}),
    }


def _ends(stated: str, found: Diagnosis) -> str:
    """Ends of a sample in the model that is reported."""
    return stated if stated != "unknown" else "sliding" if found.slides else "bonded"


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
