"""The document `verdict.json`: a diagnosis, the model it is of, and what was held out."""

from collections.abc import Mapping, Sequence
from typing import Any

from softsample.constitutive.ogden import OgdenMaterial
from softsample.loop.diagnose import Diagnosis, LoopSettings, error_report, report
from softsample.loop.leave_out import Errors

HELD_OUT = "held_out"


def document(
    found: Diagnosis,
    left_out: tuple[Errors, Errors],
    settings: LoopSettings,
    solid: OgdenMaterial,
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
    solid : OgdenMaterial
        Law of the model.
    rows : sequence of mapping
        Of the study table.
    rule : str
        What the study holds out, in words.

    Returns
    -------
    dict
        `held_out_before` and `held_out_after` are of what the study holds out; if it holds nothing
        out, they are the cross-validated errors of the fitted records, `folds_before` and
        `folds_after`.
    """
    verdict = report(found, settings)
    for when, judged, errors in zip(
        ("before", "after"), (found.before, found.after), left_out, strict=True
    ):
        declared = {HELD_OUT: judged.held_out} if judged.held_out else {}
        shown = {**declared, **errors} or judged.folds
        verdict[f"held_out_{when}"] = error_report(shown)
    return {
        **verdict,
        "rule": rule,
        "elastic_law": {
            "name": "ogden",
            "alpha": list(solid.alpha),
            "poisson_ratio": solid.poisson_ratio,
        },
        "ends": sorted({row["ends"] for row in rows}),
    }
