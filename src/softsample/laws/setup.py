"""The samples of a group as tests of elastic laws."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from softsample.fem.boundary import Ends
from softsample.fem.setup import Sample, set_up
from softsample.holdout import held_out
from softsample.laws.candidates import Candidate
from softsample.laws.fit import LawFit
from softsample.laws.response import HomogeneousResponse
from softsample.laws.simulate import SimulatedResponse
from softsample.laws.test import CONTACT_DEPTH, LawTest, Response
from softsample.protocol import travel_sign
from softsample.records import Record, reach
from softsample.response.curves import ResponseCurves
from softsample.response.floor import FloorSettings
from softsample.response.unit import curve_difference
from softsample.shapes import IdealShape

CONFIRMED = ("sample", "law", "difference_percent", "elements")
"""Columns of the table of runs on the study's mesh."""


@dataclass(frozen=True, eq=False)
class SimulatedPiece:
    """A piece whose response has no closed form.

    Parameters
    ----------
    ends : str or float
        As of `softsample.fem.setup.set_up`.
    sample : tuple
        Mesh of the runs with its data.
    report : mapping
        Of the response at the exponents of the study.
    """

    name: str
    ends: Ends
    sample: Sample
    report: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class SamplesOfGroup:
    """The samples of a group.

    Parameters
    ----------
    rows, pieces, records, shapes : sequence
        Of each sample: row with defaults filled in, name of its piece, record, ideal shape.
    sections : mapping
        `solver`, `contact` and `material` of the config.
    """

    rows: Sequence[Mapping[str, str]]
    pieces: Sequence[str]
    records: Sequence[Record]
    shapes: Sequence[IdealShape]
    sections: Mapping[str, Any]

    @property
    def homogeneous(self) -> dict[str, HomogeneousResponse]:
        """Test of the ideal shape of each piece without friction, by piece."""
        poisson_ratio = self.sections["material"]["poisson_ratio"]
        return {
            piece: HomogeneousResponse(shape, row["mode"], poisson_ratio)
            for piece, shape, row in zip(self.pieces, self.shapes, self.rows, strict=True)
        }

    def response(self, piece: SimulatedPiece) -> SimulatedResponse:
        """Response of any law on the mesh of a piece."""
        uniform = self.homogeneous[piece.name]
        own = [r for r, name in zip(self.records, self.pieces, strict=True) if name == piece.name]
        travel = piece.report["reached"] * reach(own, uniform.mode)
        test = set_up(piece.sample, uniform.mode, self.sections, piece.ends)
        return SimulatedResponse(*test, travel, piece.report["loading_time_s"], uniform)

    def anchored(
        self, piece: SimulatedPiece, fine: pd.DataFrame, mu1_fraction: float
    ) -> SimulatedResponse:
        """Response on a coarse mesh of a piece, at the level of the study's mesh.

        Parameters
        ----------
        fine : DataFrame
            Response on the study's mesh, at the exponents of the study.
        mu1_fraction : float
            Calibrated modulus fraction, at which both meshes are compared.
        """
        found = self.response(piece)
        pair = Candidate.of_pair(self.sections["material"]["alpha"])
        fraction, uniform = np.array([mu1_fraction]), found.homogeneous
        coarse = found.simulate(pair, fraction)
        level = ResponseCurves.of_table(fine, uniform.mode).force_per_mu(mu1_fraction, found.grid)
        found.anchor_to(level, coarse, uniform.unit_force(pair, fraction, found.grid))
        return found

    def tests(
        self,
        simulated: Mapping[str, SimulatedResponse],
        element_sizes_mm: Mapping[str, float],
        floor: FloorSettings,
        contact_zero_mm: float,
        hold_out: Sequence[Mapping[str, Any]],
    ) -> list[LawTest]:
        """Tests of all samples.

        Parameters
        ----------
        simulated, element_sizes_mm : mapping
            Of each piece that has no closed form: response, element size of the study's mesh [mm].
        contact_zero_mm : float
            Standard deviation of the highest point of an image [mm].
        hold_out : sequence of mapping
            Selections of the study's settings.
        """
        responses: dict[str, Response] = {**self.homogeneous, **simulated}
        scale_errors = {
            piece: floor.scale_error(simulated[piece].homogeneous.mode, size)
            for piece, size in element_sizes_mm.items()
        }
        return [
            LawTest.of(
                row,
                record,
                np.asarray(held_out(record, row, shape.height, "force", hold_out)),
                responses[piece],
                shape.height,
                stated=not (row.get("image") or row.get("surface")),
                scale_error=scale_errors.get(piece, 0.0),
                contact_zero=1e-3 * contact_zero_mm,
                travel=simulated[piece].travel if piece in simulated else np.inf,
            )
            for row, piece, record, shape in zip(
                self.rows, self.pieces, self.records, self.shapes, strict=True
            )
        ]

    def confirmed(
        self,
        piece: SimulatedPiece,
        candidate: Candidate,
        report: Mapping[str, Any],
        curves: pd.DataFrame,
    ) -> pd.DataFrame:
        """Run a fitted law on the study's mesh and compare with what the fit took for its force.

        Parameters
        ----------
        piece : SimulatedPiece
            With the study's mesh.
        report, curves : mapping, DataFrame
            `group_report` of the group.

        Returns
        -------
        DataFrame
            Of each sample of the piece: `sample`, `law`, `difference_percent` (largest after
            contact, of the peak force), `elements`; none if the law could not be fitted.
        """
        found: list[dict[str, Any]] = []
        if (fitted := report["laws"].get(candidate.name)) is None:
            return pd.DataFrame(found, columns=list(CONFIRMED))
        response, shape = self.response(piece), np.array(list(fitted["shape"].values()))
        response.add(candidate, shape)
        contact = {name: (1e-3 * a, 1e-3 * b) for name, (a, b) in fitted["contact_mm"].items()}
        fit = LawFit(candidate, fitted["mu_pa"], shape, 0.0, contact)
        for row, name, ideal in zip(self.rows, self.pieces, self.shapes, strict=True):
            if name != piece.name:
                continue
            sample, sign = row["sample"], travel_sign(row["mode"])
            table = curves[(curves["law"] == candidate.name) & (curves["sample"] == sample)]
            way = sign * 1e-3 * table["displacement_mm"].to_numpy()
            force = sign * table["model_N"].to_numpy()
            depth = CONTACT_DEPTH * ideal.height if sample in contact else 0.0
            test = LawTest(sample, row["mode"], "", way, force, 0.0, response, depth)
            there = (way > 0.0) & (way <= response.travel * (1.0 + 1e-9))
            difference = curve_difference(fit.force(test)[there], force[there])
            found.append({"sample": sample, "law": candidate.name,
                          "difference_percent": 100.0 * difference,
                          "elements": len(response.model.mesh.hexes)})  # fmt: skip
        return pd.DataFrame(found, columns=list(CONFIRMED))
