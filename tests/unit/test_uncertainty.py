"""Uncertainty of a calibration against closed forms and against repeated experiments."""

import json

import numpy as np
import pytest

from softsample.calibration.likelihood import MODULI, moduli
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.profile import normal_quantile, profile, profile_interval
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.calibration.uncertainty import (
    Uncertainty,
    UncertaintySettings,
    correlation,
    resampled,
)
from softsample.response.curves import ResponseCurves

SETTINGS = CalibrationSettings()
TRAVEL = np.linspace(0.0, 3e-3, 240)
MU, SLOPE = 1000.0, 0.05  # [Pa], force per modulus and travel [m]
ONE_TERM = ResponseCurves(np.array([1.0]), TRAVEL, SLOPE * TRAVEL[None, :])


def autoregressive(phi, count, rng):
    """Stationary AR(1) of unit variance."""
    noise = rng.normal(size=count)
    noise[1:] *= np.sqrt(1.0 - phi**2)
    for k in range(1, count):
        noise[k] += phi * noise[k - 1]
    return noise


def uncertainty_of(force, draws=60):
    measured = {"S1": MeasuredCurve(TRAVEL, force)}
    fit = fit_ogden({"S1": ONE_TERM}, measured, SETTINGS)
    settings = UncertaintySettings(draws=draws)
    return Uncertainty({"S1": ONE_TERM}, measured, fit, SETTINGS, settings)


MATRIX = np.array([[4.0, 1.5, 0.3], [1.5, 2.0, -0.4], [0.3, -0.4, 1.0]])
BEST = np.array([1.0, -2.0, 0.5])


def quadratic(x):
    return float((x - BEST) @ MATRIX @ (x - BEST)) + 7.0


@pytest.mark.parametrize("index", [0, 1, 2])
def test_profile_of_a_quadratic_is_laplace(index):
    """Its interval is b +- z sqrt(inverse matrix), by hand, and so is the way the others go."""
    covariance = np.linalg.inv(MATRIX)
    sd = np.sqrt(covariance[index, index])
    values = BEST[index] + sd * np.linspace(-3.0, 3.0, 7)
    least, points = profile(quadratic, BEST, index, values, [(-20.0, 20.0)] * 3)
    np.testing.assert_allclose(least, np.linspace(-3.0, 3.0, 7) ** 2, atol=1e-6)
    line = BEST + np.outer(values - BEST[index], covariance[index] / covariance[index, index])
    np.testing.assert_allclose(points, line, atol=1e-3)
    low, high = profile_interval(values, least, BEST[index], 0.9)
    assert low == pytest.approx(BEST[index] - 1.6449 * sd, abs=1e-4 * sd)
    assert high == pytest.approx(BEST[index] + 1.6449 * sd, abs=1e-4 * sd)


def test_profile_respects_the_bounds_of_the_others():
    bounds = [(-20.0, 20.0), (-2.0, -2.0 + 1e-9), (0.5, 0.5 + 1e-9)]
    least, _ = profile(quadratic, BEST, 0, np.array([2.0]), bounds)
    assert least[0] == pytest.approx(4.0, rel=1e-6)


def test_an_end_that_is_not_reached_is_infinite():
    values = np.array([-1.0, 1.0, 2.0])
    least = np.array([0.1, 4.0, 16.0])
    low, high = profile_interval(values, least, 0.0, 0.9)
    assert low == -np.inf
    assert high == pytest.approx(0.5 * normal_quantile(0.9))


def test_quantiles_of_the_normal_distribution():
    assert normal_quantile(0.6826895) == pytest.approx(1.0, rel=1e-6)
    assert normal_quantile(0.9544997) == pytest.approx(2.0, rel=1e-6)


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.9])
def test_correlation_of_an_autoregressive_series(phi):
    """Closed forms: time (1 + phi) / (1 - phi), block (2 phi / (1 - phi^2))^(2/3) n^(1/3)."""
    count = 100_000
    found = correlation(autoregressive(phi, count, np.random.default_rng(1)))
    assert found.time == pytest.approx((1.0 + phi) / (1.0 - phi), rel=0.08)
    block = max(1.0, (2.0 * phi / (1.0 - phi**2)) ** (2 / 3) * count ** (1 / 3))
    assert found.block == pytest.approx(block, rel=0.08 if phi else 1.0)


def test_resampling_keeps_values_and_lengths_of_blocks():
    series = np.arange(10_000.0)
    found = resampled(series, 50.0, np.random.default_rng(3))
    assert set(found) <= set(series)
    breaks = np.count_nonzero((np.diff(found) != 1.0) & (np.diff(found) != -9999.0))
    assert 10_000 / (breaks + 1) == pytest.approx(50.0, rel=0.2)


def test_resampled_means_scatter_as_those_of_the_series():
    phi, count, rng = 0.8, 4000, np.random.default_rng(5)
    series = autoregressive(phi, count, rng)
    block = correlation(series).block
    means = [resampled(series, block, rng).mean() for _ in range(400)]
    assert np.std(means) == pytest.approx(np.sqrt(9.0 / count), rel=0.15)


def covered(phi, blocks):
    """Part of 90 % bootstrap intervals of mu that hold the truth; noise is AR(1)."""
    rng, hits, runs = np.random.default_rng(11), 0, 80
    for _ in range(runs):
        found = uncertainty_of(MU * SLOPE * TRAVEL + 0.002 * autoregressive(phi, 240, rng))
        if not blocks:
            white = type(found.correlation["S1"])(1.0, 1.0)
            found.correlation = {"S1": white}
        half = normal_quantile(0.9) * found.bootstrap()[:, 0].std(ddof=1)
        hits += abs(found.fit.mu - MU) <= half
    return hits / runs


def test_intervals_cover_the_truth_in_correlated_noise():
    """90 % of 80 experiments would be 72 +- 3; blocks of a short record give a little less."""
    assert 0.78 <= covered(0.85, blocks=True) <= 0.98


def test_intervals_without_blocks_would_not():
    assert covered(0.85, blocks=False) < 0.6


def test_profile_agrees_with_the_bootstrap_in_laplace_noise():
    """The likelihood behind the area is that of this noise."""
    noise = np.random.default_rng(2).laplace(scale=0.002, size=240)
    found = uncertainty_of(MU * SLOPE * TRAVEL + noise, draws=200)
    spread = found.bootstrap().std(axis=0, ddof=1)
    curve = found.likelihood().profile("mu", spread[0] / found.fit.mu, 0.9)
    half = normal_quantile(0.9) * spread[0]
    assert curve.low < found.fit.mu < curve.high
    assert 0.5 * (curve.high - curve.low) == pytest.approx(half, rel=0.3)


def test_a_percent_more_force_is_a_percent_less_modulus():
    found = uncertainty_of(MU * SLOPE * TRAVEL + 1e-5 * np.sin(1e4 * TRAVEL))
    np.testing.assert_allclose(found.per_force()["S1"], [-10.0, -10.0, 0.0], rtol=1e-3)


def test_early_contact_by_hand():
    """Area of |mu d - m (d + s)| is least where d + s has the same moment on both sides."""
    shift = 1e-4
    found = uncertainty_of(MU * SLOPE * TRAVEL + 1e-9 * np.sin(1e4 * TRAVEL))

    def modulus(s):
        crossing = np.sqrt(0.5 * ((TRAVEL[-1] + s) ** 2 + max(s, 0.0) ** 2)) - s
        return MU * crossing / (crossing + s)

    # moved beyond the end of the curve the force stays, which the straight line above does not
    expected = 0.5 * (modulus(shift) - modulus(-shift))
    assert found.per_shift("S1", shift)[0] == pytest.approx(expected, rel=0.05)


def test_report_of_two_samples_is_complete_and_plain():
    fractions = np.array([0.1, 0.5, 0.9])
    families = {
        name: ResponseCurves(
            fractions, TRAVEL, SLOPE * TRAVEL * (1.0 + bend * np.outer(fractions, TRAVEL))
        )
        for name, bend in (("T1", -100.0), ("C1", 200.0))
    }
    rng = np.random.default_rng(4)
    measured = {
        name: MeasuredCurve(TRAVEL, family.force(TRAVEL, MU, 0.6) + 2e-4 * rng.normal(size=240))
        for name, family in families.items()
    }
    fit = fit_ogden(families, measured, SETTINGS)
    found = Uncertainty(families, measured, fit, SETTINGS, UncertaintySettings(draws=20))
    report = json.loads(json.dumps(found.report({"C1": 6e-5}), allow_nan=False))
    assert report == json.loads(json.dumps(found.report({"C1": 6e-5})))  # seeded
    assert report["noise_N"]["T1"] == pytest.approx(2e-4, rel=0.15)
    assert report["effective_points"] == pytest.approx(480.0, rel=0.4)
    assert set(report["per_percent_of_force"]) == {"T1", "C1"}
    assert set(report["contact_zero"]) == {"C1"}
    for name, value in zip(MODULI, moduli(fit.mu, fit.mu1_fraction), strict=True):
        interval = report["profile"][f"{name}_pa"]
        assert interval["low"] < value < interval["high"]
    both = np.sum([c["mu_pa"] for c in report["per_percent_of_force"].values()])
    assert both == pytest.approx(-0.01 * fit.mu, rel=0.02)


def test_the_interval_of_an_absent_term_has_no_lower_end():
    """Its upper end is where a scan of all moduli reaches the deviance of the confidence."""
    fractions, rng = np.linspace(0.0, 1.0, 9), np.random.default_rng(1)
    bend = np.outer(fractions, TRAVEL) / TRAVEL[-1]
    curves = {"S1": ResponseCurves(fractions, TRAVEL, SLOPE * TRAVEL * (1.0 + bend))}
    force = MU * SLOPE * TRAVEL * (1.0 - 0.01 * TRAVEL / TRAVEL[-1]) + 0.002 * rng.normal(size=240)
    measured = {"S1": MeasuredCurve(TRAVEL, force)}
    fit = fit_ogden(curves, measured, SETTINGS)
    assert fit.mu1_fraction < 1e-6
    found = Uncertainty(curves, measured, fit, SETTINGS, UncertaintySettings(draws=20))
    interval = found.likelihood().profile("mu1", 0.1, 0.9).ends()
    assert found.report({})["profile"].get("mu1_pa", interval)["low"] is None
    assert interval["low"] is None

    def deviance(term):
        moduli = fit.mu * np.linspace(0.9, 1.1, 801)
        least = min(found.objective(mu, term / mu) for mu in moduli)
        return (
            2.0
            * found.effective_points()
            * np.log(least / found.objective(fit.mu, fit.mu1_fraction))
        )

    assert deviance(0.95 * interval["high"]) < normal_quantile(0.9) ** 2
    assert deviance(1.05 * interval["high"]) > normal_quantile(0.9) ** 2
