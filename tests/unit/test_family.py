"""Curve families: nodes of the mixture, scaling, error bound, report."""

import numpy as np
import pytest

from softsample.calibration.curves import CurveFamily
from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import SimulationError
from softsample.fem.boundary import glued_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.family import FamilySettings, family_fractions, simulate_family
from softsample.meshing.cuboid import mesh_cuboid

ALPHA = (-8.0, 16.0)
TRAVEL = 1.2e-3


@pytest.fixture(scope="module")
def model():
    settings = SolverSettings(loading_time_s=0.06, curve_points=12)
    return ExplicitModel(mesh_cuboid(5e-3, 4e-3, 4e-3, 1e-3), settings)


@pytest.fixture(scope="module")
def boundary(model):
    return glued_boundary(model.mesh, "compression", model.mesh.glued(0.0))


@pytest.fixture(scope="module")
def family(model, boundary):
    fractions = family_fractions(FamilySettings())
    told = []
    curves, report = simulate_family(
        model, boundary, TRAVEL, fractions, ALPHA, 0.49, lambda *step: told.append(step)
    )
    return fractions, curves, report, told


@pytest.mark.parametrize("nodes", [2, 5, 6])
def test_fractions_are_chebyshev_lobatto_points_of_the_root(nodes):
    fractions = family_fractions(FamilySettings(0.2, 0.95, nodes))
    assert fractions[[0, -1]] == pytest.approx([0.2, 0.95])
    assert np.all(np.diff(fractions) > 0.0)
    root = np.sqrt(1.0 - fractions)
    unit = (2.0 * root - root[0] - root[-1]) / (root[0] - root[-1])
    np.testing.assert_allclose(np.arccos(np.clip(unit, -1, 1)), np.pi * np.linspace(0, 1, nodes))


def test_curves_are_one_after_the_other(family):
    fractions, curves, _, _ = family
    np.testing.assert_allclose(curves["mu1_fraction"], np.repeat(fractions, 13))
    travel = np.tile(np.linspace(0.0, TRAVEL, 13), len(fractions))
    np.testing.assert_allclose(curves["displacement"], travel)
    combined = (curves["platen_force"] - 2.0 * curves["base_force"]) / 3.0
    np.testing.assert_allclose(curves["force"], combined)


def test_curves_are_forces_per_modulus(family, model, boundary):
    """A run with other moduli of the same ratio is the same curve times their sum."""
    fractions, curves, _, _ = family
    mu1 = 3210.0 * fractions[2]
    material = OgdenMaterial((mu1, 3210.0 - mu1), ALPHA, 0.49)
    run = model.run(material, boundary, TRAVEL)
    wanted = 3210.0 * curves["force"].reshape(-1, 13)[2]
    np.testing.assert_allclose(run.force, wanted, atol=1e-4 * wanted.max())


@pytest.mark.parametrize("fraction", [0.1, 0.5, 0.8, 0.93])
def test_mixtures_between_the_computed_ones_are_interpolated(family, model, boundary, fraction):
    fractions, curves, _, _ = family
    interpolated = CurveFamily(
        fractions, curves["displacement"][:13], curves["force"].reshape(-1, 13)
    )
    material = OgdenMaterial((1e3 * fraction, 1e3 * (1.0 - fraction)), ALPHA, 0.49)
    run = model.run(material, boundary, TRAVEL)
    ours = 1e3 * interpolated.force_per_mu(fraction, run.displacement)
    np.testing.assert_allclose(ours, run.force, atol=2e-3 * run.force.max())


def test_error_bound_comes_from_the_run_at_half_speed(family, model, boundary):
    fractions, curves, report, _ = family
    middle = len(fractions) // 2
    assert [run["slowdown"] for run in report["runs"]] == [1.0] * len(fractions) + [2.0]
    assert report["runs"][-1]["mu1_fraction"] == fractions[middle]
    material = OgdenMaterial(
        (fractions[middle] * 1e3, (1.0 - fractions[middle]) * 1e3), ALPHA, 0.49
    )
    slow = model.run(material, boundary, TRAVEL, slowdown=2.0).force / 1e3
    fast = curves["force"].reshape(-1, 13)[middle]
    bound = 400.0 / 3.0 * np.abs(slow - fast).max() / slow.max()
    assert report["error_bound_percent"] == pytest.approx(bound, rel=1e-6)
    slower = model.run(material, boundary, TRAVEL, slowdown=6.0).force / 1e3
    assert 100.0 * np.abs(slower - fast).max() / slower.max() < 1.2 * bound


def test_report_judges_every_run(family):
    *_, report, _ = family
    assert report["elements"] == 5 * 4 * 4
    assert report["travel_mm"] == pytest.approx(1.2)
    for run in report["runs"]:
        assert run["steps"] > 50
        assert 0.0 < run["smallest_step_us"] < 200.0
        for name in ("energy_imbalance", "hourglass_ratio", "kinetic_ratio"):
            assert 0.0 <= run[name] < 0.03


def test_progress_rises_to_one_through_all_runs(family):
    fractions, _, _, told = family
    shares = [share for _, share in told]
    assert np.all(np.diff(shares) > 0.0)
    assert shares[-1] == pytest.approx(1.0)
    assert told[0][0].startswith(f"run 1 of {len(fractions) + 1} (mu1/mu = ")


def test_one_term_is_a_family_of_one(model, boundary):
    curves, report = simulate_family(model, boundary, TRAVEL, [1.0], ALPHA, 0.49)
    run = model.run(OgdenMaterial((1e3,), (-8.0,), 0.49), boundary, TRAVEL)
    np.testing.assert_array_equal(curves["force"], run.force / 1e3)
    assert len(report["runs"]) == 2


def test_failed_run_says_which_one(model, boundary):
    with pytest.raises(SimulationError, match=r"run 1 of 3 \(mu1/mu = 0.500\): element \d+ near"):
        simulate_family(model, boundary, 3.9e-3, [0.5, 0.9], ALPHA, 0.49)
