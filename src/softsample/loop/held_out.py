"""The channels of a record as tests of the diagnosis, with what the study holds out of them."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from softsample.holdout import held_out
from softsample.loop.specimen import FORCE, NORMAL, Specimen
from softsample.protocol import SHEARED_MODES
from softsample.records import Record
from softsample.response.bond import log_force
from softsample.response.elastic import Elastic, Tables
from softsample.shapes import IdealShape

KEPT = 256
"""Responses that are kept: tests of one piece share theirs, and so what was computed of it."""


@lru_cache(KEPT)
def _elastic(tables: Tables, mode: str, channel: str, shape: IdealShape) -> Elastic:
    return Elastic.of_tables(mode, tables, channel, shape)


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
    tables : Tables
        Response of what was tested; tests with the same one share it.
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
