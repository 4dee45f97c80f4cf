"""From the files of a group to tests with their responses."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import SolverSettings
from softsample.holdout import held_out
from softsample.laws.candidates import Candidate
from softsample.laws.response import HomogeneousResponse
from softsample.laws.simulate import SimulatedResponse
from softsample.laws.test import LawTest, Response
from softsample.records import Record, reach
from softsample.response.curves import ResponseCurves
from softsample.response.pieces import MeshedSample
from softsample.shapes import IdealShape

Known = tuple[pd.DataFrame, Mapping[str, Any], Mapping[str, Any]]


def response_of(
    row: Mapping[str, str],
    ends: str | float,
    shape: IdealShape,
    records: Sequence[Record],
    known: Known,
    meshed: Callable[[], MeshedSample] | None,
    given: Mapping[str, Any],
) -> Response:
    """Response of a piece: closed form where it deforms uniformly, else runs of the solver.

    Parameters
    ----------
    row : mapping of str
        Of the study table.
    ends : str or float
        What the ends do on the platens.
    shape : IdealShape
        Idealised shape.
    records : sequence of Record
        Of all samples that share the piece.
    known : tuple
        Response of the study's pair on the study's mesh, the report of it, and the calibration.
    meshed : callable, optional
        Makes the coarse mesh; None for the ideal shape of a homogeneous test.
    given : mapping
        `material`, `solver` and `contact` of the job.
    """
    uniform = HomogeneousResponse(shape, row["mode"], given["material"]["poisson_ratio"])
    if meshed is None:
        return uniform
    curves, report, fit = known
    sample = meshed()
    found = SimulatedResponse(
        sample.model(SolverSettings(**given["solver"])),
        mode_boundary(
            sample.mesh, row["mode"], sample.glued, ContactSettings(**given["contact"]), ends
        ),
        report["reached"] * reach(records, row["mode"]),
        report["loading_time_s"],
        uniform,
    )
    pair, fraction = Candidate.of_pair(given["material"]["alpha"]), fit["mu1_fraction"]
    coarse = found.run(pair, np.array([fraction]))
    fine = ResponseCurves.of_table(curves, row["mode"])
    found.anchor_to(fine.force_per_mu(fraction, found.grid), coarse)
    return found


def tests_of(
    rows: Sequence[Mapping[str, str]],
    records: Sequence[Record],
    responses: Sequence[Response],
    heights: Sequence[float],
    stated: bool,
    hold_out: Sequence[Mapping[str, Any]],
) -> list[LawTest]:
    """Tests of a group.

    Parameters
    ----------
    rows, records, responses, heights : sequence
        Of each sample: row with defaults filled in, record, response, height [m].
    stated : bool
        Whether dimensions were stated in place of an image or a surface.
    hold_out : sequence of mapping
        Selections of the study's settings.
    """
    return [
        LawTest.of(
            row, record, np.asarray(held_out(record, row, height, "force", hold_out)), response,
            height, stated,
        )
        for row, record, response, height in zip(rows, records, responses, heights, strict=True)
    ]  # fmt: skip
