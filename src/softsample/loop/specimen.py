"""One test of one sample as the loop sees it: record, phases, elastic curves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from softsample.calibration.curves import CurveFamily
from softsample.constitutive.ogden import OgdenMaterial, compressibility
from softsample.loop.changes import for_all_mixtures, read_changes
from softsample.protocol import denoised, phases, travel_sign

Array = NDArray[np.float64]


SMOOTHED_S = 2.0
"""Length of the cubics that smooth a force [s]."""

CURVED = 0.2
"""Last part of a curve whose bend goes on beyond its end."""

LEAST_PART = 0.05
"""What is left of a force at least when the Poisson's ratio changes."""

FINER = 8
"""Points for each one of a simulated curve."""


def blocks(values: Array, size: int) -> Array:
    """Means (n // size, ...) of consecutive groups of `size` samples; the rest is left out."""
    n = len(values) // size
    return np.asarray(values[: n * size].reshape(n, size, *values.shape[1:]).mean(axis=1))


@dataclass(frozen=True, eq=False)
class Elastic:
    """Force of the elastic model per shear modulus, and how it changes with the model.

    Parameters
    ----------
    family : CurveFamily
        Curves for all mixtures r = mu1 / mu.
    variants : mapping of CurveFamily or (n,) float64
        Change of the force per modulus [m2] when the model is changed by the step that the variant
        is named after, for all mixtures; one curve on the family's displacements if it is the same
        for all.
    contact : bool
        Whether the platen can leave the sample: no force before zero travel.
    poisson_ratio : float
        Of the model; changes of it go from there.
    """

    family: CurveFamily
    variants: Mapping[str, CurveFamily | Array] = field(default_factory=dict)
    contact: bool = False
    poisson_ratio: float = 0.49

    @classmethod
    def of_tables(
        cls,
        mode: str,
        curves: pd.DataFrame,
        changes: Sequence[pd.DataFrame],
        solid: OgdenMaterial,
        real: pd.DataFrame | None = None,
    ) -> Self:
        """From the files of the workflow; in compression without the roughness of their curves.

        Parameters
        ----------
        mode : str
            Of the sample's test.
        curves : DataFrame
            Its curve family.
        changes : sequence of DataFrame
            Its changes by variants.
        solid : OgdenMaterial
            With which the changes were simulated.
        real : DataFrame, optional
            Curve family of the real geometry, if the model is the cuboid.
        """

        def read(table: pd.DataFrame) -> CurveFamily:
            found = CurveFamily.of_table(table, mode)
            return found.smoothed() if mode == "compression" else found

        family = read(curves)
        variants: dict[str, CurveFamily | Array] = {}
        for table in changes:
            variants |= for_all_mixtures(
                read_changes(table, family, mode), family, solid.mu1_fraction
            )
        if real is not None:
            variants["real_geometry"] = read(real).less(family)
        return cls(family, variants, mode == "compression", solid.poisson_ratio)

    @cached_property
    def grain(self) -> float:
        """Error from point to point of a simulated curve, as a part of its peak.

        That of the real geometry counts where the model may turn to it.
        """
        curves, difference = self.family, self.variants.get("real_geometry")
        peaks = np.array([np.abs(curves.curve(r)).max() for r in curves.fractions])
        own = float(np.mean(curves.grain / peaks))
        if not isinstance(difference, CurveFamily):
            return own
        real = [np.abs(curves.curve(r) + difference.curve(r)).max() for r in difference.fractions]
        return float(np.hypot(own, np.mean(difference.grain / np.array(real))))

    @cached_property
    def _fine(self) -> tuple[CurveFamily, dict[str, CurveFamily]]:
        """Family and variants on a grid so fine that chords of the stiffening curve do not show."""
        return self.family.refined(FINER), {
            name: self._as_family(change).refined(FINER) for name, change in self.variants.items()
        }

    def _as_family(self, change: CurveFamily | Array) -> CurveFamily:
        if isinstance(change, CurveFamily):
            return change
        return CurveFamily(np.array([0.5]), self.family.displacement, change[None])

    def force_per_mu(self, mixture: float, travel: Array) -> Array:
        """Force along the travel per shear modulus [m2] at travels [m]."""
        return self._beyond(self._fine[0].curve(mixture), travel)

    def change_per_mu(self, variant: str, mixture: float, travel: Array) -> Array:
        """Change of that force [m2] by one step of a variant; none where it was not simulated."""
        if variant not in self.variants:
            return np.zeros_like(travel)
        return self._beyond(self._fine[1][variant].curve(mixture), travel)

    def softer_part(self, mixture: float, travel: Array, times: Array | float) -> Array:
        """Change of that force, as a part of it, if the modulus over the bulk modulus is another.

        `times` the model's, a number or (n,). Compliances add: one over the force goes with that
        quotient, on a parabola through the model and the runs with Poisson's ratios lower by 0.02
        and 0.04. At 0.493 in place of 0.49 it is within 15 % of the change of a run of its own.
        """
        force = self.force_per_mu(mixture, travel)
        own, *others = (compressibility(self.poisson_ratio - less) for less in (0.0, 0.02, 0.04))
        x, y = np.asarray(times) - 1.0, []
        for step in ("0.02", "0.04"):
            change = self.change_per_mu(f"poisson_{step}_less", mixture, travel)
            part = np.divide(change, force, out=np.zeros_like(force), where=force != 0.0)
            y.append(1.0 / np.maximum(1.0 + part, LEAST_PART) - 1.0)
        a, b = (other / own - 1.0 for other in others)
        more = x * ((b - x) / (b - a) * y[0] / a - (a - x) / (b - a) * y[1] / b)
        return np.asarray(1.0 / np.maximum(1.0 + more, LEAST_PART) - 1.0)

    def ratio_change_per_mu(self, mixture: float, travel: Array, poisson_ratio: float) -> Array:
        """Change of that force [m2] by another Poisson's ratio than the model's."""
        times = compressibility(poisson_ratio) / compressibility(self.poisson_ratio)
        return self.force_per_mu(mixture, travel) * self.softer_part(mixture, travel, times)

    @cached_property
    def _parabola(self) -> Array:
        """Slope and bend (2, n) at the end of a curve, from its last part, per point of it."""
        before = self._fine[0].displacement - self._fine[0].displacement[-1]
        late = before > CURVED * before[0]
        return np.linalg.pinv(np.stack([late * before, late * before**2], axis=1))

    def _beyond(self, curve: Array, travel: Array) -> Array:
        """Interpolation; beyond the end on a parabola, before zero straight on, or no contact."""
        grid = self._fine[0].displacement
        inside = np.interp(travel, grid, curve)
        beyond = np.maximum(travel - grid[-1], 0.0)
        if beyond.any():
            slope, bend = self._parabola @ (curve - curve[-1])
            inside = inside + (slope + bend * beyond) * beyond
        if self.contact:
            return inside
        first = (curve[1] - curve[0]) / (grid[1] - grid[0])
        return inside + first * np.minimum(travel, 0.0)


@dataclass(frozen=True, eq=False)
class Specimen:
    """A test, all along the direction of its travel (loading is positive).

    Parameters
    ----------
    name, mode : str
        Sample and `tension`, `compression` or `shear`.
    time : (n,) float64
        Time [s].
    travel : (n,) float64
        Travel of the platen as the machine reports it [m], its noise taken out.
    force : (n,) float64
        Force of the platen on the sample as the load cell reports it [N].
    phase : (n,) str
        `baseline`, `ramp`, `hold` or `unloading`.
    elastic : Elastic
        The model.
    """

    name: str
    mode: str
    time: Array
    travel: Array
    force: Array
    phase: NDArray[np.str_]
    elastic: Elastic

    @classmethod
    def of_record(cls, name: str, mode: str, record: pd.DataFrame, elastic: Elastic) -> Self:
        """Specimen of a record with columns `time_s`, `displacement_mm`, `force_N`."""
        sign = travel_sign(mode)
        time = record["time_s"].to_numpy(float)
        travel = sign * 1e-3 * record["displacement_mm"].to_numpy(float)
        phase = np.empty(len(time), dtype="<U9")
        for part in phases(time, travel):
            phase[part.samples] = part.kind
        return cls(
            name,
            mode,
            time,
            denoised(time, travel),
            sign * record["force_N"].to_numpy(float),
            phase,
            elastic,
        )

    def reduced(self, size: int) -> Self:
        """The same with groups of `size` samples replaced by their means; the rest is left out."""
        first = slice(0, len(self.time) // size * size, size)
        return replace(
            self,
            time=blocks(self.time, size),
            travel=blocks(self.travel, size),
            force=blocks(self.force, size),
            phase=self.phase[first],
        )

    @property
    def clock(self) -> Array:
        """Time since the record began (n,) [s]."""
        return self.time - self.time[0]

    @property
    def stretches(self) -> list[slice]:
        """Samples of each stretch of one phase, in order."""
        ends = np.flatnonzero(self.phase[1:] != self.phase[:-1]) + 1
        corners = [0, *ends.tolist(), len(self.phase)]
        return [slice(a, b) for a, b in pairwise(corners)]

    @cached_property
    def smooth_force(self) -> Array:
        """Force (n,) [N] with most of its noise taken out, phase by phase so that corners stay."""
        step = float(self.time[-1] - self.time[0]) / (len(self.time) - 1)
        window = max(5, round(SMOOTHED_S / step))
        parts = [self.force[part] for part in self.stretches]
        return np.concatenate(
            [savgol_filter(part, window, 3) if len(part) > window else part for part in parts]
        )

    @property
    def axis_sign(self) -> float:
        """Direction of loading along the machine's axis: -1 in compression."""
        return travel_sign(self.mode)

    @property
    def reach(self) -> float:
        """Largest travel [m]."""
        return float(self.travel.max())

    @property
    def peak(self) -> float:
        """Largest force [N]."""
        return float(np.abs(self.force).max())
