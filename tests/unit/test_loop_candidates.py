"""Which effects a group's records may show, and over which ranges."""

from dataclasses import replace

import numpy as np
import pytest

import laboratory
from softsample.constitutive.ogden import unit_modulus
from softsample.loop.candidates import candidates
from softsample.loop.effects import library
from softsample.loop.effects.base import SOLID
from softsample.loop.screen import penalty
from softsample.records import Record

HEIGHT = 13e-3
TIMED = {
    "channel_lag", "dehydration", "force_drift", "poroelastic_drainage", "rate_stiffening",
    "viscoelastic_relaxation",
}  # fmt: skip
ALWAYS_ABSENT = {"channel_crosstalk", "specimen_stiffness", "compressible_foam"}
"""Unless the study leaves open what the ends do, has normal forces or repeats, and curves are near
those of a law."""


@pytest.fixture(scope="module")
def tests():
    return laboratory.Lab(seed=1).specimens()


def named(tests, height=HEIGHT):
    return {effect.name: effect for effect in candidates(tests, height, SOLID)}


def scaled(tests, factor):
    return [replace(s, force=factor * s.force) for s in tests]


def ranges(effect):
    return {p.name: (p.low, p.high, p.nominal, p.neutral, p.grid) for p in effect.parameters}


def test_records_like_those_of_the_study_have_the_library_as_it_is(tests):
    found = named(tests)
    assert set(found) == set(library()) - ALWAYS_ABSENT
    for name, effect in found.items():
        assert ranges(effect) == ranges(library(SOLID, tests)[name])


def test_an_effect_has_no_size_for_kinds_of_tests_that_are_not_there(tests):
    """Nothing would show it, and each costs evidence."""
    pressed = named([test for test in tests if test.kind == "compression"])

    def names(effect):
        return [p.name for p in effect.parameters]

    assert names(pressed["force_offset"]) == ["compression_mN"]
    assert names(pressed["displacement_zero"]) == ["compression_mm"]
    pickup = library(SOLID, [test for test in tests if test.kind == "shear"])["mains_pickup"]
    assert names(pickup) == ["shear_sin_mN", "shear_cos_mN", "period_s"]
    assert penalty(pressed["displacement_zero"], 100) == pytest.approx(np.log(100))
    assert len(library()["displacement_zero"].parameters) == len(laboratory.MODES)


def test_a_law_has_the_exponents_of_which_the_response_is_known(tests):
    def known(runs):
        laws = replace(tests[1].elastic.laws, runs={a: tests[1].elastic.laws.runs[a] for a in runs})
        one = replace(tests[1], elastic=replace(tests[1].elastic, laws=laws))
        found = named([tests[0], one, tests[2]])
        exponents = {p.name: (p.low, p.high) for p in found["ogden_exponents"].parameters}
        single = {p.name: p for p in found["elastic_law"].parameters}["alpha"]
        assert all(single.low <= value <= single.high for value in single.grid)
        return [*exponents.values(), (single.low, single.high)]

    assert known([-45.0, 40.0]) == [(-45.0, -0.5), (0.5, 40.0), (-45.0, 40.0)]
    assert known([40.0]) == [(-8.0, -0.5), (0.5, 40.0), (-8.0, 40.0)]
    alike = [replace(s, elastic=laboratory.exact(s.mode)) for s in tests]
    assert {p.low for p in named(alike)["elastic_law"].parameters} == {0.0, -45.0}


def test_without_recorded_time_there_are_no_effects_of_time(tests):
    one = [tests[0], tests[1], replace(tests[2], timed=False)]
    assert set(named(one)) == set(library()) - ALWAYS_ABSENT - TIMED - {"mains_pickup"}
    record = Record.of_table(laboratory.Lab(seed=1).record("shear"))
    assert record.timed
    assert not replace(record, time=None).timed


def test_a_sweep_without_time_has_no_past(tests):
    """No loading led to where a mean curve over both directions of shear begins."""
    past = {"backlash", "mullins_softening", "permanent_set", "unloading_loss"}
    sweep = replace(tests[2], travel=tests[2].travel - 0.5 * tests[2].reach)
    assert past <= set(named([*tests[:2], sweep]))
    untimed = [*tests[:2], replace(sweep, timed=False)]
    assert set(named(untimed)) == set(named([*tests[:2], replace(tests[2], timed=False)])) - past
    pressed = replace(tests[2], travel=tests[2].travel + 0.5 * tests[2].reach, timed=False)
    assert past <= set(named([*tests[:2], pressed]))  # one that begins deformed, and no sweep


@pytest.mark.parametrize(("rate", "there"), [(100.0, True), (96.0, True), (50.0, False)])
def test_the_mains_show_where_their_ripple_is_folded_to_a_slow_beat(tests, rate, there):
    resampled = [replace(s, time=s.time * laboratory.RATE / rate) for s in tests]
    assert ("mains_pickup" in named(resampled)) == there


@pytest.mark.parametrize(
    ("height", "force", "length_by", "force_by"),
    [
        (7e-3, 1.0, 1.0, 1.0),  # within a factor of two of 13 mm
        (26e-3, 5.0, 1.0, 1.0),  # and of five of 1 N
        (52e-3, 1.0, 2.0, 1.0),
        (3.25e-3, 1.0, 0.5, 1.0),
        (HEIGHT, 20.0, 1.0, 4.0),
        (52e-3, 0.05, 2.0, 0.25),
    ],
)
def test_ranges_go_with_size_and_force_only_far_from_those_of_the_study(
    tests, height, force, length_by, force_by
):
    peak = np.median([s.peak for s in tests])
    found = named(scaled(tests, force / peak), height)
    by = {"mm": length_by, "mN": force_by, "mN/s": force_by, "mm/N": length_by / force_by}
    units, usual = set(), library(SOLID, tests)
    for name, effect in found.items():
        for ours, known in zip(effect.parameters, usual[name].parameters, strict=True):
            factor = by.get(known.unit, 1.0)
            assert ours.low == pytest.approx(factor * known.low)
            assert ours.high == pytest.approx(factor * known.high)
            assert ours.nominal == pytest.approx(factor * known.nominal)
            assert ours.grid == pytest.approx([factor * value for value in known.grid])
            assert (ours.unit, ours.is_size) == (known.unit, known.is_size)
            units.add(known.unit)
    assert set(by) <= units


def test_no_sample_of_known_shape_pulls_by_more_than_it_weighs(tests):
    """Whatever its peak force; half of it is the nominal size."""
    cell = 40.0 / np.median([s.peak for s in tests])
    for weight in (0.003, 0.6):
        known = [replace(s, elastic=replace(s.elastic, weight=weight)) for s in scaled(tests, cell)]
        (size,) = named(known)["self_weight"].parameters
        assert (size.low, size.high) == pytest.approx((-1e3 * weight, 1e3 * weight))
        assert size.nominal == pytest.approx(-500.0 * weight)
        assert named(known)["force_offset"] == named(scaled(tests, cell))["force_offset"]


def test_effects_on_constants_depart_from_those_of_the_group(tests):
    solid = unit_modulus(0.5, (1.3, 5.0), 0.45, 1.0)
    found = {effect.name: effect for effect in candidates(tests, HEIGHT, solid)}
    assert [p.neutral for p in found["ogden_exponents"].parameters] == [1.3, 5.0]
    assert [p.neutral for p in found["poisson_ratio"].parameters] == [0.45]
