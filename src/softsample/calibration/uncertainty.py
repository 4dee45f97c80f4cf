"""What a calibrated modulus is worth: scatter of the record, and how errors of the curves reach it.

The residual of a calibration is no white noise: neighbours in a record share the model's misfit and
the slow noise of the load cell. Its correlation time gives the number of points that count, and the
length of the blocks in which it is resampled.

References
----------
C. J. Geyer, Statist. Sci. 7 (1992) 473, doi:10.1214/ss/1177011137 (initial positive sequence).
D. N. Politis, J. P. Romano, J. Am. Stat. Assoc. 89 (1994) 1303, doi:10.1080/01621459.1994.10476870.
A. Patton, D. N. Politis, H. White, Econometric Reviews 28 (2009) 372,
doi:10.1080/07474930802459016 (length of the blocks).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from softsample.arrays import Array
from softsample.calibration.likelihood import MODULI, AreaLikelihood, moduli
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import AreaObjective, CalibrationSettings, Fit, Search
from softsample.response.curves import Curves, Scaled

STEPS = 1e-4, 0.1
"""Least and largest first step of a profile, as a part of the modulus."""

SEED = 1
"""Seed of the bootstrap: the same records give the same intervals."""


@dataclass(frozen=True)
class UncertaintySettings:
    """Statistics of a fit; mirrors config `uncertainty:`.

    Parameters
    ----------
    confidence : float
        Of every interval, e.g. 0.9.
    draws : int
        Bootstrap replicates.
    """

    confidence: float = 0.9
    draws: int = 200


def band_report(mu: float, scales: Mapping[str, float]) -> dict[str, float]:
    """The modulus within the uncertainty of the surface.

    Parameters
    ----------
    mu : float
        Calibrated modulus [Pa].
    scales : mapping of float
        Factor that brings the model closest to the record, on the `inner`, `real` and `outer`
        surface.

    Returns
    -------
    dict
        `mu_low_pa`, `mu_pa`, `mu_high_pa`, and the ends in percent of the modulus.
    """
    moduli = {name: mu * scale / scales["real"] for name, scale in scales.items()}
    low, own, high = min(moduli.values()), moduli["real"], max(moduli.values())
    return {
        "mu_low_pa": low,
        "mu_pa": own,
        "mu_high_pa": high,
        "low_percent": 100.0 * (low / own - 1.0),
        "high_percent": 100.0 * (high / own - 1.0),
    }


@dataclass(frozen=True)
class Correlation:
    """How long a series remembers.

    Parameters
    ----------
    time : float
        Integrated autocorrelation time in samples, 1 for white noise: the variance of the mean is
        `time` times that of independent samples.
    block : float
        Mean length in samples of the blocks for a stationary bootstrap, n / 3 at most.
    """

    time: float
    block: float


def correlation(series: Array) -> Correlation:
    """Correlation of a series (n,), from its autocorrelations while pairs of them are positive.

    The blocks are those that suit a first-order autoregressive series of the same time best.
    """
    n = len(series)
    centred = series - series.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    rho = np.fft.irfft(spectrum)[:n]
    rho /= rho[0]
    pairs = rho[: n - n % 2].reshape(-1, 2).sum(axis=1)
    end = 2 * int(np.argmin(pairs > 0.0)) if (pairs <= 0.0).any() else n - n % 2
    time = max(1.0, 1.0 + 2.0 * float(rho[1:end].sum()))
    block = ((time**2 - 1.0) / (2.0 * time)) ** (2 / 3) * n ** (1 / 3)
    return Correlation(time, float(np.clip(block, 1.0, n / 3)))


def resampled(series: Array, block: float, rng: np.random.Generator) -> Array:
    """One stationary bootstrap of a series (n,): blocks of geometric lengths, wrapped around."""
    n = len(series)
    fresh = rng.random(n) < 1.0 / block
    fresh[0] = True
    first = np.flatnonzero(fresh)
    begin = np.repeat(first, np.diff(np.append(first, n)))
    start = rng.integers(n, size=n)[begin]
    return np.asarray(series[(start + np.arange(n) - begin) % n])


@dataclass(eq=False)
class Uncertainty:
    """Uncertainty of one calibration of the two moduli.

    Parameters
    ----------
    families, measured : dict
        Modelled curves and loading ramps by sample.
    fit : Fit
        Their calibration.
    calibration, settings
        Of the fit, and of its uncertainty.
    """

    families: Mapping[str, Curves]
    measured: Mapping[str, MeasuredCurve]
    fit: Fit
    calibration: CalibrationSettings
    settings: UncertaintySettings

    def __post_init__(self) -> None:
        self.objective = AreaObjective(self.families, self.measured)
        self._optimum = self.fit.mu, self.fit.mu1_fraction
        self.model = {s: self.objective.force(s, *self._optimum) for s in self.measured}
        self.residual = {s: curve.force - self.model[s] for s, curve in self.measured.items()}
        self.correlation = {s: correlation(residual) for s, residual in self.residual.items()}

    def effective_points(self) -> float:
        """Number of independent points of all records."""
        return sum(len(r) / self.correlation[s].time for s, r in self.residual.items())

    def likelihood(self) -> AreaLikelihood:
        """Likelihood of the fit."""
        search = Search(self.objective, self.calibration)
        return AreaLikelihood(search, self.fit, self.effective_points())

    def refit(
        self,
        families: Mapping[str, Curves] | None = None,
        measured: Mapping[str, MeasuredCurve] | None = None,
    ) -> Array:
        """Moduli (3,) of other curves or records, by SLSQP from the optimum."""
        objective = AreaObjective(families or self.families, measured or self.measured)
        search = Search(objective, self.calibration)
        return moduli(*search.unpack(search.descend(search.pack(*self._optimum)).x))

    def bootstrap(self) -> Array:
        """Moduli (draws, 3) of records made of the model and its resampled residual."""
        rng = np.random.default_rng(SEED)
        draws = []
        for _ in range(self.settings.draws):
            measured = {}
            for sample, curve in self.measured.items():
                residual = self.residual[sample] - self.residual[sample].mean()
                noise = resampled(residual, self.correlation[sample].block, rng)
                measured[sample] = replace(curve, force=self.model[sample] + noise)
            draws.append(self.refit(measured=measured))
        return np.array(draws)

    def per_force(self) -> dict[str, Array]:
        """By sample: change of the moduli (3,) [Pa] per percent more modelled force of it."""
        change = {}
        for sample, curves in self.families.items():
            up, down = (
                self.refit({**self.families, sample: Scaled(curves, [scale])})
                for scale in (1.01, 0.99)
            )
            change[sample] = (up - down) / 2.0
        return change

    def per_shift(self, sample: str, shift: float) -> Array:
        """Change of the moduli (3,) [Pa] if contact with `sample` began `shift` [m] earlier."""
        curve = self.measured[sample]
        early, late = (replace(curve, displacement=curve.displacement + d) for d in (shift, -shift))
        up, down = (
            self.refit(measured={**self.measured, sample: moved}) for moved in (early, late)
        )
        return 0.5 * (up - down)

    def report(self, contact_zero: Mapping[str, float]) -> dict[str, Any]:
        """Everything of one fit, units in the names.

        Parameters
        ----------
        contact_zero : dict of float
            By sample: standard deviation of the travel at which contact begins [m].
        """
        draws = self.bootstrap()
        spread = draws.std(axis=0, ddof=1)
        tail = 50.0 * (1.0 - self.settings.confidence)
        percentiles = np.percentile(draws, [tail, 100.0 - tail], axis=0).T
        likelihood, values = self.likelihood(), moduli(*self._optimum)
        rms_of_noise = {
            s: float(np.sqrt(0.5 * np.mean(np.diff(r) ** 2))) for s, r in self.residual.items()
        }
        return {
            "confidence": self.settings.confidence,
            "noise_N": rms_of_noise,
            "correlation_samples": {s: c.time for s, c in self.correlation.items()},
            "block_samples": {s: c.block for s, c in self.correlation.items()},
            "effective_points": self.effective_points(),
            "bootstrap": {
                f"{name}_pa": {"sd": sd, "low": low, "high": high}
                for name, sd, (low, high) in zip(MODULI, spread, percentiles, strict=True)
            },
            "profile": {
                f"{name}_pa": likelihood.profile(
                    name, float(np.clip(sd / value, *STEPS)), self.settings.confidence
                ).ends()
                for name, value, sd in zip(MODULI, values, spread, strict=True)
                if value > 0.0
            },
            "per_percent_of_force": {s: _named(c) for s, c in self.per_force().items()},
            "contact_zero": {
                s: _named(self.per_shift(s, shift)) for s, shift in contact_zero.items()
            },
        }


def _named(values: Array) -> dict[str, float]:
    return {f"{name}_pa": float(value) for name, value in zip(MODULI, values, strict=True)}
