"""What a study holds out: no fit knows of it, and its errors are of nothing else."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import laboratory
from softsample.calibration.measured import MeasuredCurve, fitted_curves
from softsample.errors import CalibrationError
from softsample.loop.candidates import candidates
from softsample.loop.diagnose import diagnose
from softsample.loop.effects import library, specimen_stiffness
from softsample.loop.effects.base import SOLID
from softsample.loop.ends import AssumedEnds
from softsample.loop.errors import held_out_errors
from softsample.loop.held_out import specimens_of
from softsample.loop.leave_out import left_out_errors
from softsample.loop.model import Material, Model, State
from softsample.loop.posed import LoopSettings, Posed, pose
from softsample.loop.scale import (
    most_likely,
    relative_stiffness,
    same_tests,
    scale_of,
    scatter,
)
from softsample.loop.specimen import FORCE, NORMAL, Specimen
from softsample.loop.verdict import document, judgement, recommended
from softsample.response.elastic import Tables
from softsample.response.unit import homogeneous_response, response_table
from softsample.shapes import IdealShape

SETTINGS = LoopSettings()
OFFSET = {"tension": 7.0, "compression": -5.0, "shear": 4.0}
EFFECTS = [library()[name] for name in ("force_offset", "channel_lag", "machine_compliance")]
HEIGHT = 1e-3 * laboratory.HEIGHT
SHAPE = IdealShape("cuboid", 20e-3, 23e-3, HEIGHT)


def spoiled(specimen):
    """The same with other forces where it is held out."""
    wild = 0.3 + 3.0 * specimen.force + np.random.default_rng(1).normal(size=len(specimen.force))
    return replace(specimen, force=np.where(specimen.held_out, wild, specimen.force))


def held(mask, modes=("tension", "shear"), seed=3):
    """Tests with an offset, of which `mask(specimen)` is held out."""
    lab = laboratory.Lab(seed=seed, offset=OFFSET, compliance=0.05)
    return [replace(s, held_out=mask(s)) for s in lab.specimens(modes)]


def back(specimen):
    return np.isin(specimen.phase, ("hold", "unloading"))


def late(specimen):
    """From 10 s into the hold on, in whole blocks of 20 samples."""
    n = np.argmax(specimen.phase == "hold") + 1000
    return np.arange(len(specimen.force)) >= n // 20 * 20


def far(specimen):
    return specimen.travel > 0.6 * specimen.reach


def cut(specimen):
    """The record without its held-out end."""
    n = int(np.argmax(specimen.held_out))
    assert specimen.held_out[n:].all()
    parts = {name: getattr(specimen, name)[:n] for name in ("time", "travel", "force", "phase")}
    return replace(specimen, **parts, held_out=np.zeros(n, bool))


@pytest.fixture(scope="module")
def tests():
    return held(back)


@pytest.fixture(scope="module")
def found(tests):
    return diagnose(tests, SETTINGS, EFFECTS)


def same(one, other):
    """Whether two diagnoses are the same to the last bit."""
    assert one.posed.noises == other.posed.noises
    assert [s.threshold for s in one.selection.steps] == [
        s.threshold for s in other.selection.steps
    ]
    for name in ("base", "final"):
        a, b = (getattr(d.selection, name) for d in (one, other))
        assert (a.state, a.cost) == (b.state, b.cost)
        np.testing.assert_array_equal(a.white, b.white)
    assert one.before.folds == other.before.folds
    assert one.selected.fitted == other.selected.fitted
    assert one.verdict == other.verdict


@pytest.mark.parametrize("mask", [back, far])
def test_nothing_of_a_diagnosis_depends_on_forces_that_are_held_out(mask):
    tests = held(mask)
    found = diagnose(tests, SETTINGS, EFFECTS)
    other = diagnose([spoiled(s) for s in tests], SETTINGS, EFFECTS)
    same(found, other)
    before, after = found.before.held_out, other.before.held_out
    assert all(after[name].rms > 10.0 * before[name].rms for name in ("tension", "shear"))


def test_a_test_that_is_held_out_as_a_whole_is_no_part_of_a_diagnosis(found):
    every = laboratory.MODES
    tests = held(lambda s: back(s) | (s.mode == "compression"), every)
    whole = diagnose([spoiled(s) for s in tests], SETTINGS, EFFECTS)
    same(found, whole)
    assert whole.posed.problem.labels == ["tension", "shear"]
    assert set(whole.before.held_out) == set(every)


def test_what_is_held_out_at_the_end_is_as_good_as_cut_off():
    """If the largest displacement is a fitted one, by which errors along the way are measured."""
    tests = [
        replace(s, travel=np.minimum(s.travel, s.travel[~s.held_out].max()))
        for s in held(late, laboratory.MODES)
    ]
    found = diagnose(tests, SETTINGS, EFFECTS)
    short = diagnose([cut(s) for s in tests], SETTINGS, EFFECTS)
    assert short.before.held_out == {}
    assert found.selection.classes == short.selection.classes
    assert found.posed.noises == short.posed.noises
    for name in ("base", "final"):
        a, b = (getattr(d.selection, name).state for d in (found, short))
        assert a.material.mu == pytest.approx(b.material.mu, rel=1e-6)
        assert a.material.mu1_fraction == pytest.approx(b.material.mu1_fraction, rel=1e-6)
    for mode, phases in short.before.fitted.items():
        for phase, error in phases.items():
            assert found.before.fitted[mode][phase].rms == pytest.approx(error.rms, rel=1e-6)
        assert set(found.before.fitted[mode]) == {"all", "baseline", "ramp", "hold"}


def test_errors_of_what_is_held_out_are_of_its_samples_alone(tests, found):
    """By hand; peaks are its own, and noise is taken out of the structured error."""
    fit, noise = found.selection.base, found.posed.noises[0].white
    cells = {"force": noise, "torque": 0.1 * noise}
    errors = held_out_errors(fit, tests, cells, {})
    for specimen in tests:
        left = (specimen.force - fit.model.predict(specimen, fit.state))[specimen.held_out]
        error = errors[specimen.mode]
        assert error.rms == pytest.approx(np.sqrt(np.mean(left**2)))
        assert error.structured == pytest.approx(np.sqrt(np.mean(left**2) - noise**2))
        assert error.peak == np.abs(specimen.force[specimen.held_out]).max()
    others = [replace(s, force=np.where(s.held_out, s.force, 9.0)) for s in tests]
    assert held_out_errors(fit, others, cells, {}) == errors
    assert held_out_errors(fit, [cut(s) for s in tests], cells, {}) == {}
    sheared = next(s for s in tests if s.mode == "shear")
    (turned,) = held_out_errors(fit, [replace(sheared, mode="torsion")], cells, {}).values()
    assert turned.structured**2 - errors["shear"].structured ** 2 == pytest.approx(0.99 * noise**2)


STIFF = {"A": 0.8, "B": 1.0, "C": 1.25}


def stiffer(specimen, by, name):
    """The same test on another specimen, of which only the loading is fitted."""
    force = by * specimen.force
    return replace(specimen, name=name, piece=name, force=force, held_out=back(specimen))


@pytest.fixture(scope="module")
def scattered():
    """Three specimens, of which one is softer and one stiffer, and their diagnosis."""
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    tests = [stiffer(one, by, name) for name, by in STIFF.items()]
    return tests, diagnose(tests, SETTINGS, [library()["force_offset"]])


def test_specimens_that_differ_in_stiffness_are_told_and_predicted(scattered):
    """What is held out of each is predicted as well as that of the one that is as the mean."""
    _, found = scattered
    assert found.posed.stiffness == pytest.approx(STIFF, rel=0.01)
    verdict = document(found, ({}, {}), SETTINGS, SOLID, [{"ends": "bonded"}], "")
    assert verdict["verdict"] == "explained"
    (effect,) = verdict["effects"]
    assert effect["class"] == ["specimen_stiffness"]
    assert {piece: p["value"] for piece, p in effect["parameters"].items()} == found.posed.stiffness
    assert effect["evidence"] > 0.0
    before, after = ({k: e.rms / e.peak for k, e in judged.held_out.items()}
                     for judged in (found.before, found.after))  # fmt: skip
    first, *_, last = before.values()
    assert min(first, last) > 0.1
    assert max(after.values()) < 0.03
    low, high = (verdict["theta_after"]["mu"][end] for end in ("low", "high"))
    assert np.log(high / low) > 2.0 * 1.64 * scatter(STIFF) / np.sqrt(3.0)
    assert low < laboratory.MU < high


GAPS = {"A": 0.3, "B": 0.0, "C": 0.2, "D": 0.1}  # mm


def met_at(gap, name, by=1.0):
    """The compression of a specimen that the platen meets late, its last fifth held out."""
    (one,) = laboratory.Lab(seed=ord(name), gap=gap, mu=by * laboratory.MU).specimens(
        ["compression"]
    )
    test = stiffer(one, 1.0, name)
    return replace(test, held_out=test.held_out | (test.travel > 0.8 * test.reach))


@pytest.fixture(scope="module")
def uneven():
    """Four specimens of one stiffness, and their diagnosis."""
    tests = [met_at(gap, name) for name, gap in GAPS.items()]
    return tests, diagnose(tests, SETTINGS, [library()["force_offset"]])


def test_specimens_that_the_platen_meets_at_other_heights_are_not_of_another_stiffness(uneven):
    """With one contact point for all, stiffness scattered by 12 % and 5 % of the peak was left."""
    _, found = uneven
    mean = np.mean(list(GAPS.values()))
    over_mean = {name: gap - mean for name, gap in GAPS.items()}
    assert found.posed.contact == pytest.approx(over_mean, abs=0.02)
    verdict = judgement(found, SETTINGS)
    assert (verdict["verdict"], verdict["specimen_stiffness"]) == ("none", {})
    assert verdict["specimen_contact_mm"] == found.posed.contact
    assert max(e.rms / e.peak for e in found.after.held_out.values()) < 0.01
    mu = recommended(found)["mu"]
    assert mu["low"] < laboratory.MU < mu["high"] < 1.15 * mu["low"]


def test_where_they_touch_is_known_beside_their_stiffness():
    tests = [met_at(GAPS[name], name, by) for name, by in STIFF.items()]
    found = diagnose(tests, SETTINGS, [library()["force_offset"]])
    mean = np.mean([GAPS[name] for name in STIFF])
    assert found.posed.contact == pytest.approx({k: GAPS[k] - mean for k in STIFF}, abs=0.04)
    assert found.posed.stiffness == pytest.approx(STIFF, rel=0.05)


def test_specimens_that_the_platen_meets_at_one_height_share_their_contact_point():
    tests = [met_at(0.0, name) for name in GAPS]
    assert diagnose(tests, SETTINGS, [library()["force_offset"]]).posed.contact == {}


def test_relaxation_of_specimens_is_not_taken_for_contact_at_other_heights():
    """Their stiffness scatters by a third: it was found half as far apart, contact 0.6 mm."""
    scattered = {"A": 1.05, "B": 0.63, "C": 1.56, "D": 0.94}
    tests = []
    for name, by in scattered.items():
        lab = laboratory.Lab(seed=ord(name), mu=by * laboratory.MU, relaxed=0.4)
        (one,) = lab.specimens(["compression"])
        tests.append(replace(one, name=name, piece=name))
    posed = Posed.of(tests, SETTINGS)
    mean = np.exp(np.mean(np.log(list(scattered.values()))))
    assert posed.contact == {}
    assert posed.stiffness == pytest.approx({k: by / mean for k, by in scattered.items()}, rel=0.03)


TOES = [("compression", "late_contact", 0.5), ("compression", "late_contact", 1.2),
        ("tension", "slack", 0.7)]  # fmt: skip


@pytest.mark.parametrize(("mode", "name", "free"), TOES)
def test_free_travel_is_found_in_a_loading_alone(mode, name, free):
    """The plain model has bent its law to the toe, beside which no small gap is any better."""
    model, rng = laboratory.exact(mode), np.random.default_rng(1)
    time, travel = laboratory.clock(mode)
    loading = time < laboratory.REST + laboratory.STROKE[mode] / laboratory.SPEED
    time, travel = time[loading], travel[loading]
    reached = 1e-3 * np.maximum(travel - free, 0.0)
    force = laboratory.MU * model.force_per_mu(laboratory.FRACTION, reached)
    force += rng.normal(0.0, 2e-4, len(force))
    sign = laboratory.SIGN[mode]
    table = pd.DataFrame(
        {"time_s": time, "displacement_mm": sign * travel, "force_N": sign * force}
    )
    record = laboratory.record_of(table, mode)
    found = diagnose([Specimen.of_record("A", mode, record, model)], SETTINGS)
    (named,) = judgement(found, SETTINGS)["effects"]
    assert named["name"] == name
    (size,) = named["parameters"].values()
    assert size["value"] == pytest.approx(free, abs=0.02)
    mu = recommended(found)["mu"]
    assert mu["low"] < laboratory.MU < mu["high"] < 1.3 * mu["low"]


def test_what_is_left_out_of_a_specimen_begins_where_the_rest_of_it_does(uneven):
    """Half a test of a specimen, left out of the diagnosis of all else."""
    tests, _ = uneven
    first = tests[0]
    half = first.time > np.median(first.time[~first.held_out & (first.travel > 0.0)])
    again = replace(first, name="A again", held_out=first.held_out | half)
    model = AssumedEnds([again, *tests], [again, *tests], [library()["force_offset"]])
    before, _ = left_out_errors([model], {"A": ["A"]}, SETTINGS)
    (begun,) = (e for label, e in before["A"].items() if label == "compression_A")
    assert begun.rms < 0.01 * begun.peak


def test_tests_of_one_specimen_that_differ_in_scale_are_not_specimens(scattered):
    tests, _ = scattered
    found = diagnose([replace(s, piece="A") for s in tests], SETTINGS, [library()["force_offset"]])
    assert (found.verdict, found.posed.stiffness) == ("unknown", {})
    assert found.objection.startswith("the scales of the tests differ by")


def test_an_effect_is_named_beside_scales_that_nothing_explains():
    """Its evidence counts with scales as free as these records have them."""
    (one,) = laboratory.Lab(seed=7, drift=0.5).specimens(["shear"])
    tests = [replace(stiffer(one, by, name), piece="A") for name, by in STIFF.items()]
    found = diagnose(tests, SETTINGS, [library()["force_drift"]])
    assert (found.verdict, found.objection) == ("explained", "")
    assert found.final.model.names == ("force_drift",)
    assert "force_drift" not in judgement(found, SETTINGS)["not_identifiable"]


def test_specimens_without_a_test_in_common_have_no_stiffness_of_their_own():
    tests = [replace(s, force=(1.0 + 0.2 * (s.mode == "shear")) * s.force, piece=s.mode)
             for s in laboratory.Lab(seed=7).specimens()]  # fmt: skip
    assert diagnose(tests, SETTINGS, [library()["force_offset"]]).posed.stiffness == {}


@pytest.mark.parametrize("change", ["speed", "displacement"])
def test_tests_at_another_speed_or_to_another_displacement_tell_nothing_of_stiffness(change):
    """What is stiffer at ten times the speed may be so at any specimen."""
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    fast = stiffer(one, 1.2, "B")
    if change == "speed":
        fast = replace(fast, time=0.1 * fast.time)
    else:
        fast = replace(fast, travel=0.5 * fast.travel)
    alike = stiffer(one, 1.2, "C")
    assert same_tests([one, fast, alike]) == [0, 1, 0]
    problem, _ = pose([one, fast], SETTINGS.noise)
    assert relative_stiffness(problem.fit_material()) == {}


def test_what_only_one_record_has_tells_nothing_of_stiffness():
    """A hold and an unloading with a loss, of which the other record has none."""
    (whole,) = laboratory.Lab(seed=7).specimens(["shear"])
    after = np.isin(whole.phase, ["hold", "unloading"])
    lossy = replace(whole, force=np.where(after, 0.7 * whole.force, whole.force))
    other = stiffer(whole, 1.2, "B")
    part = replace(other, held_out=other.held_out | after)
    problem, _ = pose([lossy, part], SETTINGS.noise)
    found = relative_stiffness(problem.fit_material())
    assert found["B"] / found[whole.piece] == pytest.approx(1.2, rel=0.02)


def test_records_that_share_their_rest_alone_tell_nothing_of_stiffness():
    """Displacements are read with noise: some force is predicted at rest, too."""
    (whole,) = laboratory.Lab(seed=7).specimens(["shear"])
    noise = 2e-6 * np.random.default_rng(2).standard_normal(len(whole.travel))
    whole = replace(whole, travel=whole.travel + noise)
    before, after = whole.phase == "ramp", np.isin(whole.phase, ["hold", "unloading"])
    parts = [
        replace(whole, held_out=whole.held_out | after),
        replace(stiffer(whole, 1.2, "B"), held_out=whole.held_out | before),
    ]
    problem, _ = pose(parts, SETTINGS.noise)
    assert relative_stiffness(problem.fit_material()) == {whole.piece: 1.0, "B": 1.0}


def test_pieces_cut_along_other_directions_tell_nothing_of_stiffness():
    """What is stiffer along the fibres is no stiffer specimen; either sign is the same."""
    (one,) = (replace(s, material_z=1, material_x=2)
              for s in laboratory.Lab(seed=7).specimens(["shear"]))  # fmt: skip
    turned = replace(stiffer(one, 1.5, "B"), material_z=2, material_x=1)
    alike = replace(stiffer(one, 1.5, "C"), material_z=-1)
    assert same_tests([one, turned, alike]) == [0, 1, 0]
    problem, _ = pose([one, turned], SETTINGS.noise)
    assert relative_stiffness(problem.fit_material()) == {}
    assert specimen_stiffness.of_tests([one, turned]) is None
    assert [p.name for p in specimen_stiffness.of_tests([one, turned, alike]).parameters] == ["C"]


def test_a_specimen_of_another_height_has_the_same_test_at_the_same_strain():
    """And at the same speed of the platen; at the same displacement its strain is another one."""
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    higher = replace(one.elastic, height=1.4 * one.elastic.height)
    longer = replace(one, name="B", piece="B", travel=1.4 * one.travel, time=1.4 * one.time)
    assert same_tests([one, longer]) == [0, 1]
    assert same_tests([one, replace(longer, elastic=higher)]) == [0, 0]
    assert same_tests([one, replace(one, elastic=higher)]) == [0, 1]


def test_what_is_left_of_a_scale_belongs_to_other_tests_of_the_specimen():
    """A shear of 3 % more than the others: its error of scale, and that of its normal force."""
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    tests = [stiffer(one, by, name) for by, name in ((1.0, "A"), (1.0, "B"), (1.03, "C"))]
    found = diagnose(tests, SETTINGS, [library()["force_offset"]])
    assert (found.verdict, found.posed.stiffness) == ("none", {})
    scales = found.scales_before
    assert scale_of(tests[2], scales) - scale_of(tests[0], scales) == pytest.approx(0.03, abs=0.01)
    assert scale_of(replace(tests[2], channel=NORMAL), scales) == scale_of(tests[2], scales)
    assert scale_of(replace(tests[2], piece="D"), scales) == 0.0
    blind = held_out_errors(found.selection.base, tests, {}, {})
    assert found.before.held_out["shear_C"].rms < 0.7 * blind["shear_C"].rms


def test_errors_of_scale_are_those_of_the_force_that_a_fit_predicts():
    """Against the ridge estimate, where the first fit was of another force than the last."""
    (one,) = laboratory.Lab(seed=7).specimens(["shear"])
    more = np.where(np.abs(one.travel) < 0.2 * one.reach, 1.5, 1.1)
    problem, _ = pose([replace(one, force=more * one.force)], SETTINGS.noise)
    problem = problem.with_variances({**problem.variances, "scale": 100.0})
    fit = problem.at(Model(), pose([one], SETTINGS.noise)[0].fit_material().state)
    (error,) = most_likely(fit).values()
    (test,), (force,) = problem.specimens, problem.predicted(fit.model, fit.state)
    apart = problem.with_variances({**problem.variances, "scale": 0.0})
    column, left = apart.white([force]), apart.white([test.force - force])
    precision = 1.0 / (0.1 * SETTINGS.noise.scale_percent) ** 2
    assert error == pytest.approx(float(column @ left / (column @ column + precision)), rel=1e-3)
    assert 0.1 < error < 0.5


def test_a_compliant_machine_and_its_sample_are_springs_in_series():
    """Against the inverse of s + c F(s), whatever was measured; 0.25 mm/N take 9 % of the force."""
    effect = library()["machine_compliance"]
    lab = laboratory.Lab(seed=3, compliance=0.25)
    (measured,) = lab.specimens(["compression"])
    time, moved = laboratory.clock("compression")
    exact = lab.tissue("compression", time, lab.travel("compression", moved))

    def predicted(compliance, force=measured.force):
        material = Material(laboratory.MU, laboratory.FRACTION)
        state = State(material, {effect.name: {"mm_per_N": compliance}})
        specimen = replace(measured, travel=1e-3 * moved, force=force)
        return Model((effect,)).predict(specimen, state)

    assert np.abs(predicted(0.0) - exact).max() > 0.08 * exact.max()
    assert np.abs(predicted(0.25) - exact).max() < 1e-3 * exact.max()
    assert np.array_equal(predicted(0.25), predicted(0.25, 3.0 * measured.force))


def assumed(tests):
    """The one model of tests whose ends are stated."""
    return [AssumedEnds(tests, tests, EFFECTS)]


def test_a_test_that_is_left_out_is_predicted_by_a_diagnosis_of_the_others():
    tests = held(back, laboratory.MODES)
    names = {s.mode: s.name for s in tests}
    folds = {"shear": [names["shear"]], "axial": [names["tension"], names["compression"]]}
    told = []
    before, after = left_out_errors(assumed(tests), folds, SETTINGS, 0.0, lambda *x: told.append(x))
    assert told == [("shear", 0.0), ("axial", 0.5)]
    assert {name: set(of) for name, of in before.items()} == {
        "shear": {"shear"}, "axial": {"tension", "compression"}
    }  # fmt: skip
    rest = diagnose([s for s in tests if s.mode != "shear"], SETTINGS, EFFECTS)
    sheared = next(s for s in tests if s.mode == "shear")
    judged = replace(sheared, held_out=~sheared.held_out)  # what the study holds out is no part
    for errors, fit in ((before, rest.selection.base), (after, rest.final)):
        expected = held_out_errors(fit, [judged], {"force": rest.posed.noises[0].white}, {})
        assert errors["shear"] == expected
    other = left_out_errors(assumed([spoiled(s) for s in tests]), folds, SETTINGS)
    assert other == (before, after)


def test_a_fold_of_everything_is_passed_over():
    tests = held(back)
    names = [s.name for s in tests]
    assert left_out_errors(assumed(tests), {"all": names}, SETTINGS) == ({}, {})


def test_the_verdict_gives_what_is_declared_and_otherwise_the_folds(found):
    rows = [{"ends": "bonded"}]
    plain = diagnose(laboratory.Lab(seed=3).specimens(("tension", "shear")), SETTINGS, [])
    own = document(found, ({}, {}), SETTINGS, SOLID, rows, "held out: phase hold")
    assert set(own["held_out_before"]) == {"held_out"}
    assert set(own["held_out_before"]["held_out"]) == {"tension", "shear"}
    none = document(plain, ({}, {}), SETTINGS, SOLID, rows, "")
    assert none["held_out_before"] == none["folds_before"] != {}
    folds = {"S1": {"shear": found.before.held_out["shear"]}}
    both = document(found, (folds, folds), SETTINGS, SOLID, rows, "")
    assert list(both["held_out_before"]) == ["held_out", "S1"]
    alone = document(plain, (folds, folds), SETTINGS, SOLID, rows, "")
    assert list(alone["held_out_after"]) == ["S1"]


def test_ranges_of_effects_know_nothing_of_a_test_that_is_held_out():
    tests = held(lambda s: np.full(len(s.force), s.mode == "shear"))
    usual = candidates(tests, HEIGHT, SOLID)
    loud = [replace(s, force=1e3 * s.force) if s.mode == "shear" else s for s in tests]
    assert [e.parameters for e in candidates(loud, HEIGHT, SOLID)] == [e.parameters for e in usual]


ROW = {
    "sample": "T1", "group": "G", "specimen": "G", "mode": "tension", "cycle": "largest",
}  # fmt: skip
LIMIT = 0.15


def record(mode="tension"):
    return laboratory.record_of(laboratory.Lab(seed=5).record(mode), mode)


def test_a_calibration_sees_the_loading_without_what_is_held_out():
    one = record()
    rows = {"T1": ROW}
    whole = fitted_curves(rows, [one], [HEIGHT], [])["T1"]
    curve = fitted_curves(rows, [one], [HEIGHT], [{"strain_above": LIMIT}])["T1"]
    assert whole.travel > LIMIT * HEIGHT >= curve.travel
    inside = whole.displacement <= LIMIT * HEIGHT
    np.testing.assert_array_equal(curve.force, whole.force[inside])
    beyond = np.abs(one.displacement) > LIMIT * HEIGHT
    wild = replace(one, force=np.where(beyond, 1e3, one.force))
    again = fitted_curves(rows, [wild], [HEIGHT], [{"strain_above": LIMIT}])["T1"]
    np.testing.assert_array_equal(again.force, curve.force)
    ramp = one.calibrated & ~beyond
    np.testing.assert_array_equal(
        MeasuredCurve.of_record(one, "tension", beyond).force, one.force[ramp]
    )


def test_a_group_that_is_all_held_out_is_not_calibrated():
    rows = {"T1": ROW}
    with pytest.raises(CalibrationError, match="all of T1 is held out.*narrow hold_out"):
        fitted_curves(rows, [record()], [HEIGHT], [{"sample": "T1"}])
    two = {"T1": ROW, "T2": {**ROW, "sample": "T2"}}
    kept = fitted_curves(two, [record()] * 2, [HEIGHT] * 2, [{"sample": "T1"}])
    assert list(kept) == ["T2"]


def test_tests_of_a_sample_have_the_samples_that_the_study_holds_out():
    one = record("shear")
    normal = replace(one, force_normal=-0.1 * np.abs(one.force))
    row, selections = {**ROW, "mode": "shear"}, [{"strain_above": LIMIT, "channel": "force"}]
    tables = response_tables()
    (plain,) = specimens_of(row, one, tables, SHAPE, selections)
    force, other = specimens_of(row, normal, tables, SHAPE, selections)
    assert [s.channel for s in (plain, force, other)] == [FORCE, FORCE, NORMAL]
    np.testing.assert_array_equal(force.held_out, np.abs(one.displacement) > LIMIT * HEIGHT)
    np.testing.assert_array_equal(plain.held_out, force.held_out)
    assert not other.held_out.any()
    assert plain.elastic is force.elastic
    assert force.elastic is not other.elastic
    assert force.peak == np.abs(force.force[~force.held_out]).max()
    np.testing.assert_array_equal(other.force, normal.force_normal)
    for k, out in enumerate(force.reduced(7).held_out):
        assert out == force.held_out[k * 7 : (k + 1) * 7].any()


@pytest.mark.parametrize("release", [True, False])
def test_a_platen_that_does_not_release_the_sample_may_pull_on_it(release):
    tables = replace(response_tables("compression"), release=release)
    (test,) = specimens_of({**ROW, "mode": "compression"}, record("compression"), tables, SHAPE, [])
    assert (test.elastic.contact, test.elastic.release) == (True, release)


def response_tables(mode="shear"):
    """Response of a cuboid in closed form, without changes."""
    law = (np.array([0.0, 0.5, 1.0]), SOLID.alpha, SOLID.poisson_ratio)
    curves, _ = homogeneous_response(SHAPE, mode, 0.5 * HEIGHT, *law, 30)
    return Tables(pd.DataFrame(response_table(curves, mode)), [], SOLID)
