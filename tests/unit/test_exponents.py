"""Free exponents and direct simulation on closed-form bars; no fit knows its answer beforehand."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from softsample.calibration.direct import SimulatedCurves, simulated_curves
from softsample.calibration.exponents import (
    ExponentFamily,
    cardinal,
    common_exponents,
    exponent_report,
    profile_table,
)
from softsample.calibration.group import GroupCurves
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import STARTS_PER_PARAMETER, CalibrationSettings, fit_ogden
from softsample.calibration.uncertainty import Uncertainty, UncertaintySettings
from softsample.constitutive.homogeneous import homogeneous_force
from softsample.constitutive.ogden import unit_modulus
from softsample.errors import CalibrationError, InputError
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.cuboid import mesh_cuboid
from softsample.report.exponents import common_table, exponent_table
from softsample.response.curves import ResponseCurves
from softsample.response.exponents import (
    ExponentSettings,
    curves_table,
    exponent_grid,
    simulate_exponents,
)

HEIGHT, AREA = 13e-3, 4.6e-4  # of a bar [m], [m2]
TRAVEL = {"T1": 0.25 * HEIGHT, "C1": 0.3 * HEIGHT}
MODES = {"T1": "tension", "C1": "compression"}
SETTINGS = ExponentSettings((-12.0, -4.0), (8.0, 20.0))
GRID = exponent_grid(SETTINGS, (-8.0, 16.0))


@pytest.fixture(autouse=True)
def two_starts(monkeypatch):
    """Of each of four parameters, 16 in all in place of 81."""
    monkeypatch.setitem(STARTS_PER_PARAMETER, "family", 2)


def bar(sample, travel, fraction, alpha):
    """Force per modulus along the travel [m2] of an incompressible two-term Ogden bar."""
    sign = 1.0 if sample.startswith("T") else -1.0
    stretch = 1.0 + sign * np.asarray(travel) / HEIGHT
    nominal = sum(
        2.0 * share / a * (stretch ** (a - 1.0) - stretch ** (-0.5 * a - 1.0))
        for share, a in zip((fraction, 1.0 - fraction), alpha, strict=True)
    )
    return sign * AREA * nominal


def family_of(sample, grid=GRID):
    travel = np.linspace(0.0, TRAVEL[sample], 80)
    runs = [bar(sample, travel, r, alpha) for r, *alpha in product(*grid.values())]
    shape = [len(nodes) for nodes in grid.values()]
    force = np.reshape(runs, (*shape, len(travel)))
    # the homogeneous test is one of a higher bar, so that it has not the force's form
    return ExponentFamily(
        grid, travel, force, lambda r, *alpha: bar(sample, 0.8 * travel, r, alpha) / AREA
    )


def record_of(sample, mu, fraction, alpha, seed=0, noise=0.0):
    travel = np.linspace(0.0, TRAVEL[sample], 200)
    rng = np.random.default_rng(seed)
    return MeasuredCurve(
        travel, mu * bar(sample, travel, fraction, alpha) + noise * rng.normal(size=200)
    )


def group_of(alpha, seed, noise=2e-3, mu=1300.0, fraction=0.8):
    """Likelihood of a fit of tension and compression."""
    families = {sample: family_of(sample) for sample in TRAVEL}
    measured = {
        sample: record_of(sample, mu, fraction, alpha, seed + k, noise)
        for k, sample in enumerate(TRAVEL)
    }
    settings = CalibrationSettings()
    fit = fit_ogden(families, measured, settings)
    return Uncertainty(families, measured, fit, settings, UncertaintySettings()).likelihood()


def test_cardinal_functions_carry_polynomials():
    nodes = np.array([-2.0, -0.5, 1.0, 3.0])
    for x in (-2.0, 0.3, 3.0):
        assert cardinal(nodes, x) @ (nodes**3 - nodes) == pytest.approx(x**3 - x, abs=1e-12)


def test_curves_between_the_nodes_are_those_of_the_bar():
    """At 40 places inside the grid: mostly within 0.2 % of the peak, nowhere beyond 1 %."""
    rng = np.random.default_rng(3)
    for sample in TRAVEL:
        family, errors = family_of(sample), []
        for r, a, b in rng.uniform((0.1, -11.0, 9.0), (0.9, -5.0, 19.0), (40, 3)):
            exact = bar(sample, family.displacement, r, (a, b))
            gap = np.abs(family.force_per_mu(r, a, b) - exact).max()
            errors.append(gap / exact.max())
        assert np.median(errors) < 2e-3
        assert max(errors) < 1e-2


def test_exponents_of_the_bar_are_recovered():
    found = group_of((-7.3, 14.2), seed=1, noise=1e-6).fit
    assert found.shape["alpha1"] == pytest.approx(-7.3, abs=0.05)
    assert found.shape["alpha2"] == pytest.approx(14.2, abs=0.1)
    assert found.mu == pytest.approx(1300.0, rel=5e-3)
    assert found.mu1_fraction == pytest.approx(0.8, abs=0.01)
    assert len(found.starts) == 16
    assert found.success


def test_interval_of_an_exponent_holds_the_truth():
    likelihood = group_of((-7.3, 14.2), seed=5)
    profiles = likelihood.profiles(0.99)
    report = exponent_report(likelihood, profiles, (-7.3, 14.2))
    for name, truth in (("alpha1", -7.3), ("alpha2", 14.2), ("mu1", 1040.0), ("mu2", 260.0)):
        assert report["interval"][name]["low"] < truth < report["interval"][name]["high"]
    assert report["deviance_of_study"] < 9.0  # two degrees of freedom
    table = profile_table("G", profiles)
    assert (table["deviance"] >= -1e-3).all()
    assert set(table["parameter"]) == {"mu", "mu1", "mu2", "alpha1", "alpha2"}


def test_a_fine_mesh_sets_the_level_and_the_coarse_one_the_exponents():
    coarse = family_of("T1")
    stiff = 1.1 * np.linspace(1.0, 1.2, len(coarse.displacement))
    fractions = GRID["mu1_fraction"]
    at_study = np.array([coarse.force_per_mu(r, -8.0, 16.0) for r in fractions])
    fine = ResponseCurves(fractions, coarse.displacement, stiff * at_study)
    anchored = coarse.anchored(fine, (-8.0, 16.0))
    for alpha in ((-8.0, 16.0), (-5.0, 12.0)):
        ratio = anchored.force_per_mu(fractions[2], *alpha)[5:]
        ratio /= coarse.force_per_mu(fractions[2], *alpha)[5:]
        np.testing.assert_allclose(ratio, stiff[5:], rtol=1e-6)


def test_family_of_a_file():
    family = family_of("C1")
    rows = [
        {"mu1_fraction": r, "alpha1": a, "alpha2": b, "displacement_mm": -1e3 * d,
         "force_per_mu_mm2": -1e6 * f}
        for r, a, b in product(*GRID.values())
        for d, f in zip(family.displacement, bar("C1", family.displacement, r, (a, b)), strict=True)
    ]  # fmt: skip
    table = pd.DataFrame(rows).sample(frac=1.0, random_state=1)
    read = ExponentFamily.of_table(table, "compression", HEIGHT / 0.8, 0.4999)
    assert read.bounds == family.bounds
    np.testing.assert_allclose(
        read.force(read.displacement, 1000.0, 0.5, -9.0, 13.0),
        family.force(family.displacement, 1000.0, 0.5, -9.0, 13.0),
        rtol=1e-3,
    )


@pytest.mark.parametrize("mode", ["tension", "pure_shear", "confined_compression"])
def test_curves_of_a_homogeneous_test_hold_between_the_nodes_in_every_mode(mode):
    travel, rows = np.linspace(0.0, 0.4 * HEIGHT, 21), []
    for r, *alpha in product(*GRID.values()):
        stress = homogeneous_force(mode, travel / HEIGHT, unit_modulus(r, alpha, 0.49, 1.0))
        place = np.broadcast_to((r, *alpha), (len(travel), 3))
        rows.append(np.column_stack([place, travel, stress]))
    columns = dict(zip((*GRID, "displacement", "force"), np.concatenate(rows).T, strict=True))
    family = ExponentFamily.of_table(curves_table(columns, mode), mode, HEIGHT, 0.49)
    exact = homogeneous_force(mode, travel / HEIGHT, unit_modulus(0.5, (-9.0, 13.0), 0.49, 1.0))
    gap = np.abs(family.force_per_mu(0.5, -9.0, 13.0) - exact).max()
    assert gap < 1e-3 * np.abs(exact).max()


def test_forces_that_do_not_fill_the_grid_are_refused():
    with pytest.raises(CalibrationError, match="do not fill the grid"):
        ExponentFamily(GRID, np.linspace(0.0, 1e-3, 4), np.zeros((6, 5, 4, 4)), lambda *_: None)


def test_common_exponents_are_accepted_and_different_ones_are_not():
    same = [group_of((-7.3, 14.2), seed, mu=mu) for seed, mu in ((10, 900.0), (20, 1500.0))]
    found = common_exponents(same)
    assert found["degrees_of_freedom"] == 2
    assert found["p_value"] > 0.02
    assert found["alpha1"] == pytest.approx(-7.3, abs=0.3)
    other = common_exponents([same[0], group_of((-9.5, 14.2), 30)])
    assert other["p_value"] < 1e-4
    with pytest.raises(CalibrationError, match="one group alone"):
        common_exponents(same[:1])


def test_p_value_is_that_of_two_degrees_of_freedom():
    """exp(-D / 2), by hand; the deviances of two groups with their valleys one apart."""

    def likelihood(alpha):
        shape = {"alpha1": alpha, "alpha2": 10.0}
        bounds = {"alpha1": (-20.0, -1.0), "alpha2": (1.0, 20.0)}
        return SimpleNamespace(
            fit=SimpleNamespace(shape=shape),
            search=SimpleNamespace(bounds=bounds),
            at=lambda at: (at["alpha1"] - alpha) ** 2 + (at["alpha2"] - 10.0) ** 2,
        )

    found = common_exponents([likelihood(-8.0), likelihood(-10.0)])
    assert found["alpha1"] == pytest.approx(-9.0, abs=1e-3)
    assert found["deviance"] == pytest.approx(2.0, rel=1e-4)
    assert found["p_value"] == pytest.approx(np.exp(-1.0), rel=1e-3)


def test_free_exponents_hold_those_of_the_study():
    with pytest.raises(InputError, match=r"material.alpha.1: 30 is outside exponents.alpha2, 8 to"):
        exponent_grid(SETTINGS, (-8.0, 30.0))


def test_simulated_grid_is_made_of_runs():
    """Every point of the grid is the run of that material, at real exponents."""
    mesh = mesh_cuboid(6e-3, 6e-3, 4e-3, 2e-3)
    model = ExplicitModel(mesh, SolverSettings())
    top = np.flatnonzero(mesh.points[:, 2] > 3.99e-3)
    boundary = mode_boundary(mesh, "tension", top, ContactSettings())
    grid = exponent_grid(ExponentSettings((-9.5, -3.5), (6.5, 14.5), 2, 2), (-8.0, 12.0))
    seen = []
    curves = simulate_exponents(
        model, boundary, 1e-3, grid, 0.49, 0.02, lambda label, done: seen.append(done)
    )
    assert np.all(np.diff(seen) > 0.0)
    assert {k / 8 for k in range(1, 9)} <= set(seen)  # the ends of the runs, and what is between
    table = pd.DataFrame(curves)
    place = [grid["mu1_fraction"][1], -9.5, 14.5]
    last = table[(table[list(grid)] == place).all(axis=1)]
    run = model.run(
        unit_modulus(grid["mu1_fraction"][1], (-9.5, 14.5), 0.49, 1000.0), boundary, 1e-3,
        loading_time=0.02,
    )  # fmt: skip
    np.testing.assert_allclose(last["force"], run.force / 1000.0, rtol=1e-12)


class Bar:
    """Stands for a model: its run is the bar's closed form."""

    def __init__(self, sample):
        self.sample, self.runs = sample, 0

    def run(self, material, boundary, travel, loading_time):
        self.runs += 1
        displacement = np.linspace(0.0, travel, 60)
        fraction = material.mu[0] / material.shear_modulus
        force = material.shear_modulus * bar(self.sample, displacement, fraction, material.alpha)
        return SimpleNamespace(displacement=displacement, force=force)


def test_direct_simulations_end_at_the_optimum_of_the_families():
    alpha, fractions = (-8.0, 16.0), GRID["mu1_fraction"]
    measured = {s: record_of(s, 1300.0, 0.8, (-7.0, 15.0), noise=2e-3) for s in TRAVEL}
    travel = {s: np.linspace(0.0, TRAVEL[s], 60) for s in TRAVEL}
    families = {
        s: ResponseCurves(fractions, d, np.array([bar(s, d, r, alpha) for r in fractions]))
        for s, d in travel.items()
    }
    bars = {sample: Bar(sample) for sample in TRAVEL}
    simulated = {
        s: SimulatedCurves(model, None, TRAVEL[s], 0.04, alpha, 0.49, (0.05, 0.95))
        for s, model in bars.items()
    }
    direct = fit_ogden(simulated, measured, CalibrationSettings(method="direct"))
    family = fit_ogden(families, measured, CalibrationSettings())
    assert direct.mu == pytest.approx(family.mu, rel=5e-3)
    assert direct.mu1_fraction == pytest.approx(family.mu1_fraction, abs=5e-3)
    for sample, curves in simulated.items():
        assert curves.simulations == bars[sample].runs > 10
        assert curves.cpu_s > 0.0


def test_a_sample_that_is_held_out_is_not_simulated():
    mesh = mesh_cuboid(4e-3, 4e-3, 4e-3, 2e-3)
    sample = mesh, {"glued": np.zeros(len(mesh.points), bool)}, {}
    law = {"alpha": (-8.0, 16.0), "poisson_ratio": 0.49}
    travel = np.linspace(0.0, TRAVEL["C1"], 60)
    response = ResponseCurves(np.array([0.0, 1.0]), travel, np.ones((2, 60)))
    group = GroupCurves(MODES, {"C1": response}, {"C1": MeasuredCurve(travel, travel)})
    sections = {"solver": {}, "contact": {}, "material": law}
    pairs = [sample] * 2, ["bonded"] * 2, [{"loading_time_s": 0.04}] * 2
    assert set(simulated_curves(group, *pairs, sections)) == {"C1"}


def exponent_fit(**more):
    return {
        "loading": "shear", "mu_pa": 1000.0, "mu1_pa": 900.0, "mu2_pa": 100.0,
        "alpha1": -8.0, "alpha2": 15.0, "area_error_percent": {"S1": 1.0, "S2": 3.0},
        "interval": {"alpha1": {"low": -9.0, "high": -7.0}, "alpha2": {"low": None, "high": 18.0}},
        "deviance_of_study": 2.5, "area_of_study_over_free": 1.04, "active_bounds": [], **more,
    }  # fmt: skip


def test_row_of_free_exponents_by_hand():
    names = ("area_error_percent", "against_calibrated_curve_percent", "modulus_percent")
    values = {"S1": (1.2, 0.4, -0.3), "S2": (3.4, 0.2, 0.1)}
    runs = {sample: dict(zip(names, row, strict=True)) for sample, row in values.items()}
    row = exponent_table({"S": exponent_fit()}, runs).iloc[0]
    assert row["area_error_percent"] == pytest.approx(2.0)
    assert row["area_of_study_percent"] == pytest.approx(4.0)
    assert row["mesh_area_error_percent"] == pytest.approx(2.3)
    assert (row["mesh_modulus_percent"], row["mesh_curve_percent"]) == (-0.3, 0.4)
    assert np.isnan(row["alpha2_low"])
    assert row["alpha2_high"] == 18.0


def test_verdict_on_exponents_follows_the_probability():
    table = common_table({"all": {"p_value": 0.04}, "shear": {"p_value": 0.06}})
    assert list(table["verdict"]) == ["not constant", "constant"]
