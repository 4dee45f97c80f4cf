"""A group beside its responses, from the files of the study."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from softsample.constitutive.material import Material
from softsample.io import read_json, read_record, read_table
from softsample.loop.ends import AssumedEnds, Recorded
from softsample.loop.posed import LoopSettings
from softsample.response.elastic import Tables
from softsample.shapes import IdealShape


def assumed_ends(
    files: Mapping[str, Any], given: Any, settings: LoopSettings, solid: Material
) -> list[AssumedEnds]:
    """A group beside its responses: of the study's ends, or of bonded and of sliding ones.

    Parameters
    ----------
    files : mapping
        Files, or lists of files, by name: input of the rule `diagnose`.
    given : object
        Its parameters.
    settings : LoopSettings
        Of the diagnosis.
    solid : Material
        The law of the study.
    """
    reports = map(read_json, files.get("bonds", []))
    bonds = [next(reports, None) if bonded else None for bonded in given.bonded]
    whole, alone = ([*map(read_json, files.get(kind, []))] for kind in ("whole", "alone"))
    recorded = Recorded(
        given.samples,
        given.rows,
        [*map(read_record, files["records"])],
        [IdealShape.of_report(read_json(path)) for path in files["cuboids"]],
        given.hold_out,
        given.others,
        (whole, alone),
    )
    models = []
    for ends in ("", "sliding_")[: 2 if files.get("sliding_curves") else 1]:
        known = [*map(read_table, files.get(f"{ends}real", []))]
        real: Sequence[pd.DataFrame | None] = known or [None] * len(bonds)
        curves, changes = files[f"{ends}curves"], map(read_table, files[f"{ends}perturbations"])
        of_curves = {
            path: Tables(read_table(path), [change], solid, table, bond, given.release)
            for path, change, table, bond in zip(curves, changes, real, bonds, strict=True)
        }
        tables = [of_curves[path] for path in curves]
        models.append(recorded.with_ends(bool(ends), tables, settings, solid))
    return models
