"""Effects of a tissue's history and of its contact, step by step along several cycles."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import least_squares

from softsample.loop.candidates import candidates
from softsample.loop.effects import library
from softsample.loop.effects.base import SOLID
from softsample.loop.held_out import specimens_of
from softsample.loop.model import Material, Model, State
from softsample.loop.specimen import FORCE, NORMAL, Specimen
from softsample.records import Record
from softsample.response.curves import ResponseCurves, before_zero
from softsample.response.elastic import Elastic, Tables
from softsample.shapes import IdealShape

EFFECTS = library()
MU, AREA, LENGTH = 500.0, 2e-4, 1e-2
STROKE = 4e-3


def area(mode, travel):
    """Force over modulus [m2]: stiffening, nothing before a platen touches."""
    strain = travel / LENGTH
    if mode == "compression":
        strain = np.maximum(strain, 0.0)
    return 3.0 * AREA * (strain + 2.0 * np.abs(strain) * strain + strain**3)


def elastic(mode):
    travel = np.linspace(0.0, 1.2 * STROKE, 1201)
    curve = area(mode, travel)[None]
    return Elastic(
        ResponseCurves(np.array([0.5]), travel, curve, before_zero(mode)),
        {},
        contact=mode == "compression",
    )


def specimen(mode, corners, times=None, name="A"):
    """A test whose platen goes from corner to corner [mm]."""
    times = np.arange(len(corners), dtype=float) * 10.0 if times is None else np.asarray(times)
    time = np.unique(np.concatenate([np.linspace(times[0], times[-1], 2001), times]))
    travel = np.interp(time, times, 1e-3 * np.asarray(corners, dtype=float))
    return Specimen(name, mode, time, travel, 0.0 * time, np.full(len(time), "ramp"), elastic(mode))


def predicted(test, name, others=(), known=EFFECTS, **values):
    effects = (known[name], *(known[other] for other, _ in others))
    state = State(Material(MU, 0.5), {name: values, **dict(others)})
    return Model(effects).predict(test, state)


CYCLES = [0.0, 2.0, 0.5, 3.0, 0.0, 4.0, 1.0, 2.5, 0.0]
"""Loading, partial unloading, beyond the first turn, back, a larger one, and an inner loop."""

BOTH_WAYS = [0.0, 2.0, -3.0, 1.0, -1.0, 4.0, -4.0, 0.0]


def force_by_hand(mode, travel):
    return MU * area(mode, travel)


# ---- softening and loss


def softened(travel, d, power):
    """Sample by sample: the largest displacement either way is remembered."""
    largest, found = 0.0, []
    for x in travel:
        largest = max(largest, abs(x))
        part = abs(x) / largest if largest > 0.0 else 1.0
        found.append(1.0 - d * (1.0 - part**power))
    return np.array(found)


@pytest.mark.parametrize("power", [1.0, 3.0])
@pytest.mark.parametrize(("mode", "corners"), [("tension", CYCLES), ("shear", BOTH_WAYS)])
def test_softening_is_that_below_the_largest_displacement_so_far(mode, corners, power):
    test = specimen(mode, corners)
    force = predicted(test, "mullins_softening", d=0.4, power=power)
    exact = force_by_hand(mode, test.travel) * softened(test.travel, 0.4, power)
    np.testing.assert_allclose(force, exact, rtol=1e-3, atol=1e-6)
    virgin = np.abs(test.travel) >= np.maximum.accumulate(np.abs(test.travel))
    plain = force_by_hand(mode, test.travel)
    np.testing.assert_allclose(force[virgin], plain[virgin], rtol=1e-3, atol=1e-6)
    assert np.abs(force - plain).max() > 0.05 * np.abs(plain).max()


def lost_part(travel, reach):
    """Sample by sample: how far back from the last turn, up to the reach, and forward again."""
    back, last, found = 0.0, 0.0, []
    for x in np.abs(travel):
        back = min(max(back + last - x, 0.0), reach)
        last = x
        found.append(1.0 - (1.0 - back / reach) ** 2)
    return np.array(found)


@pytest.mark.parametrize(
    ("mode", "corners"), [("tension", CYCLES), ("compression", CYCLES), ("shear", BOTH_WAYS)]
)
def test_what_is_lost_on_unloading_comes_back_on_loading(mode, corners):
    test = specimen(mode, corners)
    loss, reach = 0.3, 0.15
    force = predicted(test, "unloading_loss", loss=loss, reach=reach)
    lost = lost_part(test.travel, reach * STROKE)
    plain = force_by_hand(mode, test.travel)
    np.testing.assert_allclose(force, plain * (1.0 - loss * lost), rtol=1e-3, atol=1e-6)
    assert lost.max() == pytest.approx(1.0)


def test_a_second_loading_has_the_whole_force_where_softening_has_less():
    test = specimen("tension", [0.0, 4.0, 0.0, 4.0])
    again = (test.time > 20.0) & (test.travel > 2.5e-3)
    back = (test.time > 10.0) & (test.time < 20.0) & (test.travel < 2.5e-3) & (test.travel > 0.0)
    plain = force_by_hand("tension", test.travel)
    lossy = predicted(test, "unloading_loss", loss=0.2, reach=0.2)
    soft = predicted(test, "mullins_softening", d=0.2, power=1.0)
    np.testing.assert_allclose(lossy[again], plain[again], rtol=1e-3)
    np.testing.assert_allclose(lossy[back], 0.8 * plain[back], rtol=1e-3)
    assert np.all(soft[again][:-1] < plain[again][:-1])


def test_a_wobble_in_a_hold_wears_nothing_out():
    """A reading that trembles by a thousandth, many times, is no unloading."""
    time = np.arange(0.0, 100.0, 0.01)
    travel = np.interp(time, [0.0, 10.0], [0.0, STROKE])
    travel = travel + 1e-3 * STROKE * np.sin(50.0 * time) * (time > 10.0)
    test = replace(
        specimen("tension", [0.0, 4.0]), time=time, travel=travel, force=0.0 * time,
        phase=np.full(len(time), "hold"), held_out=np.zeros(len(time), bool),
    )  # fmt: skip
    plain = force_by_hand("tension", travel)
    force = predicted(test, "unloading_loss", loss=0.5, reach=0.2)
    assert np.abs(force / np.maximum(plain, 1e-9) - 1.0)[time > 10.0].max() < 0.012


# ---- set and slack


def test_a_set_shifts_where_force_begins_and_leaves_the_virgin_curve():
    part = 0.2
    test = specimen("tension", [0.0, 2.0, 0.0, 4.0, 0.0, 4.0])
    force = predicted(test, "permanent_set", set=part)
    largest, places = 0.0, []
    for x in test.travel:
        largest = max(largest, x)
        zero = part * largest  # the sample as it is now is this much longer
        places.append(largest * (x - zero) / (largest - zero) if largest > 0.0 else x)
    pulled = np.array(places) >= 0.0
    exact = force_by_hand("tension", np.array(places))
    np.testing.assert_allclose(force[pulled], exact[pulled], rtol=1e-3, atol=2e-6)
    assert np.all(force[~pulled] < 0.0)
    first_way = test.time <= 10.0
    np.testing.assert_allclose(
        force[first_way], force_by_hand("tension", test.travel[first_way]), rtol=1e-3, atol=1e-6
    )
    beyond = (test.time > 26.0) & (test.time <= 30.0)  # past the first turn, still virgin
    np.testing.assert_allclose(
        force[beyond], force_by_hand("tension", test.travel[beyond]), rtol=1e-3
    )
    at_zero = np.interp(40.0, test.time, force)
    assert at_zero < 0.0


def test_a_platen_leaves_a_sample_that_has_set():
    test = specimen("compression", [0.0, 4.0, 0.0, 4.0])
    force = predicted(test, "permanent_set", set=0.25)
    again = test.time > 20.0
    assert np.all(force >= 0.0)
    assert np.all(force[again & (test.travel < 0.99e-3)] == 0.0)
    assert np.all(force[again & (test.travel > 1.01e-3)] > 0.0)
    assert force[-1] == pytest.approx(force_by_hand("compression", 4e-3), rel=1e-3)


def test_a_set_is_taken_back_by_as_much_to_the_other_side():
    """Shear to one side, to the other and back: the same curve mirrored, and no jump."""
    test = specimen("shear", [0.0, 3.0, -3.0, 3.0])
    force = predicted(test, "permanent_set", set=0.2)
    assert np.interp(20.0, test.time, force) == pytest.approx(force_by_hand("shear", -3e-3), 1e-3)
    zero = np.interp(0.0, *(values[(test.time > 10.0) & (test.time < 20.0)][::-1]
                            for values in (force, test.travel)))  # fmt: skip
    back = np.interp(0.0, *(values[test.time > 20.0] for values in (force, test.travel)))
    assert zero == pytest.approx(0.6e-3, rel=1e-3)
    assert back == pytest.approx(-0.6e-3, rel=1e-3)
    assert np.abs(np.diff(force)).max() < 0.02 * force.max()


def test_a_slack_strip_bears_nothing_and_never_pushes():
    test = specimen("tension", [0.0, 4.0, -1.0, 3.0])
    force = predicted(test, "slack", slack_mm=0.5)
    exact = force_by_hand("tension", np.maximum(test.travel - 0.5e-3, 0.0))
    np.testing.assert_allclose(force, exact, rtol=1e-3, atol=1e-6)
    for mode in ("compression", "shear"):
        other = specimen(mode, [0.0, 4.0, 0.0])
        plain = Model().predict(other, State(Material(MU, 0.5)))
        np.testing.assert_array_equal(predicted(other, "slack", slack_mm=0.5), plain)
    pulled = specimen("pure_shear", [0.0, 4.0])
    assert predicted(pulled, "slack", slack_mm=0.5)[50] == 0.0


@pytest.mark.parametrize("first", ["slack", "viscoelastic_relaxation"])
def test_a_strip_that_has_relaxed_does_not_push_whatever_came_first(first):
    test = specimen("tension", [0.0, 4.0, 4.0, 0.0])
    values = {
        "slack": {"slack_mm": 0.1},
        "viscoelastic_relaxation": {
            "g1": 0.3, "g2": 0.0, "g3": 0.0, "tau1_s": 5.0, "tau3_s": 50.0, "bulk": 0.0
        },
    }  # fmt: skip
    (other,) = (name for name in values if name != first)
    both = predicted(test, first, [(other, values[other])], **values[first])
    assert both.min() == 0.0
    alone = predicted(test, "viscoelastic_relaxation", **values["viscoelastic_relaxation"])
    assert alone.min() < -0.01 * alone.max()


def test_slack_goes_to_nothing_without_a_jump():
    test = specimen("tension", [0.0, 4.0, -1.0])
    plain = predicted(test, "slack", slack_mm=0.0)
    assert plain.min() < 0.0
    near = predicted(test, "slack", slack_mm=1e-6)
    assert np.abs(near - plain).max() < 1e-3 * plain.max()


# ---- contact and channels


@pytest.mark.parametrize("depth", [0.3, 1.5])
def test_an_uneven_face_is_columns_side_by_side(depth):
    """Against the integral of the force over the heights, along cycles."""
    test = specimen("compression", CYCLES)
    force = predicted(test, "uneven_contact", depth_mm=depth)
    fine = np.linspace(-5e-3, 5e-3, 100001)
    whole = cumulative_trapezoid(force_by_hand("compression", fine), fine, initial=0.0)
    ahead, behind = (np.interp(test.travel - low, fine, whole) for low in (0.0, 1e-3 * depth))
    exact = (ahead - behind) / (1e-3 * depth)
    np.testing.assert_allclose(force, exact, atol=1e-3 * exact.max())
    assert np.abs(force - force_by_hand("compression", test.travel)).max() > 0.05 * exact.max()


def normal_of(test):
    """Normal force that is even in the shear, beside the force along it."""
    travel = test.elastic.curves.displacement
    curves = ResponseCurves(np.array([0.5]), travel, -0.1 * area("shear", travel)[None], "even")
    return replace(test, elastic=Elastic(curves, {}), channel=NORMAL, partner=test)


def test_the_normal_channel_reads_a_part_of_the_predicted_shear_force():
    test = normal_of(specimen("shear", BOTH_WAYS))
    shear = force_by_hand("shear", test.travel)
    force = predicted(test, "channel_crosstalk", share=-0.05)
    np.testing.assert_allclose(force, -0.1 * np.abs(shear) - 0.05 * shear, rtol=1e-3, atol=1e-6)
    relaxing = {"d": 0.4, "power": 1.0}
    force = predicted(test, "channel_crosstalk", [("mullins_softening", relaxing)], share=-0.05)
    soft = softened(test.travel, 0.4, 1.0)
    exact = (-0.1 * np.abs(shear) - 0.05 * shear) * soft
    np.testing.assert_allclose(force, exact, rtol=1e-3, atol=1e-6)


def test_no_measured_force_is_part_of_the_crosstalk():
    test = normal_of(specimen("shear", BOTH_WAYS))
    wild = replace(test, partner=replace(test.partner, force=test.partner.force + 7.0))
    one, other = (predicted(t, "channel_crosstalk", share=0.1) for t in (test, wild))
    np.testing.assert_array_equal(one, other)


def test_the_partner_keeps_step_with_its_specimen():
    test = normal_of(specimen("shear", BOTH_WAYS)).reduced(7)
    np.testing.assert_array_equal(test.partner.time, test.time)
    assert predicted(test, "channel_crosstalk", share=0.1).shape == test.time.shape


def test_the_force_of_the_same_record_is_the_partner_of_its_normal_force():
    test = specimen("shear", [0.0, 4.0])
    travel = test.elastic.curves.displacement
    record = Record(test.time, test.travel, test.force, test.force + 1.0).marked("shear")
    table = {"mu1_fraction": 0.5, "displacement_mm": 1e3 * travel}
    forces = {"force_per_mu_mm2": 1e6 * area("shear", travel), "normal_force_per_mu_mm2": travel}
    curves = pd.DataFrame(table | forces)
    row = {"sample": "A", "mode": "shear", "specimen": "A"}
    shape = IdealShape("cuboid", LENGTH, LENGTH, LENGTH)
    along, normal = specimens_of(row, record, Tables(curves, [], SOLID), shape, [])
    assert (along.channel, normal.channel) == (FORCE, NORMAL)
    assert (along.partner, normal.partner) == (None, along)


# ---- samples and modes


def test_samples_of_one_specimen_share_its_stiffness():
    pulls = [
        replace(specimen("tension", [0.0, 4.0], name=n), piece=n[0])
        for n in ("A1", "A2", "B1", "B2")
    ]
    away = replace(pulls[0], piece="C", held_out=np.ones(len(pulls[0].force), bool))
    known = library(SOLID, [*pulls, away])
    assert [p.name for p in known["specimen_stiffness"].parameters] == ["B"]
    first, later = (predicted(t, "specimen_stiffness", known=known, B=0.8) for t in pulls[1:3])
    np.testing.assert_allclose(later, 0.8 * first)


def test_each_later_specimen_of_a_mode_has_a_stiffness_of_its_own():
    pulls = [specimen("tension", [0.0, 4.0, 0.0], name=name) for name in "ABC"]
    press = specimen("compression", [0.0, 4.0, 0.0], name="P")
    known = library(SOLID, [*pulls, press])
    effect = known["specimen_stiffness"]
    assert [p.name for p in effect.parameters] == ["B", "C"]
    plain = force_by_hand("tension", pulls[0].travel)
    for test, factor in zip(pulls, (1.0, 0.8, 1.3), strict=True):
        force = predicted(test, effect.name, known=known, B=0.8, C=1.3)
        np.testing.assert_allclose(force, factor * plain, rtol=1e-3, atol=1e-6)
    normal = normal_of(specimen("shear", [0.0, 4.0], name="B"))
    force = predicted(normal, effect.name, known=known, B=0.8, C=1.3)
    np.testing.assert_allclose(
        force, -0.08 * force_by_hand("shear", normal.travel), rtol=1e-3, atol=1e-6
    )
    assert predicted(press, effect.name, known=known, B=0.8, C=1.3) == pytest.approx(
        force_by_hand("compression", press.travel), rel=1e-3, abs=1e-6
    )


def test_shear_is_scaled_against_tension_and_compression():
    for mode, factor in {"tension": 1.0, "compression": 1.0, "shear": 0.8}.items():
        test = specimen(mode, CYCLES)
        force = predicted(test, "mode_ratio", shear_over_axial=0.8)
        exact = factor * force_by_hand(mode, test.travel)
        np.testing.assert_allclose(force, exact, rtol=1e-3, atol=1e-6)


def test_effects_between_tests_are_candidates_where_there_are_such_tests():
    def named(*tests):
        tests = [replace(t, force=0.0 * t.force + 1.0) for t in tests]
        return {effect.name for effect in candidates(tests, LENGTH, SOLID)}

    between = {"channel_crosstalk", "mode_ratio", "specimen_stiffness"}
    pull, press, shear = (specimen(m, CYCLES, name=m) for m in ("tension", "compression", "shear"))
    assert named(pull, press) & between == set()
    assert named(shear) & between == set()
    assert named(pull, shear) & between == {"mode_ratio"}
    assert named(pull, replace(pull, name="other", piece="other")) & between == {
        "specimen_stiffness"
    }
    assert named(shear, normal_of(shear)) & between == {"channel_crosstalk"}


# ---- relaxation


def lost(time, force, part):
    """What a force that is straight between samples loses, `part` (n,) of each rise by its age."""
    age = np.concatenate([[0.0], np.geomspace(1e-5, time[-1], 8000)])
    whole = cumulative_trapezoid(part(age), age, initial=0.0)
    slopes = np.diff(force) / np.diff(time)
    bends = np.diff(slopes, prepend=0.0, append=0.0)
    since = np.maximum(time[:, None] - time[None, :], 0.0)
    return np.interp(since, age, whole) @ bends


LOSSES = {
    "stretched exponential": lambda age: 0.4 * -np.expm1(-((age / 9.0) ** 0.6)),
    "power law": lambda age: 1.0 - (1.0 + age) ** -0.2,
    "three exponentials": lambda age: sum(
        g * -np.expm1(-age / tau) for g, tau in ((0.2, 1.5), (0.1, 9.0), (0.2, 70.0))
    ),
    "one exponential": lambda age: 0.3 * -np.expm1(-age / 14.0),
}


@pytest.mark.parametrize("kind", LOSSES)
@pytest.mark.parametrize(
    ("corners", "times"),
    [
        ([0.0, 4.0, 4.0, 0.0], [0.0, 12.0, 72.0, 84.0]),
        ([0.0, 4.0, 0.0, 4.0, 0.0], [0.0, 20.0, 40.0, 60.0, 80.0]),
    ],
    ids=["hold", "two cycles"],
)
def test_a_spectrum_is_followed_to_one_percent_of_what_is_lost(kind, corners, times):
    """Beside a scale of the force, which the modulus takes; sizes stay parts of a force."""
    test = specimen("tension", corners, times)
    plain = Model().predict(test, State(Material(MU, 0.5)))
    wanted = lost(test.time, plain, LOSSES[kind])
    effect = library(SOLID, [test])["viscoelastic_relaxation"]
    free = [p for p in effect.parameters if p.name != "bulk"]
    unit = np.array([p.high - p.low for p in free])

    def off(vector):
        values = dict(zip([p.name for p in free], vector[1:] * unit, strict=True))
        found = effect.tissue(test, plain, test.travel, values)
        return (plain - vector[0] * found - wanted) / np.abs(wanted).max()

    start = np.array([p.nominal for p in free])
    low, high = (np.array([getattr(p, end) for p in free]) for end in ("low", "high"))
    fit = least_squares(
        off, [1.0, *(start / unit)], bounds=([0.5, *(low / unit)], [1.5, *(high / unit)]),
        x_scale=0.1, max_nfev=40,
    )  # fmt: skip
    assert np.abs(fit.fun).max() < 0.01
    sizes = fit.x[1:4] * unit[:3]
    assert 0.0 <= sizes.sum() < 0.9


def test_times_of_relaxation_lie_within_the_clock_of_the_records():
    slow = specimen("tension", [0.0, 4.0, 4.0], [0.0, 20.0, 500.0])
    fast = specimen("tension", [0.0, 4.0, 4.0], [0.0, 2.0, 50.0])
    assert fast.loading_time == pytest.approx(2.0)
    effect = library(SOLID, [slow, fast])
    first, last = (
        p for p in effect["viscoelastic_relaxation"].parameters if p.name in ("tau1_s", "tau3_s")
    )
    assert first.low == pytest.approx(0.1, rel=0.02)
    assert first.high == last.low == pytest.approx(np.sqrt(0.1 * 500.0), rel=0.02)
    assert last.high == pytest.approx(1500.0)


def test_each_term_of_a_spectrum_is_that_of_its_time():
    """A step that lasts: each size is what is lost in the end, at times of equal ratio."""
    test = specimen("tension", [0.0, 4.0, 4.0], [0.0, 0.01, 200.0])
    values = {"g1": 0.1, "g2": 0.2, "g3": 0.3, "tau1_s": 2.0, "tau3_s": 50.0, "bulk": 0.0}
    force = predicted(test, "viscoelastic_relaxation", **values)
    age = test.time - 0.005
    kept = 1.0 - sum(g * -np.expm1(-age / tau) for g, tau in ((0.1, 2.0), (0.2, 10.0), (0.3, 50.0)))
    late = test.time > 0.1
    np.testing.assert_allclose(
        force[late], (force_by_hand("tension", 4e-3) * kept)[late], rtol=2e-3
    )
