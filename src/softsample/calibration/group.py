"""The samples of a group as a calibration sees them, and what its result files hold."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import pandas as pd

from softsample.calibration.measured import MeasuredCurve, fitted_curves
from softsample.calibration.slsqp import AreaObjective, Fit
from softsample.protocol import PRESSED_MODES, travel_sign
from softsample.records import Record
from softsample.response.curves import ResponseCurves


@dataclass(frozen=True)
class GroupCurves:
    """Responses and loadings of the samples of a group that are calibrated.

    Parameters
    ----------
    modes : dict of str
        Mode of every sample of the group, of those that the study holds out as well.
    responses : dict of ResponseCurves
        By sample that is calibrated.
    measured : dict of MeasuredCurve
        Of the same samples.
    """

    modes: dict[str, str]
    responses: dict[str, ResponseCurves]
    measured: dict[str, MeasuredCurve]

    @classmethod
    def of(
        cls,
        rows: Sequence[Mapping[str, str]],
        records: Sequence[Record],
        heights: Sequence[float],
        tables: Iterable[pd.DataFrame],
        hold_out: Sequence[Mapping[str, Any]],
    ) -> Self:
        """From row, record, height [m] and table of unit-modulus curves of each sample.

        Raises as `fitted_curves`, which says what of a loading `hold_out` leaves.
        """
        own = {row["sample"]: row for row in rows}
        measured = fitted_curves(own, records, heights, hold_out)
        responses = {
            name: ResponseCurves.of_table(table, row["mode"])
            for (name, row), table in zip(own.items(), tables, strict=True)
            if name in measured
        }
        return cls({name: row["mode"] for name, row in own.items()}, responses, measured)

    def compared(self, fit: Fit) -> pd.DataFrame:
        """Records and model in the signs of the records.

        Columns `sample`, `displacement_mm`, `measured_N`, `model_N`.
        """
        objective = AreaObjective(self.responses, self.measured)
        parts = []
        for name, loading in self.measured.items():
            sign = travel_sign(self.modes[name])
            columns = {
                "sample": name,
                "displacement_mm": sign * 1e3 * loading.displacement,
                "measured_N": sign * loading.force,
                "model_N": sign * objective.force(name, fit.mu, fit.mu1_fraction),
            }
            parts.append(pd.DataFrame(columns))
        return pd.concat(parts)

    def contact_zero(self, geometry: str, shift: float) -> dict[str, float]:
        """Samples whose contact-point offset is known to within a shift [m] only.

        On the ideal shape contact begins at its top, by definition.
        """
        pressed = [name for name in self.measured if self.modes[name] in PRESSED_MODES]
        return dict.fromkeys(pressed, shift) if geometry == "real" else {}

    def report(
        self, of: Mapping[str, str], material: Mapping[str, Any], fit: Fit
    ) -> dict[str, Any]:
        """What was fitted to what, and the fit.

        Parameters
        ----------
        of : mapping
            `group`, `geometry` and `model`: `ogden1` or `ogden2`.
        material : mapping
            Section of the config.
        """
        return {
            **{name: of[name] for name in ("group", "geometry", "model")},
            "samples": list(self.measured),
            "modes": [self.modes[name] for name in self.measured],
            "held_out": [name for name in self.modes if name not in self.measured],
            "alpha": material["alpha"][: 1 if of["model"] == "ogden1" else 2],
            "poisson_ratio": material["poisson_ratio"],
            **fit.report(),
        }
