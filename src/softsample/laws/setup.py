"""From the files of a group to tests with their responses."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from softsample.holdout import held_out
from softsample.laws.candidates import Candidate
from softsample.laws.response import HomogeneousResponse
from softsample.laws.simulate import SimulatedResponse
from softsample.laws.test import LawTest, Response
from softsample.records import Record
from softsample.response.curves import ResponseCurves
from softsample.response.unit import Test


def simulated(
    test: Test,
    travel: float,
    uniform: HomogeneousResponse,
    alpha: Sequence[float],
    known: tuple[pd.DataFrame, Mapping[str, Any]],
    mu1_fraction: float,
) -> SimulatedResponse:
    """Response of a piece by runs on a coarse mesh, at the level of the study's mesh.

    Parameters
    ----------
    test : tuple
        Model of the coarse mesh and what holds it.
    travel : float
        Largest displacement of the records [m].
    uniform : HomogeneousResponse
        Test of the ideal shape without friction.
    alpha : sequence of float
        Exponents of the study.
    known : tuple
        Response at these exponents on the study's mesh, and its report.
    mu1_fraction : float
        Calibrated modulus fraction, at which both meshes are compared.
    """
    curves, report = known
    reached = report["reached"] * travel
    found = SimulatedResponse(*test, reached, report["loading_time_s"], uniform)
    coarse = found.simulate(Candidate.of_pair(alpha), np.array([mu1_fraction]))
    fine = ResponseCurves.of_table(curves, uniform.mode)
    found.anchor_to(fine.force_per_mu(mu1_fraction, found.grid), coarse)
    return found


def tests_of(
    rows: Sequence[Mapping[str, str]],
    records: Sequence[Record],
    responses: Sequence[Response],
    heights: Sequence[float],
    scale_errors: Sequence[float],
    hold_out: Sequence[Mapping[str, Any]],
) -> list[LawTest]:
    """Tests of a group.

    Parameters
    ----------
    rows, records, responses, heights, scale_errors : sequence
        Of each sample: row with defaults filled in, record, response, height [m], standard
        deviation of the response's scale as a part of it.
    hold_out : sequence of mapping
        Selections of the study's settings.
    """
    return [
        LawTest.of(
            row,
            record,
            np.asarray(held_out(record, row, height, "force", hold_out)),
            response,
            height,
            stated=not (row.get("image") or row.get("surface")),
            scale_error=scale_error,
        )
        for row, record, response, height, scale_error in zip(
            rows, records, responses, heights, scale_errors, strict=True
        )
    ]


def confirmed(
    response: SimulatedResponse,
    candidate: Candidate,
    fitted: Mapping[str, Any],
    curves: pd.DataFrame,
) -> list[dict[str, Any]]:
    """Run a fitted law on the study's mesh and compare with what the fit took for its force.

    Parameters
    ----------
    response : SimulatedResponse
        Of the study's mesh.
    candidate : Candidate
    fitted : mapping
        `law_report` of it.
    curves : DataFrame
        `group_report` of the samples that share the piece.

    Returns
    -------
    list of dict
        `sample`, `law`, `difference_percent` (largest, of the peak force), `elements`.
    """
    force = fitted["mu_pa"] * response.simulate(candidate, np.array(list(fitted["shape"].values())))
    rows = []
    for sample, table in curves[curves["law"] == candidate.name].groupby("sample", sort=False):
        way = np.abs(table["displacement_mm"].to_numpy()) * 1e-3
        there = way <= response.travel * (1.0 + 1e-9)
        gap = np.abs(table["model_N"].to_numpy()) - np.interp(way, response.grid, force)
        rows.append(
            {
                "sample": sample,
                "law": candidate.name,
                "difference_percent": 100.0 * float(np.abs(gap[there]).max() / force.max()),
                "elements": len(response.model.mesh.hexes),
            }
        )
    return rows
