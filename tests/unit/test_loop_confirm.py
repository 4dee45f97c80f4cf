"""Effects run at the sizes that a verdict found, in place of scaled changes."""

from dataclasses import replace

import numpy as np
import pytest

import laboratory
from softsample.constitutive.material import Material, Term
from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import SolverSettings
from softsample.loop.confirm import confirmations, of_mode, sizes_to_confirm
from softsample.loop.effects import library
from softsample.loop.posed import LoopSettings
from softsample.meshing.sample import mesh_ideal
from softsample.response.at_size import at_size, simulate_sizes
from softsample.response.perturbations import simulate_perturbations
from softsample.response.pieces import MechanicalTest, MeshedSample, PerturbationSettings
from softsample.response.unit import paced
from softsample.shapes import IdealShape

MM = 1e-3
STEPS = {
    "poisson_ratio": ({"nu": 0.47}, "poisson_0.02_less"),
    "anisotropy": ({"k1": 0.1, "angle_deg": 45.0}, "fibres_ahead"),
    "boundary_shift": ({"shift_mm": 0.1}, "boundary_shift"),
    "partial_bond": ({"missing": 0.125, "side": -1.0}, "partial_bond_behind"),
    "platen_tilt": ({"tilt_deg": 1.0, "axis_deg": 0.0}, "platen_tilt_x"),
}
"""Sizes that are the steps of the variants, and the variants that they are."""


@pytest.mark.parametrize("mode", ["tension", "compression"])
def test_an_effect_at_the_step_of_a_variant_is_that_variant(mode):
    def mesh_shifted(shift):
        shape = IdealShape("cuboid", 8 * MM, 6 * MM, 7 * MM)
        return MeshedSample.of(mesh_ideal(shape.grown(shift), 1.5 * MM))

    solid, solver = (
        OgdenMaterial((600.0, 400.0), (-8.0, 16.0), 0.49),
        SolverSettings(loading_time_s=0.05),
    )
    test = MechanicalTest(mode, solid, MM, ContactSettings(), solver, PerturbationSettings())
    travel, variants = simulate_perturbations(mesh_shifted, test)
    sizes = {name: values for name, (values, _) in STEPS.items()}
    there, changes = simulate_sizes(mesh_shifted, test, of_mode(sizes, mode))
    np.testing.assert_array_equal(there, travel)
    left_out = {"compression": "partial_bond", "tension": "platen_tilt"}[mode]
    assert set(changes) == set(STEPS) - {left_out}
    for name, change in changes.items():
        assert np.abs(change).max() > 0.0
        np.testing.assert_allclose(change, variants[STEPS[name][1]], rtol=1e-12)


def test_other_laws_are_run_at_their_sizes():
    sample = MeshedSample.of(mesh_ideal(IdealShape("cuboid", 8 * MM, 6 * MM, 7 * MM), 1.5 * MM))
    solid, solver = (
        OgdenMaterial((600.0, 400.0), (-8.0, 16.0), 0.49),
        SolverSettings(loading_time_s=0.05),
    )
    test = MechanicalTest("tension", solid, MM, ContactSettings(), solver, PerturbationSettings())
    sizes = {
        "ogden_exponents": {"alpha1": -14.0, "alpha2": 8.0},
        "compressible_foam": {"share": 0.5, "alpha": 8.0, "nu": 0.1},
    }
    travel, changes = simulate_sizes(lambda _: sample, test, sizes)
    model, held = sample.model(solver), test.held(sample)
    pace = paced(model, solid, held, travel[-1])
    laws = {
        "ogden_exponents": (1.0, OgdenMaterial((600.0, 400.0), (-14.0, 8.0), 0.49)),
        "compressible_foam": (0.5, Material((Term("foam", 1000.0, (8.0, 0.1)),), 0.1)),
    }
    for name, (share, law) in laws.items():
        run = model.run(law, held, travel[-1], loading_time=pace.loading_time)
        change = share * (run.force - pace.run.force) / 1000.0
        assert np.abs(change).max() > 0.0
        np.testing.assert_allclose(changes[name], change, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("mode", ["tension", "compression"])
def test_changes_are_for_the_steps_that_effects_know_whatever_the_settings(mode):
    def mesh_shifted(shift):
        shape = IdealShape("cuboid", 8 * MM, 6 * MM, 7 * MM)
        return MeshedSample.of(mesh_ideal(shape.grown(shift), 1.5 * MM))

    default = PerturbationSettings()
    half = PerturbationSettings(0.05, 0.5, shift_mm=0.05)
    solid, solver = OgdenMaterial((600.0, 400.0), (-8.0, 16.0), 0.49), SolverSettings()
    (_, usual), (_, other) = (
        simulate_perturbations(
            mesh_shifted,
            MechanicalTest(mode, solid, MM, ContactSettings(), solver, steps),
        )
        for steps in (default, half)
    )
    for name in ("fibres_x", "boundary_shift"):
        ratio = np.linalg.norm(other[name]) / np.linalg.norm(usual[name])
        assert 0.7 < ratio < 1.4, name  # a half without it


def confirmed(factor, stiffness=None):
    """Table for a softer, more compressible tissue, whose run gives so many times that change."""
    specimens, stiffness = [], stiffness or {}
    for specimen in laboratory.Lab(seed=5).specimens():
        known, r = specimen.elastic.perturbations, laboratory.FRACTION
        missing = specimen.elastic.change_per_mu("poisson_0.09_less", r, specimen.travel)
        known_change = known["poisson_0.09_less"].curve(r)
        run = laboratory.alike(
            specimen.elastic.curves, {at_size("poisson_ratio"): factor * known_change}
        )
        specimens.append(
            replace(
                specimen,
                force=stiffness.get(specimen.mode, 1.0)
                * (specimen.force + laboratory.MU * missing),
                piece=specimen.mode,
                elastic=replace(specimen.elastic, perturbations={**known, **run}),
            )
        )
    sizes = {"poisson_ratio": {"nu": 0.40}}
    table = confirmations(specimens, sizes, 12.0, LoopSettings(), library(), stiffness, {})
    (row,) = table.to_dict("records")
    return row


def test_what_the_run_repeats_is_confirmed_and_what_it_does_not_is_refused():
    same, other = confirmed(1.0), confirmed(0.0)
    assert same["evidence"] == pytest.approx(other["evidence"])
    assert same["evidence_confirmed"] == pytest.approx(same["evidence"], abs=2.0)
    assert same["confirmed"]
    assert same["mu_confirmed_pa"] == pytest.approx(same["mu_pa"], rel=0.01)
    assert other["evidence_confirmed"] < 0.0
    assert not other["confirmed"]
    assert other["difference_percent"] > 5.0 > same["difference_percent"]


def test_specimens_keep_the_stiffness_of_the_verdict():
    same, stiffer = confirmed(1.0), confirmed(1.0, {"shear": 1.5})
    assert stiffer["confirmed"]
    assert stiffer["mu_pa"] == pytest.approx(same["mu_pa"], rel=0.01)


def test_the_best_of_the_first_round_that_change_the_model_are_confirmed():
    def candidate(name, evidence):
        return {"name": name, "evidence": evidence, "values": {"size": evidence}}

    ranked = [
        candidate("force_offset", 90.0),
        candidate("poisson_ratio", 80.0),
        candidate("platen_tilt", 70.0),
        candidate("anisotropy", 60.0),
        candidate("boundary_shift", 50.0),
    ]
    verdict = {"path": [{"candidates": ranked}, {"candidates": []}]}
    assert list(sizes_to_confirm(verdict)) == ["poisson_ratio", "platen_tilt", "anisotropy"]
    bonded, slid = ({"other_ends": {"ends": ends}} for ends in ("sliding", "bonded"))
    assert sizes_to_confirm({**verdict, **bonded}) == sizes_to_confirm(verdict)
    assert sizes_to_confirm({**verdict, **slid}) == {}
