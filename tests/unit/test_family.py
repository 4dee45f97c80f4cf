"""Simulated responses: nodes of the modulus fraction, scaling, error bound, report."""

from types import SimpleNamespace

import numpy as np
import pytest

from softsample.constitutive.ogden import OgdenMaterial, unit_modulus
from softsample.errors import CrushedError, SimulationError, TooFarError
from softsample.fem.boundary import glued_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.cuboid import mesh_cuboid
from softsample.response.curves import ResponseCurves
from softsample.response.unit import (
    ResponseSettings,
    as_far_as_elements_stand,
    find_pace,
    modulus_fractions,
    simulated_response,
    unit_runs,
)

ALPHA = (-8.0, 16.0)
TRAVEL = 1.2e-3


@pytest.fixture(scope="module")
def model():
    settings = SolverSettings(loading_time_s=0.02, curve_points=12)
    return ExplicitModel(mesh_cuboid(5e-3, 4e-3, 4e-3, 1e-3), settings)


@pytest.fixture(scope="module")
def boundary(model):
    return glued_boundary(model.mesh, "compression", model.mesh.glued(0.0))


@pytest.fixture(scope="module")
def family(model, boundary):
    fractions = modulus_fractions(ResponseSettings())
    told = []
    curves, report = simulated_response(
        model, boundary, TRAVEL, fractions, ALPHA, 0.49, lambda *step: told.append(step)
    )
    return fractions, curves, report, told


@pytest.mark.parametrize("nodes", [2, 5, 6])
def test_fractions_are_chebyshev_lobatto_points_of_the_root(nodes):
    fractions = modulus_fractions(ResponseSettings(nodes))
    assert fractions[[0, -1]].tolist() == [0.0, 1.0]
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
    fractions, curves, report, _ = family
    mu1 = 3210.0 * fractions[2]
    material = OgdenMaterial((mu1, 3210.0 - mu1), ALPHA, 0.49)
    run = model.run(material, boundary, TRAVEL, loading_time=report["loading_time_s"])
    wanted = 3210.0 * curves["force"].reshape(-1, 13)[2]
    np.testing.assert_allclose(run.force, wanted, atol=1e-4 * wanted.max())


@pytest.mark.parametrize("fraction", [0.1, 0.5, 0.8, 0.93])
def test_fractions_between_the_computed_ones_are_interpolated(family, model, boundary, fraction):
    fractions, curves, report, _ = family
    interpolated = ResponseCurves(
        fractions, curves["displacement"][:13], curves["force"].reshape(-1, 13)
    )
    material = OgdenMaterial((1e3 * fraction, 1e3 * (1.0 - fraction)), ALPHA, 0.49)
    run = model.run(material, boundary, TRAVEL, loading_time=report["loading_time_s"])
    ours = 1e3 * interpolated.force_per_mu(fraction, run.displacement)
    np.testing.assert_allclose(ours, run.force, atol=2e-3 * run.force.max())


def test_error_bound_is_the_difference_from_a_slow_test(family, model, boundary):
    fractions, curves, report, _ = family
    middle = len(fractions) // 2
    material = OgdenMaterial(
        (fractions[middle] * 1e3, (1.0 - fractions[middle]) * 1e3), ALPHA, 0.49
    )
    slow = model.run(material, boundary, TRAVEL, loading_time=0.5).force / 1e3
    found = curves["force"].reshape(-1, 13)[middle]
    error = 100.0 * np.abs(slow - found).max() / slow.max()
    assert report["error_bound_percent"] <= model.settings.curve_error_percent
    assert error == pytest.approx(report["error_bound_percent"], rel=0.3)


@pytest.mark.parametrize(("guess", "wanted"), [(0.02, 0.5), (0.06, 0.5), (0.02, 0.1)])
def test_loading_time_is_as_short_as_the_wanted_error_allows(guess, wanted):
    """Curves whose inertia error is 0.002 % s2 of the peak over T^2."""
    ramp = np.linspace(0.0, 1.0, 11)
    asked = []

    def run(time):
        asked.append(time)
        return SimpleNamespace(force=ramp * (1.0 + 2e-5 / time**2))

    pace = find_pace(run, guess, wanted)
    error = 2e-3 / pace.loading_time**2
    assert 0.5 * wanted < error <= wanted
    assert pace.error_percent == pytest.approx(error, rel=0.02)
    assert pace.loading_time in asked


def test_loading_too_fast_for_the_law_is_slowed_down():
    """Below 0.1 s the force is off by a constant, as if it rang: preliminary runs see no error."""
    ramp = np.linspace(0.0, 1.0, 11)

    def run(time):
        return SimpleNamespace(force=ramp * (1.02 if time < 0.1 else 1.0 + 1e-5 / time**2))

    pace = find_pace(run, 0.06, 0.5)
    assert pace.loading_time >= 0.1
    assert pace.error_percent <= 0.5


@pytest.mark.parametrize("least", [0.004, 0.01, 0.02, 0.04])
def test_loading_that_crushes_elements_is_slowed_down(least):
    """Half of a time that is long enough is tried, and not taken if it crushes."""

    def run(time):
        if time < least:
            raise SimulationError("J = nan")
        return SimpleNamespace(force=np.ones(5))

    assert find_pace(run, 0.01, 0.5).loading_time == pytest.approx(max(least, 0.005))


def test_loading_that_crushes_elements_at_any_pace_is_refused():
    def run(time):
        raise SimulationError(f"J = nan in {time} s")

    with pytest.raises(SimulationError, match="J = nan in 0.04 s"):
        find_pace(run, 0.01, 0.5)


def test_loading_that_no_time_makes_static_is_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(TooFarError, match="inertia still changes the force by"):
        find_pace(lambda time: SimpleNamespace(force=rng.uniform(1, 2, 5)), 0.04, 0.5)


def test_errors_that_fall_faster_are_followed():
    """In shear the error falls almost with the cube of the time."""
    ramp = np.linspace(0.0, 1.0, 11)
    pace = find_pace(lambda time: SimpleNamespace(force=ramp * (1.0 + 4e-6 / time**3)), 0.02, 0.5)
    assert 0.25 < 4e-4 / pace.loading_time**3 <= 0.5


def test_coarse_preliminary_run_finds_a_time_that_is_long_enough(model, boundary):
    """The error is judged on the mesh itself, by a run in ten times the time.

    To a quarter of the height: at 30 %, the four elements of the preliminary run buckle.
    """
    travel = 1.0e-3
    fine = ExplicitModel(mesh_cuboid(5e-3, 4e-3, 4e-3, 0.5e-3), model.settings)
    held = glued_boundary(fine.mesh, "compression", fine.mesh.glued(0.0))
    curves, report = simulated_response(
        fine, held, travel, [1.0], ALPHA, 0.49, preliminary=(model, boundary)
    )
    material, time = OgdenMaterial((1e3,), (-8.0,), 0.49), 10.0 * report["loading_time_s"]
    slow = fine.run(material, held, travel, loading_time=time).force / 1e3
    error = 100.0 * np.abs(slow - curves["force"]).max() / slow.max()
    assert error <= report["error_bound_percent"] <= 0.5 < 50.0 * error


def test_report_judges_every_run(family):
    *_, report, _ = family
    assert report["elements"] == 5 * 4 * 4
    assert report["travel_mm"] == pytest.approx(1.2)
    for run in report["runs"]:
        assert run["steps"] > 50
        assert 0.0 < run["smallest_step_us"] < 200.0
        for name in ("energy_imbalance", "hourglass_ratio"):
            assert 0.0 <= run[name] < 0.03


def test_progress_rises_to_one_through_all_runs(family):
    fractions, _, _, told = family
    shares = [share for _, share in told]
    assert np.all(np.diff([share for label, share in told if label != "loading time"]) > 0.0)
    assert shares[-1] == pytest.approx(1.0)
    labels = list(dict.fromkeys(label for label, _ in told))
    assert labels[:2] == ["loading time", f"run 1 of {len(fractions)} (mu1/mu = 0.000)"]


def test_one_term_is_a_family_of_one(model, boundary):
    curves, report = simulated_response(model, boundary, TRAVEL, [1.0], ALPHA, 0.49)
    material = OgdenMaterial((1e3,), (-8.0,), 0.49)
    run = model.run(material, boundary, TRAVEL, loading_time=report["loading_time_s"])
    np.testing.assert_array_equal(curves["force"], run.force / 1e3)
    assert len(report["runs"]) == 1


def test_failed_run_says_which_one(model, boundary):
    with pytest.raises(SimulationError, match=r"loading time: element \d+ near"):
        simulated_response(model, boundary, 7.9e-3, [0.5, 0.9], ALPHA, 0.49)


def test_a_displacement_that_crushes_elements_is_cut_short():
    def stands(least):
        def simulate(travel):
            if travel > 1.5:
                raise CrushedError("element 3 near the edge")
            return {}, {"travel": travel}

        return as_far_as_elements_stand(simulate, least)

    assert stands(1.5) == ({}, {"travel": 1.5, "reached": 1.0})
    assert stands(2.0)[1]["reached"] == 0.7
    with pytest.raises(CrushedError, match="element 3"):
        stands(3.2)


def test_other_failures_are_no_reason_to_cut_it_short():
    def simulate(travel):
        raise SimulationError("the energy is off")

    with pytest.raises(SimulationError, match="energy"):
        as_far_as_elements_stand(simulate, 1.0)


def test_elements_that_give_way_are_noticed():
    def model(force):
        run = SimpleNamespace(force=np.array(force), displacement=1e-3 * np.arange(len(force)))
        return SimpleNamespace(run=lambda *_, **__: run)

    solids = [unit_modulus(0.5, ALPHA, 0.49, 1000.0)]
    assert len(list(unit_runs(model([0.0, 1.0, 2.0, 1.9]), None, 1e-3, solids, 0.1))) == 1
    with pytest.raises(
        TooFarError, match=r"falls by 50 % of its peak beyond 2\.00 mm of displacement"
    ):
        list(unit_runs(model([0.0, 1.0, 2.0, 1.0]), None, 1e-3, solids, 0.1))
