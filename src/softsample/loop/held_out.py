"""The channels of a record as tests of the diagnosis, with what the study holds out of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd

from softsample.constitutive.material import Material
from softsample.holdout import held_out
from softsample.loop.specimen import FORCE, NORMAL, Specimen
from softsample.protocol import SHEARED_MODES
from softsample.records import Record
from softsample.response.bond import log_force
from softsample.response.elastic import Elastic
from softsample.shapes import IdealShape

KEPT = 256
"""Responses that are kept: tests of one piece share theirs, and so what was computed of it."""


@dataclass(frozen=True, eq=False)
class Tables:
    """Simulated response of one piece.

    Parameters
    ----------
    curves : DataFrame
        Its unit-modulus response.
    changes : sequence of DataFrame
        Its changes by perturbations of the model.
    solid : Material
        Of which the model is made.
    real : DataFrame, optional
        Response of the real geometry, if the model is the ideal one.
    bond : mapping, optional
        What either rule of the bond makes of it (`softsample.response.bond.by_rule`).
    release : bool
        Whether a platen leaves a sample that would pull on it.
    """

    curves: pd.DataFrame
    changes: Sequence[pd.DataFrame]
    solid: Material
    real: pd.DataFrame | None = None
    bond: Mapping[str, Any] | None = None
    release: bool = True


@lru_cache(KEPT)
def _elastic(tables: Tables, mode: str, channel: str, shape: IdealShape) -> Elastic:
    parts = tables.curves, tables.changes, tables.solid, tables.real
    return Elastic.of_tables(mode, *parts, channel, shape, tables.release)


def specimens_of(
    row: Mapping[str, str],
    record: Record,
    tables: Tables,
    shape: IdealShape,
    hold_out: Sequence[Mapping[str, Any]],
) -> list[Specimen]:
    """Tests of one sample: its force, and the normal force if it was recorded in shear or torsion.

    Parameters
    ----------
    row : mapping
        Of the study table, defaults filled in.
    record : Record
        Of the sample.
    tables : Tables
        Response of what was tested; tests with the same one share it.
    shape : IdealShape
        The idealised shape.
    hold_out : sequence of mapping
        Selections of the study's settings.
    """
    tests: list[Specimen] = []
    has_normal = row["mode"] in SHEARED_MODES and record.force_normal is not None
    for channel in (FORCE, NORMAL) if has_normal else (FORCE,):
        test = Specimen.of_record(
            row["sample"],
            row["mode"],
            record,
            _elastic(tables, row["mode"], channel, shape),
            channel,
            held_out=np.asarray(held_out(record, row, shape.height, channel, hold_out)),
            partner=tests[0] if tests else None,
            piece=row["specimen"],
            bond=float(np.nan_to_num(log_force(tables.bond))) if tables.bond else 0.0,
            material_z=int(row.get("material_z", 0)),
            material_x=int(row.get("material_x", 0)),
        )
        tests.append(test)
    return tests
