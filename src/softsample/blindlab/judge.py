"""What the loop is given: its own model of a body, and bare records; what it answers.

The only file of the laboratory that knows the loop, beside `models` and `resample`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np
import pandas as pd

from softsample.blindlab.bodies import ALPHA, POISSON, Body
from softsample.blindlab.models import calibrated
from softsample.blindlab.records import Record as Written
from softsample.blindlab.resample import confidence
from softsample.loop.diagnose import diagnose
from softsample.loop.posed import LoopSettings
from softsample.loop.specimen import Specimen
from softsample.loop.verdict import judgement, recommended
from softsample.records import Record
from softsample.response.changes import for_all_fractions, split_laws
from softsample.response.curves import ResponseCurves, before_zero
from softsample.response.elastic import Elastic
from softsample.response.law_response import LawResponse
from softsample.units import MM

WHEN = ("before", "after")


def elastics(table: pd.DataFrame, body: Body) -> dict[str, Elastic]:
    """The loop's model of a body by mode, from `model_curves`."""
    found = {}
    for mode, of_mode in table.groupby("mode"):
        travel = MM * np.unique(of_mode["displacement_mm"])
        curves = {
            str(name): MM**2 * curve.sort_values("displacement_mm")["area_mm2"].to_numpy()
            for name, curve in of_mode.groupby("curve")
        }
        fractions = sorted((name for name in curves if name[0].isdigit()), key=float)
        response = ResponseCurves(
            np.array([float(r) for r in fractions]),
            travel,
            np.stack([curves.pop(r) for r in fractions]),
            before_zero(str(mode)),
        )
        simulated, runs = split_laws(curves)
        laws = LawResponse(response, body.shape, str(mode), ALPHA, POISSON, runs=runs)
        changes = for_all_fractions(simulated, response, calibrated(body))
        found[str(mode)] = Elastic(
            response, changes, mode == "compression", POISSON, laws, height=body.shape.height
        )
    return found


@dataclass(frozen=True)
class Resolution:
    """What the loop is told that its model does not resolve; mirrors config `blind: noise:`.

    Parameters
    ----------
    floor_percent : float
        Smooth error [% of peak], beside the floor of the experiment.
    fine_percent, history_percent, scale_percent, contact_zero_mm : float
        As of `NoiseSettings`.
    """

    floor_percent: float = 0.1
    fine_percent: float = 0.1
    history_percent: float = 0.1
    scale_percent: float = 0.2
    contact_zero_mm: float = 0.01

    def settings(self, loop: LoopSettings, floor_percent: float) -> LoopSettings:
        """Settings of the loop for experiments with a floor."""
        noise = replace(
            loop.noise,
            floor_percent=float(np.hypot(self.floor_percent, floor_percent)),
            fine_percent=self.fine_percent,
            history_percent=self.history_percent,
            scale_percent=self.scale_percent,
            contact_zero_mm=self.contact_zero_mm,
        )
        return replace(loop, noise=noise)


def answer(
    records: Sequence[Written],
    models: Mapping[str, Elastic],
    settings: LoopSettings,
    bootstraps: int = 0,
) -> dict[str, Any]:
    """The loop's verdict on the records of one experiment, with what the score needs of it.

    `bootstraps` selections on resampled records give the confidence in the first effect's class.
    """
    before = process_time()
    specimens = [
        Specimen.of_record(
            f"test_{k}",
            written.mode,
            Record.of_table(written.table).marked(written.mode),
            models[written.mode],
        )
        for k, written in enumerate(records)
    ]
    found = diagnose(specimens, settings)
    verdict = judgement(found, settings)
    held_out = {
        fold: {when: _fold_error(verdict[f"held_out_{when}"][fold]) for when in WHEN}
        for fold in verdict["held_out_before"]
    }
    return {
        "verdict": verdict["verdict"],
        "effects": [
            {key: effect[key] for key in ("name", "class", "parameters", "evidence")}
            for effect in verdict["effects"]
        ],
        "theta_before": verdict["theta_before"],
        "theta_after": verdict["theta_after"],
        "recommended": recommended(found)["mu"],
        "held_out_percent": held_out,
        "reduced_chi_square": verdict["reduced_chi_square"],
        "path": verdict["path"],
        "not_identifiable": verdict["not_identifiable"],
        "confidence": confidence(found, settings.selection, bootstraps),
        "cpu_s": process_time() - before,
    }


def _fold_error(errors: Mapping[str, Mapping[str, float]]) -> float:
    """Structured error of a fold over its tests [% of peak]."""
    squares = [error["rms_percent_structured"] ** 2 for error in errors.values()]
    return float(np.sqrt(np.mean(squares)))
