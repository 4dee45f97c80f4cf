"""Whole way from simulation to verdict on a coarse mesh: ends that slide, force across a shear."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from laboratory import page
from softsample.constitutive.homogeneous import homogeneous_force
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.loop.candidates import candidates
from softsample.loop.diagnose import diagnose
from softsample.loop.effects import library
from softsample.loop.ends import AssumedEnds, diagnose_ends, for_sliding, likelier, with_ends
from softsample.loop.held_out import specimens_of
from softsample.loop.leave_out import left_out_errors
from softsample.loop.model import Material, Model, State
from softsample.loop.noise import GEOMETRY, NoiseSettings
from softsample.loop.pool import Pooled
from softsample.loop.posed import LoopSettings, pose
from softsample.loop.screen import signatures
from softsample.loop.usable import doubted, misfit_with_penalties
from softsample.loop.verdict import document, judgement, report
from softsample.meshing.sample import mesh_ideal
from softsample.protocol import travel_sign
from softsample.records import Record
from softsample.response.elastic import Tables
from softsample.response.perturbations import perturbations_of
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
def tables(mode, ends="bonded"):
    """Response of the block with bonded ends or with sliding ones, and its changes."""
    law = modulus_fractions(ResponseSettings(5)), ALPHA, 0.49
    if ends == "sliding":
        curves, _ = homogeneous_response(BLOCK, mode, TRAVEL[mode], *law, SOLVER.curve_points)
    else:
        sample = mesh_shifted(0.0)
        held = mode_boundary(sample.mesh, mode, sample.glued, CONTACT)
        model = ExplicitModel(sample.mesh, SOLVER)
        curves, _ = simulated_response(model, held, TRAVEL[mode], *law)
    solid = unit_modulus(FRACTION, ALPHA, 0.49, 1000.0)
    test = MechanicalTest(mode, solid, TRAVEL[mode], CONTACT, SOLVER, PerturbationSettings(), ends)
    changes = perturbations_of("ideal", BLOCK, mesh_shifted, test)
    response = pd.DataFrame(response_table(curves, mode))
    return Tables(response, [changes], solid)


def record_of(mode, displacement, force, normal=None, seed=0):
    """Machine's record of a test: rest, loading, and what else the displacement [m] does."""
    rest = np.zeros(200)
    noise = np.random.default_rng(len(mode) + seed).normal(size=(2, 200 + len(force)))
    sign = travel_sign(mode)
    columns = {
        "time_s": 0.02 * np.arange(200 + len(force)),
        "displacement_mm": sign * 1e3 * np.concatenate([rest, displacement]),
        "force_N": sign * np.concatenate([rest + force[0], force]) + 1e-4 * noise[0],
    }
    if normal is not None:
        columns["force_normal_N"] = np.concatenate([rest, normal]) + 1e-4 * noise[1]
    return Record.of_table(pd.DataFrame(columns)).marked(mode)


@cache
def records(ends):
    """Of one block in three modes whose ends were bonded, or slid."""
    found = {}
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
        found[mode] = record_of(mode, displacement, force)
    return found


@cache
def models(ends):
    """Records whose ends were bonded, or slid, beside the response of either."""
    found = []
    for model in ("bonded", "sliding"):
        made = ((m, record, tables(m, model)) for m, record in records(ends).items())
        tests = [test for m, *of in made for test in specimens_of(row(m), *of, BLOCK, [])]
        known = {effect.name: effect for effect in candidates(tests, BLOCK.height, SOLID)}
        names = ("poisson_ratio", "force_offset", "machine_compliance")
        found.append(AssumedEnds(tests, tests, [known[name] for name in names]))
    return found


@cache
def plain_of_either_end():
    """Diagnoses without effects of records whose ends slid, with bonded ends and with sliding."""
    return [diagnose(model.specimens, SETTINGS, []) for model in models("sliding")]


@cache
def diagnosed(ends):
    return diagnose_ends(models(ends), SETTINGS)


def test_ends_that_slid_are_found_where_the_study_leaves_them_open():
    found = diagnosed("sliding")
    assert (found.verdict, found.slides, list(found.selection.classes)) == ("explained", True, [])
    material, bonded = found.final.state.material, found.origin.posed.first.state.material
    assert material.mu == pytest.approx(MU, rel=0.01)
    assert material.mu1_fraction == pytest.approx(FRACTION, abs=0.02)
    assert abs(bonded.mu / MU - 1.0) > 0.1
    verdict = document(found, ({}, {}), SETTINGS, SOLID, [row("shear")], "")
    (effect,) = verdict["effects"]
    assert (effect["name"], effect["class"], effect["parameters"]) == ("ends", ["ends"], {})
    assert effect["evidence"] == -verdict["other_ends"]["evidence"] > 100.0
    assert (verdict["ends"], verdict["other_ends"]["ends"]) == (["sliding"], "bonded")
    assert verdict["theta_before"]["mu"]["value"] == bonded.mu
    before, after = (verdict[f"error_{w}"]["compression"]["all"] for w in ("before", "after"))
    assert after["rms_N"] < 0.2 * before["rms_N"]
    assert verdict["recommended"]["models"][0]["effects"] == ["ends"]
    text = page("G", verdict)
    assert "## Sliding ends" in text
    assert "The study leaves the ends open; in this model they slide. With bonded ends" in text


def test_ends_that_were_bonded_do_not_slide():
    found = diagnosed("bonded")
    assert (found.verdict, found.slides) == ("none", False)
    assert found.selection.final.state.material.mu == pytest.approx(MU, rel=0.01)
    verdict = document(found, ({}, {}), SETTINGS, SOLID, [row("shear")], "")
    assert (verdict["effects"], verdict["ends"]) == ([], ["bonded"])
    assert verdict["other_ends"]["ends"] == "sliding"
    assert verdict["other_ends"]["evidence"] < -100.0


def test_a_test_that_is_left_out_is_predicted_with_the_ends_that_the_others_show():
    before, after = left_out_errors(models("sliding"), {"tension": ["tension"]}, SETTINGS)
    errors = [of["tension"]["tension"] for of in (before, after)]
    assert errors[0].rms > 0.05 * errors[0].peak
    assert errors[1].rms < 0.02 * errors[1].peak


def test_ends_that_records_hardly_tell_are_those_of_the_likelier_model_and_not_named():
    bonded, sliding = plain_of_either_end()
    assert not likelier(bonded, bonded).slides
    more = replace(sliding.selection.steps[0], threshold=2.0 * (bonded.left - sliding.left))
    found = likelier(bonded, replace(sliding, selection=replace(sliding.selection, steps=[more])))
    assert (found.slides, found.shows_sliding, found.verdict) == (True, False, "none")


def test_other_groups_tell_what_the_platens_do():
    bonded, sliding = plain_of_either_end()
    evidence = bonded.left - sliding.left
    found = likelier(bonded, sliding, -1.1 * evidence)
    assert not found.slides
    assert report(found, SETTINGS)["recommended"]["models"][0]["effects"] == []
    other = judgement(found, SETTINGS)["other_ends"]
    assert other["evidence"] == pytest.approx(evidence)
    assert other["evidence_of_other_groups"] == pytest.approx(-1.1 * evidence)
    assert likelier(bonded, sliding, -0.9 * evidence).slides
    assert for_sliding({"other_ends": other}) == pytest.approx(evidence)
    told = judgement(likelier(bonded, sliding), SETTINGS)
    assert for_sliding(told) == pytest.approx(evidence)
    assert with_ends(told, slides=True) is told
    assert with_ends(told, slides=False)["path"] == judgement(bonded, SETTINGS)["path"]


def test_other_groups_choose_the_ends_by_more_than_a_standard_error():
    """Else the likelihood does, as where they tell nothing."""
    bonded, sliding = diagnosed("sliding").other_ends, diagnosed("sliding")

    def told(found, *percent):
        errors = np.log(0.01 * np.array(percent))
        return replace(found, told=Pooled({}, [], {}, {}, 50.0, 30.0, errors))

    stiff = told(bonded, 4.0, 5.0, 6.0)
    assert not likelier(stiff, told(sliding, 8.0, 9.0, 13.0)).slides
    assert likelier(stiff, told(sliding, 3.9, 5.5, 5.9)).slides
    found = likelier(told(bonded, 8.0, 9.0, 13.0), told(sliding, 4.0, 5.0, 6.0), -1e6)
    assert (found.slides, found.ends_are_told) == (True, True)
    text = page("G", document(found, ({}, {}), SETTINGS, SOLID, [row("shear")], ""))
    assert "they slide. That is the choice of the other groups, by what is held out" in text
    assert re.search(r"Evidence -\d+, but the other groups choose it\.", text)
    assert not likelier(stiff, sliding).slides
    assert not likelier(stiff, told(sliding, 3.9, 5.5, 5.9)).ends_are_told


def test_evidence_on_ends_is_doubted_by_errors_of_geometry_that_no_record_shows():
    found = plain_of_either_end()
    plain = [one.selection.base for one in found]
    sharp = np.subtract(*(misfit_with_penalties(fit) for fit in plain))
    less = np.subtract(*(misfit_with_penalties(doubted(fit)) for fit in plain))
    assert 0.0 < less < 0.7 * sharp
    assert found[0].left - found[1].left == pytest.approx(less, rel=1e-4)
    for fit in map(doubted, plain):
        assert min(fit.problem.variances[name] for name in GEOMETRY) >= SETTINGS.noise.spread**2


def test_where_nothing_explains_the_modulus_is_that_of_both_ends_as_far_as_they_are_open():
    bonded, sliding = (replace(one, objection="an error is left") for one in plain_of_either_end())
    open_ends = likelier(bonded, sliding, sliding.left - bonded.left)
    told = report(open_ends, SETTINGS)["recommended"]
    assert [(m["effects"], m["weight"]) for m in told["models"]] == [
        ([], pytest.approx(0.5)), (["ends"], pytest.approx(0.5))
    ]  # fmt: skip
    moduli = [one.final.state.material.mu for one in (bonded, sliding)]
    assert told["mu"]["low"] < min(moduli) < max(moduli) < told["mu"]["high"]


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


def two_channels(selections=(), offset=0.0, terms=TERMS, seed=0):
    """Both channels of a disc that is sheared to one side and to the other."""
    one = np.concatenate([np.linspace(0, 1, 300), np.linspace(1, -1, 600), np.linspace(-1, 0, 300)])
    displacement = 0.5 * DISC.height * one
    along, across = (DISC.area * stress for stress in sheared(displacement / DISC.height, terms))
    record = record_of("shear", displacement, along + offset, across, seed)
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
    """A single term of 25 shears as one of -25 does, and has another normal force.

    How a fit divides the modulus between both depends on the noise: the median of five seeds.
    """
    ratios = []
    for seed in range(5):
        tests = two_channels([{"channel": "force_normal"}], terms=((MU, 25.0),), seed=seed)
        found = diagnose(tests, LoopSettings(), [library()["ogden_exponents"]])
        assert set(found.selection.classes) == {"ogden_exponents"}
        before, after = (
            judged.held_out["shear_normal"].rms for judged in (found.before, found.selected)
        )
        ratios.append(after / before)
    assert np.median(ratios) < 0.5


def test_the_normal_force_takes_part_in_the_fit():
    """Held out, it is predicted; fitted, it makes the fraction better known."""
    found = diagnose(two_channels([{"channel": "force_normal"}]), SETTINGS, [])
    assert found.posed.problem.labels == ["shear"]
    error = found.before.held_out["shear_normal"]
    assert error.rms < 0.02 * error.peak
    both = diagnose(two_channels(), SETTINGS, [])
    assert both.posed.problem.labels == ["shear", "shear_normal"]
    assert set(both.before.fitted) == {"shear", "shear_normal"}
    material = both.selection.base.state.material
    assert material.mu == pytest.approx(MU, rel=0.01)
    assert material.mu1_fraction == pytest.approx(FRACTION, abs=0.02)
    wide, narrow = (np.sqrt(d.selection.base.covariance[1, 1]) for d in (found, both))
    assert narrow < 0.7 * wide


def test_instruments_of_the_force_are_not_those_of_the_normal_force():
    effects = [library()[name] for name in ("force_offset", "machine_compliance")]
    problem, _ = pose(two_channels()[1:], SETTINGS.noise)
    for signature in signatures(problem.fit_material(), effects):
        assert signature.strength < 1e-6
    found = diagnose(two_channels(offset=0.02), SETTINGS, effects)
    assert list(found.selection.classes) == ["force_offset"]
    offset = size(found.selection.final.state, "force_offset", "shear_mN")
    assert offset == pytest.approx(20.0, abs=1.0)
