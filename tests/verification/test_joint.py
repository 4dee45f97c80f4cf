"""Whole way from simulation to verdict on a coarse mesh: ends that slide, force across a shear."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

from softsample.constitutive.homogeneous import homogeneous_force
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.loop.candidates import candidates
from softsample.loop.diagnose import diagnose, judgement
from softsample.loop.effects import library
from softsample.loop.held_out import Tables, specimens_of
from softsample.loop.model import Material, Model, State
from softsample.loop.noise import NoiseSettings
from softsample.loop.posed import LoopSettings, pose
from softsample.loop.screen import signatures
from softsample.meshing.sample import mesh_ideal
from softsample.protocol import travel_sign
from softsample.records import Record
from softsample.response.changes import table_of_changes
from softsample.response.perturbations import ENDS, perturbations_of
from softsample.response.pieces import MechanicalTest, MeshedSample, PerturbationSettings
from softsample.response.unit import (
    ResponseSettings,
    homogeneous_response,
    modulus_fractions,
    response_table,
    simulated_response,
)
from softsample.shapes import IdealShape

ALPHA = (-8.0, 16.0)
MU, FRACTION = 1300.0, 0.6
MM, SIZE = 1e-3, 1.25e-3
SOLVER = SolverSettings(loading_time_s=0.3, curve_error_percent=0.05)
CONTACT = ContactSettings()
SOLID = unit_modulus(FRACTION, ALPHA, 0.49, 1.0)
BLOCK = IdealShape("cuboid", 10 * MM, 7.5 * MM, 5 * MM)
TRAVEL = {"compression": 1.2 * MM, "tension": 1.2 * MM, "shear": 2.0 * MM}
SETTINGS = LoopSettings(
    NoiseSettings(floor_percent=0.3, fine_percent=0.0, scale_percent=0.3, contact_zero_mm=0.005)
)
"""For a mesh that is that of the record."""


def size(state, effect, parameter):
    """Value of a parameter of an effect."""
    return state.values[effect][parameter]  # noqa: PD011 - no table


def row(mode):
    return {"sample": mode, "specimen": mode, "group": "G", "mode": mode, "ends": "unknown"}


def mesh_shifted(out):
    return MeshedSample.of(mesh_ideal(BLOCK.grown(out), SIZE))


@cache
def tables(mode):
    """Response of the bonded block, and its changes, those of open ends among them."""
    sample, nu = mesh_shifted(0.0), 0.49
    held = mode_boundary(sample.mesh, mode, sample.glued, CONTACT)
    fractions = modulus_fractions(ResponseSettings(5))
    model = ExplicitModel(sample.mesh, SOLVER)
    curves, _ = simulated_response(model, held, TRAVEL[mode], fractions, ALPHA, nu)
    solid = unit_modulus(FRACTION, ALPHA, nu, 1000.0)
    test = MechanicalTest(
        mode, solid, TRAVEL[mode], CONTACT, SOLVER, PerturbationSettings(), "unknown"
    )
    grid, changes = perturbations_of("ideal", BLOCK, mesh_shifted, test)
    assert ENDS in changes
    response = pd.DataFrame(response_table(curves, mode))
    return Tables(response, [table_of_changes(mode, FRACTION, grid, changes)], solid)


def record_of(mode, displacement, force, normal=None):
    """Machine's record of a test: rest, loading, and what else the displacement [m] does."""
    rest = np.zeros(200)
    noise = np.random.default_rng(len(mode)).normal(size=(2, 200 + len(force)))
    sign = travel_sign(mode)
    columns = {
        "time_s": 0.02 * np.arange(200 + len(force)),
        "displacement_mm": sign * 1e3 * np.concatenate([rest, displacement]),
        "force_N": sign * np.concatenate([rest + force[0], force]) + 1e-4 * noise[0],
    }
    if normal is not None:
        columns["force_normal_N"] = np.concatenate([rest, normal]) + 1e-4 * noise[1]
    return Record.of_table(pd.DataFrame(columns)).marked(mode)


def specimens(ends):
    """Tests of one block in three modes whose ends were bonded, or slid."""
    found = []
    for mode, reach in TRAVEL.items():
        displacement = np.linspace(0.0, reach, 600)
        if ends == "sliding":  # in closed form
            solid = unit_modulus(FRACTION, ALPHA, 0.49, MU)
            force = BLOCK.area * homogeneous_force(mode, displacement / BLOCK.height, solid)
        else:  # by a run of its own, at another pace
            sample, solid = mesh_shifted(0.0), unit_modulus(FRACTION, ALPHA, 0.49, MU)
            held = mode_boundary(sample.mesh, mode, sample.glued, CONTACT)
            run = ExplicitModel(sample.mesh, SOLVER).run(solid, held, reach, loading_time=1.0)
            force = np.interp(displacement, run.displacement, run.force)
        record = record_of(mode, displacement, force)
        found += specimens_of(row(mode), record, tables(mode), BLOCK, [])
    return found


@cache
def diagnosed(ends):
    tests = specimens(ends)
    known = {effect.name: effect for effect in candidates(tests, BLOCK.height, SOLID)}
    names = ("ends", "poisson_ratio", "force_offset", "machine_compliance")
    return diagnose(tests, SETTINGS, [known[name] for name in names])


def test_ends_that_slid_are_found_on_a_bonded_model():
    found = diagnosed("sliding")
    assert found.verdict == "explained"
    assert next(iter(found.selection.classes)) == "ends"
    before, after = found.selection.base.state, found.selection.final.state
    assert size(after, "ends", "share") == pytest.approx(1.0, abs=0.05)
    assert after.material.mu == pytest.approx(MU, rel=0.02)
    assert after.material.mu1_fraction == pytest.approx(FRACTION, abs=0.05)
    assert abs(before.material.mu / MU - 1.0) > 0.1
    (effect,) = (e for e in judgement(found, SETTINGS)["effects"] if e["name"] == "ends")
    assert effect["parameters"]["share"]["high"] == 1.0


def test_ends_that_were_bonded_do_not_slide():
    found = diagnosed("bonded")
    assert found.verdict == "none"
    assert found.selection.final.state.material.mu == pytest.approx(MU, rel=0.01)


def test_a_share_of_slip_between_comes_back():
    """Half of the change of every test, at the material of the changes."""
    problem, _ = pose(specimens("bonded"), SETTINGS.noise)
    model, material = Model((library()["ends"],)), Material(MU, FRACTION)
    half = State(material, {"ends": {"share": 0.5}})
    made = problem.with_forces(problem.predicted(model, half))
    fit = made.fit(model, State(Material(1000.0, 0.5), {"ends": {"share": 0.05}}))
    assert size(fit.state, "ends", "share") == pytest.approx(0.5, abs=0.01)
    assert fit.state.material.mu == pytest.approx(MU, rel=1e-2)


DISC = IdealShape("cylinder", 20 * MM, 20 * MM, 6 * MM)
NEARLY = 0.4999
"""Poisson's ratio of a tissue that hardly changes its volume."""


TERMS = ((FRACTION * MU, ALPHA[0]), ((1.0 - FRACTION) * MU, ALPHA[1]))
"""Modulus [Pa] and exponent of each term of the tissue."""


def sheared(shear, terms=TERMS):
    """Stress along and across simple shear of an incompressible Ogden solid [Pa], by hand.

    Cauchy's principal stresses are ``sum 2 mu/alpha lambda^alpha - p`` with the pressure that
    leaves the lateral faces free; the first principal direction is (lambda, 1) in the plane.
    """
    stretch = 0.5 * shear + np.sqrt(1.0 + 0.25 * shear**2)
    first, third = (sum(2.0 * m / a * (s**a - 1.0) for m, a in terms) for s in
                    (stretch, 1.0 / stretch))  # fmt: skip
    square = stretch**2
    return (first - third) * stretch / (1.0 + square), (first + square * third) / (1.0 + square)


def two_channels(selections=(), offset=0.0, terms=TERMS):
    """Both channels of a disc that is sheared to one side and to the other."""
    one = np.concatenate([np.linspace(0, 1, 300), np.linspace(1, -1, 600), np.linspace(-1, 0, 300)])
    displacement = 0.5 * DISC.height * one
    along, across = (DISC.area * stress for stress in sheared(displacement / DISC.height, terms))
    record = record_of("shear", displacement, along + offset, across)
    law = (modulus_fractions(ResponseSettings()), ALPHA, NEARLY)
    solid = unit_modulus(FRACTION, ALPHA, NEARLY, 1.0)
    curves, _ = homogeneous_response(DISC, "shear", 0.5 * DISC.height, *law, 60)
    response = Tables(pd.DataFrame(response_table(curves, "shear")), [], solid)
    return specimens_of(row("shear"), record, response, DISC, selections)


def test_both_channels_of_a_shear_are_predicted_to_either_side():
    force, normal = two_channels()
    state = State(Material(MU, FRACTION))
    for test in (force, normal):
        assert (test.travel < -0.4 * DISC.height).any()
        predicted = Model().predict(test, state)
        assert np.abs(predicted - test.force).max() < 2e-3 * test.peak + 5e-4
    assert force.force.min() < -0.9 * force.force.max()
    ends = [normal.force[np.argmax(way * normal.travel)] for way in (1.0, -1.0)]
    assert ends[0] == pytest.approx(ends[1], rel=0.01)  # it pulls alike to either side
    assert normal.peak > 0.05 * force.peak


def test_of_opposite_exponents_which_shear_hardly_tells_the_nearer_is_taken():
    """A single term of 25 shears as one of -25 does, and has another normal force."""
    tests = two_channels([{"channel": "force_normal"}], terms=((MU, 25.0),))
    found = diagnose(tests, LoopSettings(), [library()["ogden_exponents"]])
    assert set(found.selection.classes) == {"ogden_exponents"}
    before, after = (
        judged.held_out["shear_normal"].rms for judged in (found.before, found.selected)
    )
    assert after < 0.5 * before


def test_the_normal_force_takes_part_in_the_fit():
    """Held out, it is predicted; fitted, it makes the fraction better known."""
    found = diagnose(two_channels([{"channel": "force_normal"}]), SETTINGS, [])
    assert found.problem.labels == ["shear"]
    error = found.before.held_out["shear_normal"]
    assert error.rms < 0.02 * error.peak
    both = diagnose(two_channels(), SETTINGS, [])
    assert both.problem.labels == ["shear", "shear_normal"]
    assert set(both.before.fitted) == {"shear", "shear_normal"}
    material = both.selection.base.state.material
    assert material.mu == pytest.approx(MU, rel=0.01)
    assert material.mu1_fraction == pytest.approx(FRACTION, abs=0.02)
    wide, narrow = (np.sqrt(d.selection.base.covariance[1, 1]) for d in (found, both))
    assert narrow < 0.7 * wide


def test_instruments_of_the_force_are_not_those_of_the_normal_force():
    effects = [library()[name] for name in ("force_offset", "machine_compliance")]
    problem, _ = pose(two_channels()[1:], SETTINGS.noise)
    for signature in signatures(problem, problem.fit_material(), effects):
        assert signature.strength < 1e-6
    found = diagnose(two_channels(offset=0.02), SETTINGS, effects)
    assert list(found.selection.classes) == ["force_offset"]
    offset = size(found.selection.final.state, "force_offset", "shear_mN")
    assert offset == pytest.approx(20.0, abs=1.0)
