"""Calibration on curves whose truth is known; no solver takes part."""

import numpy as np
import pandas as pd
import pytest

from softsample.calibration.bond import other_bond
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import AreaObjective, CalibrationSettings, fit_ogden
from softsample.constitutive.homogeneous import homogeneous_force
from softsample.constitutive.ogden import unit_modulus
from softsample.errors import CalibrationError
from softsample.records import Record
from softsample.response.curves import ResponseCurves

ALPHA = (-8.0, 16.0)
SETTINGS = CalibrationSettings()
FRACTIONS = 1.0 - np.linspace(0.15, 0.95, 6) ** 2
HEIGHT, AREA = 13e-3, 4.6e-4  # of a bar [m], [m2]
TRAVEL = {"T1": 0.25 * HEIGHT, "C1": 0.3 * HEIGHT}


def bar_force(sample, fraction, travel):
    """Force per modulus along the travel [m2] of an incompressible two-term Ogden bar."""
    sign = 1.0 if sample.startswith("T") else -1.0
    stretch = 1.0 + sign * np.asarray(travel) / HEIGHT
    nominal = sum(
        2.0 * share / alpha * (stretch ** (alpha - 1.0) - stretch ** (-0.5 * alpha - 1.0))
        for share, alpha in zip((fraction, 1.0 - fraction), ALPHA, strict=True)
    )
    return sign * AREA * nominal


def family_of(sample, fractions=FRACTIONS):
    travel = np.linspace(0.0, TRAVEL[sample], 200)
    force = np.array([bar_force(sample, r, travel) for r in fractions])
    return ResponseCurves(np.asarray(fractions), travel, force)


def record_of(sample, mu, fraction, noise=0.0, seed=0, count=300):
    """Measured curve; `noise` is a part of the peak force."""
    travel = np.linspace(0.0, TRAVEL[sample], count)
    force = mu * bar_force(sample, fraction, travel)
    rng = np.random.default_rng(seed)
    return MeasuredCurve(travel, force + noise * force.max() * rng.normal(size=count))


def fit(samples, mu, fraction, noise=0.0, fractions=FRACTIONS, settings=SETTINGS):
    families = {sample: family_of(sample, fractions) for sample in samples}
    measured = {
        sample: record_of(sample, mu, fraction, noise, seed) for seed, sample in enumerate(samples)
    }
    return fit_ogden(families, measured, settings)


@pytest.mark.parametrize("samples", [["T1"], ["C1"], ["T1", "C1"]])
@pytest.mark.parametrize(("mu", "fraction"), [(1310.0, 0.91), (420.0, 0.35)])
def test_known_moduli_are_recovered_without_noise(samples, mu, fraction):
    found = fit(samples, mu, fraction)
    assert found.mu == pytest.approx(mu, rel=1e-3)
    assert found.mu1_fraction == pytest.approx(fraction, abs=2e-3)
    report = found.report()
    assert report["mu1_pa"] + report["mu2_pa"] == pytest.approx(found.mu)
    assert max(found.area_error.values()) < 1e-3
    assert found.success
    assert found.active_bounds == []


@pytest.mark.parametrize(("mu", "fraction"), [(1310.0, 0.91), (4200.0, 0.35)])
def test_known_moduli_are_recovered_from_noisy_tension_and_compression(mu, fraction):
    """Noise of 1 % of peak on 300 points: moduli within 1.5 %."""
    found = fit(["T1", "C1"], mu, fraction, noise=0.01)
    assert found.mu == pytest.approx(mu, rel=0.015)
    assert found.mu1_fraction == pytest.approx(fraction, abs=0.02)
    for sample in ("T1", "C1"):
        peak = record_of(sample, mu, fraction).force.max()
        assert found.rms[sample] == pytest.approx(0.01 * peak, rel=0.15)
    assert found.success


def test_every_start_is_on_record():
    found = fit(["T1", "C1"], 1310.0, 0.9)
    assert len(found.starts) == 11
    assert len({(s["from_mu_pa"], s["from_mu1_fraction"]) for s in found.starts}) == 11
    best = min(found.starts, key=lambda s: s["area_error_percent"])
    assert (best["to_mu_pa"], best["to_mu1_fraction"]) == (found.mu, found.mu1_fraction)
    for start in found.starts:
        assert start["iterations"] > 0
        assert start["evaluations"] > start["iterations"]
        assert start["message"]
    report = found.report()
    assert report["iterations"] == sum(s["iterations"] for s in found.starts)
    assert report["verdict"] == "converged"
    assert report["mu1_pa"] + report["mu2_pa"] == pytest.approx(report["mu_pa"])


@pytest.mark.parametrize(
    ("mu", "fraction", "settings", "bound", "finding"),
    [
        (900.0, 0.5, CalibrationSettings(mu_pa_max=800.0), "mu at its maximum", "drive mu at its"),
        (900.0, 0.5, CalibrationSettings(mu_pa_min=1000.0), "mu at its minimum", "drive mu at its"),
        (900.0, 0.999, SETTINGS, "mu1_fraction at its maximum", "second term (mu1/mu = 1)"),
        (900.0, 0.01, SETTINGS, "mu1_fraction at its minimum", "second term (mu1/mu = 0)"),
    ],
)
def test_optimum_on_a_bound_is_said_and_not_trusted(mu, fraction, settings, bound, finding):
    found = fit(["C1"], mu, fraction, settings=settings)
    assert bound in found.active_bounds
    assert not found.success
    assert found.report()["verdict"] == found.finding
    assert found.finding.startswith("these data d")
    assert finding in found.finding


def test_a_term_is_found_beside_one_that_is_a_thousand_times_as_stiff():
    """A strip of rubber at twice its length: a term of exponent 16 has nothing to do with it.

    Far from all of it such a term swells the solid, whose Poisson's ratio is not 0.5.
    """
    fractions, strain = np.linspace(0.0, 1.0, 11), np.linspace(0.0, 1.0, 200)
    solids = [unit_modulus(r, ALPHA, 0.49, 1.0) for r in fractions]
    force = np.array([AREA * homogeneous_force("tension", strain, solid) for solid in solids])
    stretch = 1.0 + strain
    rubber = MeasuredCurve(HEIGHT * strain, 900.0 * AREA * (stretch - stretch**-2))
    families = {"T1": ResponseCurves(fractions, HEIGHT * strain, force)}
    found = fit_ogden(families, {"T1": rubber}, SETTINGS)
    assert found.mu1_fraction > 0.999
    assert found.mu == pytest.approx(900.0, rel=0.3)


def test_a_model_that_misses_a_record_does_not_suit_it():
    """A force that grows with the sixth power of displacement, beside tension as it should be."""
    families = {sample: family_of(sample) for sample in ("T1", "C1")}
    measured = {sample: record_of(sample, 900.0, 0.5) for sample in families}
    assert fit_ogden(families, measured, SETTINGS).finding is None
    travel = measured["C1"].displacement
    late = measured["C1"].force[-1] * (travel / travel[-1]) ** 6
    found = fit_ogden(families, measured | {"C1": MeasuredCurve(travel, late)}, SETTINGS)
    missed = 100.0 * found.area_error["C1"]
    assert f"the model does not suit C1: {missed:.0f} % of its area is missed" in found.finding


def test_one_term_has_one_variable():
    found = fit(["C1"], 1500.0, 1.0, noise=0.01, fractions=np.array([1.0]))
    assert found.mu == pytest.approx(1500.0, rel=5e-3)
    assert found.mu1_fraction == 1.0
    assert found.report()["mu2_pa"] == 0.0
    assert len(found.starts) == 3
    assert found.success


def test_one_term_of_two_term_data_balances_the_areas():
    """What the wrong model gives is still the optimum: no other modulus has less area."""
    families = {"C1": family_of("C1", np.array([1.0]))}
    measured = {"C1": record_of("C1", 1500.0, 0.6)}
    found = fit_ogden(families, measured, SETTINGS)
    objective = AreaObjective(families, measured)
    areas = [objective(mu, 1.0) for mu in np.linspace(0.9, 1.1, 41) * found.mu]
    assert min(areas) > objective(found.mu, 1.0) * (1.0 - 1e-6)
    assert found.area_error["C1"] > 0.005


def test_range_is_what_all_families_share():
    families = {"T1": family_of("T1", FRACTIONS[FRACTIONS < 0.8]), "C1": family_of("C1")}
    measured = {s: record_of(s, 1000.0, 0.9) for s in families}
    found = fit_ogden(families, measured, SETTINGS)
    assert found.mu1_fraction <= FRACTIONS[FRACTIONS < 0.8].max() + 1e-12
    assert "mu1_fraction at its maximum" in found.active_bounds


@pytest.mark.parametrize(
    ("force", "other", "area"),
    [
        ([0.0, 1.0, 2.0], [0.0, 0.0, 0.0], 2.0),  # triangle
        ([2.0, 2.0, 2.0], [-1.0, -1.0, -1.0], 6.0),  # rectangle
        ([0.0, 3.0, 0.0], [1.0, 1.0, 1.0], 5.0 / 3.0),  # crosses twice, between points
        ([-1.0, 1.0, -1.0], [0.0, 0.0, 0.0], 1.0),
        ([1.0, 0.0, -1.0], [0.0, 0.0, 0.0], 1.0),  # crosses on a point
        ([0.5, 0.7, 0.9], [0.5, 0.7, 0.9], 0.0),
    ],
)
def test_area_is_that_of_the_polygons(force, other, area):
    curve = MeasuredCurve(np.array([0.0, 1.0, 2.0]), np.array(force))
    assert curve.area_between(np.array(other)) == pytest.approx(area, abs=1e-15)


def test_area_does_not_depend_on_the_order_of_points():
    """Noise of the displacement reading makes neighbours swap places."""
    travel, force = np.array([0.0, 3.0, 1.0, 4.0]), np.array([0.0, 2.0, 5.0, 4.0])
    swapped = MeasuredCurve(travel, force)
    ordered = MeasuredCurve(travel[[0, 2, 1, 3]], force[[0, 2, 1, 3]])
    assert swapped.area == pytest.approx(ordered.area)
    assert ordered.area == pytest.approx(2.5 + 7.0 + 3.0)
    assert swapped.travel == 4.0


def test_objective_is_the_sum_of_areas_over_the_measured_areas():
    travel = np.array([0.0, 1.0, 2.0])
    unit = ResponseCurves(np.array([1.0]), travel, np.array([[0.0, 1.0, 2.0]]))
    measured = {
        "a": MeasuredCurve(travel, np.array([0.0, 3.0, 6.0])),  # area 6
        "b": MeasuredCurve(travel, np.array([0.0, 1.0, 2.0])),  # area 2
    }
    objective = AreaObjective({"a": unit, "b": unit}, measured)
    assert objective(2.0, 1.0) == pytest.approx((2.0 + 2.0) / 8.0)
    assert objective(3.0, 1.0) == pytest.approx(4.0 / 8.0)
    assert objective(1.0, 1.0) == pytest.approx(4.0 / 8.0)


def test_interpolation_is_exact_for_polynomials_of_the_root():
    """Five modulus fractions carry any polynomial of degree four in sqrt(1 - r)."""
    travel = np.linspace(0.0, 1.0, 4)
    rng = np.random.default_rng(1)
    coefficients = rng.normal(size=(5, 4))

    def force(r):
        return sum(c * (1.0 - r) ** (0.5 * k) for k, c in enumerate(coefficients))

    fractions = np.array([0.2, 0.4, 0.6, 0.8, 0.95])
    family = ResponseCurves(fractions, travel, np.array([force(r) for r in fractions]))
    for r in (0.2, 0.33, 0.77, 0.949, 0.95):
        np.testing.assert_allclose(family.force_per_mu(r, travel), force(r), atol=1e-13)
    assert family.bounds == (0.2, 0.95)


def test_between_its_points_a_curve_bends():
    """Chords of a stiffening curve are above it; the spline's error is less than a tenth."""
    coarse = np.linspace(0.0, TRAVEL["C1"], 20)
    force = bar_force("C1", 0.5, coarse)
    family = ResponseCurves(np.array([0.5]), coarse, force[None])
    between = 0.5 * (coarse[:-1] + coarse[1:])
    exact = bar_force("C1", 0.5, between)
    chord, ours = 0.5 * (force[:-1] + force[1:]), family.force_per_mu(0.5, between)
    assert np.abs(ours - exact).max() < 0.1 * np.abs(chord - exact).max()


def test_a_curve_goes_on_beyond_its_end():
    """Noise of the displacement reading, and a fitted contact point, go a little further."""
    family = family_of("T1")
    ratio = np.array([1.0, 1.01, 1.1])
    found = family.force_per_mu(0.5, ratio * TRAVEL["T1"])
    off = np.abs(found / bar_force("T1", 0.5, ratio * TRAVEL["T1"]) - 1.0)
    assert np.all(off < [1e-9, 1e-3, 1.5e-2])  # the curve itself rises by 3 % and 32 %


@pytest.mark.parametrize(("mode", "sign"), [("tension", 1.0), ("compression", -1.0)])
def test_ramp_of_a_record_is_taken_along_the_travel(mode, sign):
    """2 s baseline, ramp of 3 mm at 0.3 mm/s, hold of 5 s; signs as in files."""
    time = np.arange(0.0, 17.0, 0.1)
    travel = np.clip(0.3 * (time - 2.0), 0.0, 3.0)
    table = pd.DataFrame(
        {"time_s": time, "displacement_mm": sign * travel, "force_N": sign * 0.5 * travel}
    )
    curve = MeasuredCurve.of_record(Record.of_table(table).marked(mode), mode)
    assert curve.travel == pytest.approx(3e-3)
    assert len(curve.force) == pytest.approx(101, abs=3)
    np.testing.assert_allclose(curve.force, 500.0 * curve.displacement, atol=1e-12)


def test_curves_that_do_not_belong_together_are_refused():
    travel = np.linspace(0.0, 1.0, 4)
    with pytest.raises(CalibrationError, match=r"\(2, 3\) forces for 2 modulus fractions at 4"):
        ResponseCurves(np.array([0.2, 0.9]), travel, np.zeros((2, 3)))
    with pytest.raises(CalibrationError, match="not finite; simulate the sample again"):
        ResponseCurves(np.array([0.2]), travel, np.array([[0.0, 1.0, np.nan, 2.0]]))


def test_samples_without_partner_are_refused():
    with pytest.raises(CalibrationError, match=r"\['T1'\] against records of \['C1'\]"):
        AreaObjective({"T1": family_of("T1")}, {"C1": record_of("C1", 1e3, 0.5)})
    with pytest.raises(CalibrationError, match="needs both"):
        AreaObjective({}, {})


@pytest.mark.parametrize("force", [0.0, np.nan])
def test_records_without_force_are_refused(force):
    measured = {"T1": MeasuredCurve(np.linspace(0.0, 1e-3, 5), np.full(5, force))}
    with pytest.raises(CalibrationError, match="ramp of T1 has no finite area.*check its record"):
        fit_ogden({"T1": family_of("T1")}, measured, SETTINGS)


def test_families_without_a_common_fraction_are_refused():
    families = {
        "T1": family_of("T1", FRACTIONS[FRACTIONS < 0.5]),
        "C1": family_of("C1", FRACTIONS[FRACTIONS > 0.5]),
    }
    measured = {s: record_of(s, 1e3, 0.5) for s in families}
    with pytest.raises(CalibrationError, match=r"\['C1', 'T1'\] share no range of mu1_fraction"):
        fit_ogden(families, measured, SETTINGS)


@pytest.mark.parametrize("rule", ["within_depth", "contact"])
def test_moduli_with_the_other_bond_are_those_of_records_that_it_made(rule):
    """Tension whose force by contact is 10 % less at the start and 30 % less at the end."""
    mu, fraction = 1200.0, 0.4
    tension, compression = (record_of(sample, mu, fraction) for sample in ("T1", "C1"))
    ratio = np.linspace(0.9, 0.7, 60)
    place = np.linspace(0.0, tension.travel, 61)[1:]
    report = {"rule": rule, "displacement_mm": 1e3 * place, "force_ratio": ratio}
    other = ratio if rule == "within_depth" else 1.0 / ratio
    made = tension.force * np.interp(tension.displacement, place, other)
    records = {"T1": MeasuredCurve(tension.displacement, made), "C1": compression}
    families = {sample: family_of(sample) for sample in records}
    found = other_bond(families, records, {"T1": report}, SETTINGS)
    assert found["mu_pa"] == pytest.approx(mu, rel=1e-3)
    assert found["mu1_fraction"] == pytest.approx(fraction, abs=1e-3)
    unknown = {"T1": {**report, "force_ratio": None}}
    assert other_bond(families, records, unknown, SETTINGS) is None
