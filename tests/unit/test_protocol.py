from itertools import pairwise

import numpy as np
import pytest

from softsample.errors import InputError
from softsample.protocol import (
    MODES,
    Course,
    denoised,
    loading,
    phases,
    smooth_step,
    travel_sign,
)


def history(*legs, rate=100.0, noise=1e-6, seed=3):
    """Displacement [m] of legs (duration [s], end [mm]), with white reading noise."""
    times, ends = np.cumsum([0.0, *(leg[0] for leg in legs)]), [0.0, *(leg[1] for leg in legs)]
    time = np.arange(0.0, times[-1] + 0.5 / rate, 1.0 / rate)
    clean = np.interp(time, times, 1e-3 * np.array(ends))
    return time, clean + noise * np.random.default_rng(seed).normal(size=len(time))


def loading_ramp(time, displacement, mode=None):
    """Samples of the last ramp of the loading that is calibrated."""
    return Course.of(time, displacement, mode).chosen().ramps[-1]


def test_smooth_step_starts_and_ends_at_rest():
    x = np.linspace(0.0, 1.0, 11)
    assert smooth_step([-1.0, 0.0, 0.5, 1.0, 2.0]).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
    np.testing.assert_allclose(smooth_step(x) + smooth_step(1.0 - x), 1.0, rtol=1e-15)


@pytest.mark.parametrize(
    ("reach", "speed", "digit"),
    [(3.9, 0.3, 0.01), (6.0, 0.3, 0.01), (8.0, 0.5, 0.01), (3.9, 0.3, 0.05), (3.9, 0.3, 0.001)],
)
@pytest.mark.parametrize("rounded", [np.round, np.floor])
def test_a_reading_that_rises_in_steps_has_the_phases_of_the_travel(reach, speed, digit, rounded):
    """A hundred readings a second of a coarse encoder."""
    way = reach / speed
    time, d = history((1.013, 0.0), (way, reach), (10.0, reach), (way, 0.0), noise=0.0)
    read = 1e-3 * digit * rounded(1e3 * d / digit)
    found = phases(time, read)
    assert [phase.kind for phase in found] == ["baseline", "ramp", "hold", "unloading"]
    starts = [time[phase.start] for phase in found]
    late = 2.0 * digit / speed + 0.05
    np.testing.assert_allclose(starts, [0.0, 1.013, 1.013 + way, 11.013 + way], atol=late)
    ramp = loading_ramp(time, read)
    assert read[ramp][-1] - read[ramp][0] == pytest.approx(1e-3 * reach, abs=2.1e-3 * digit)


@pytest.mark.parametrize("rate", [50.0, 500.0])
@pytest.mark.parametrize("part", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("digit", [0.005, 0.02])
def test_a_rounded_reading_may_be_noisy(digit, part, rate):
    """Noise of less than a third of a digit leaves most readings as they are."""
    legs = (5.0, 0.0), (20.0, 2.0), (20.0, 2.0), (20.0, 0.0), (5.0, 0.0)
    time, d = history(*legs, rate=rate, noise=1e-3 * part * digit, seed=1)
    found = phases(time, 1e-3 * digit * np.round(1e3 * d / digit))
    assert [phase.kind for phase in found] == ["baseline", "ramp", "hold", "unloading", "hold"]
    starts = [time[phase.start] for phase in found]
    np.testing.assert_allclose(starts, [0.0, 5.0, 25.0, 45.0, 65.0], atol=20.0 * digit + 0.05)


@pytest.mark.parametrize("samples", [6, 12, 25, 50])
def test_samples_of_a_curve_may_be_unevenly_spaced(samples):
    """Digitised by hand, without time: uneven steps are neither noise nor rest."""
    for seed in range(20):
        up, down = np.sort(np.random.default_rng(seed).uniform(0.0, 4e-3, (2, samples)))
        d = np.concatenate([[0.0], up, [4e-3], down[::-1], [0.0]])
        assert [phase.kind for phase in phases(None, d)] == ["ramp", "unloading"]
        assert [phase.kind for phase in phases(None, d[: samples + 2])] == ["ramp"]


def test_samples_at_uneven_times_have_the_phases_of_the_travel():
    corners = np.array([0.0, 2.0, 14.0, 16.0, 28.0])
    for seed in range(20):
        between = np.random.default_rng(seed).uniform(0.0, 28.0, 60)
        time = np.sort(np.concatenate([corners, between]))
        found = phases(time, np.interp(time, corners, [0.0, 0.0, 3e-3, 3e-3, 0.0]))
        assert [phase.kind for phase in found] == ["baseline", "ramp", "hold", "unloading"]
        assert [time[phase.start] for phase in found] == corners[:4].tolist()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("second", [0.98, 1.0, 1.025])
def test_a_cycle_to_both_sides_is_loaded_first_to_the_first(sign, second):
    for seed in range(4):
        time, d = history((1.0, 0.0), (5.0, 2.0), (10.0, -2.0 * second), (5.0, 0.0), seed=seed)
        found = phases(time, sign * d)
        kinds = [phase.kind for phase in found]
        assert kinds == ["baseline", "ramp", "unloading", "ramp", "unloading"]
        ramp = loading_ramp(time, sign * d)
        assert time[ramp.start] == pytest.approx(1.0, abs=0.05)
        assert time[ramp.stop - 1] == pytest.approx(6.0, abs=0.05)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_all_phases_of_a_test_are_found(sign):
    time, d = history((2.0, 0.0), (10.0, 3.0), (30.0, 3.0), (5.0, 0.0))
    found = phases(time, sign * d)
    assert [phase.kind for phase in found] == ["baseline", "ramp", "hold", "unloading"]
    starts = [time[phase.start] for phase in found]
    np.testing.assert_allclose(starts, [0.0, 2.0, 12.0, 42.0], atol=0.1)
    assert found[-1].stop == len(time)
    assert all(a.stop == b.start for a, b in pairwise(found))


def test_a_curved_ramp_is_one_phase():
    time = np.arange(0.0, 14.0, 0.01)
    noise = 1e-6 * np.random.default_rng(5).normal(size=len(time))
    d = 3e-3 * smooth_step((time - 2.0) / 10.0) + noise
    assert [phase.kind for phase in phases(time, d)] == ["baseline", "ramp", "hold"]


def test_slow_and_fast_ramps_are_both_found():
    time, d = history((1.0, 0.0), (0.5, 2.0), (5.0, 2.0), (200.0, 4.0))
    assert [phase.kind for phase in phases(time, d)] == ["baseline", "ramp", "hold", "ramp"]


def test_a_record_that_starts_moving_has_no_baseline():
    time, d = history((10.0, -3.0))
    assert [phase.kind for phase in phases(time, d)] == ["ramp"]


def test_loading_ramp_passes_over_preconditioning():
    time, d = history((1.0, 0.0), (2.0, -1.0), (2.0, 0.0), (10.0, -4.0), (5.0, -4.0))
    ramp = loading_ramp(time, d)
    assert time[ramp][0] == pytest.approx(5.0, abs=0.1)
    assert time[ramp][-1] == pytest.approx(15.0, abs=0.1)


def test_loading_ramp_includes_its_last_sample():
    time, d = history((0.5, 0.0), (13.0, -3.9), noise=0.0)
    assert loading_ramp(time, d).stop == len(time)


def test_a_platen_at_rest_is_refused():
    time, d = history((10.0, 0.0))
    with pytest.raises(InputError, match="there is no loading ramp"):
        loading_ramp(time, d)


def test_a_mode_tells_the_direction_of_loading():
    signs = {mode: travel_sign(mode) for mode in MODES}
    assert signs == {
        "tension": 1.0,
        "compression": -1.0,
        "shear": 1.0,
        "pure_shear": 1.0,
        "confined_compression": -1.0,
        "indentation": -1.0,
        "torsion": 1.0,
    }


def course(*legs, mode=None, timed=True, **noise):
    """Clock, displacement [mm] and course of legs (duration [s], end [mm])."""
    time, d = history(*legs, **noise)
    clock = time if timed else np.arange(len(time), dtype=float)
    return clock, 1e3 * d, Course.of(clock, d, mode)


def ends(displacement, loading):
    """Displacement [mm] at both ends of each ramp of a loading."""
    return [[displacement[ramp.start], displacement[ramp.stop - 1]] for ramp in loading.ramps]


@pytest.mark.parametrize("timed", [True, False])
def test_preconditioning_is_counted_and_passed_over(timed):
    conditioning = [(2.0, -2.0), (2.0, 0.0)] * 5
    _, d, found = course((1.0, 0.0), *conditioning, (3.0, 0.0), (10.0, -4.0), timed=timed)
    assert len(found.loadings) == 6
    assert found.number() == 6
    np.testing.assert_allclose(ends(d, found.chosen()), [[0.0, -4.0]], atol=0.05)
    np.testing.assert_allclose(ends(d, found.chosen("2")), [[0.0, -2.0]], atol=0.05)
    assert found.chosen("last") == found.chosen("6") == found.chosen()
    assert found.chosen("first") == found.chosen("1")
    assert found.chosen("2").start == pytest.approx(500, abs=5)
    with pytest.raises(InputError, match="no loading 7: the record has 6; give first, last or a"):
        found.chosen("7")


def test_a_cycle_lasts_until_the_next_loading():
    _, _, found = course((1.0, 0.0), (2.0, 3.0), (2.0, 0.0), (2.0, 0.0), (2.0, 3.0), (2.0, 0.0))
    assert len(found.cycle) == len(found.phase) == 1101
    assert found.cycle[[0, 90, 110, 400, 690, 710, 1100]].tolist() == [0, 0, 1, 1, 1, 2, 2]
    assert found.phase[[0, 200, 400, 600, 800, 1000]].tolist() == [
        *("baseline", "ramp", "unloading", "hold", "ramp", "unloading")
    ]
    assert found.number() == 1  # of equal ones the first


def test_steps_with_holds_between_them_are_one_loading():
    steps = [leg for end in (1.0, 2.0, 3.0) for leg in ((2.0, end), (10.0, end))]
    _, d, found = course((1.0, 0.0), *steps, (3.0, 0.0))
    (loading,) = found.loadings
    np.testing.assert_allclose(ends(d, loading), [[0, 1], [1, 2], [2, 3]], atol=0.05)
    assert set(found.cycle[150:]) == {1}


def test_cycles_of_growing_size_are_loadings_of_their_own():
    grow = [leg for end in (0.5, 1.0, 2.0, 4.0) for leg in ((2.0, end), (2.0, 0.0))]
    _, _, found = course((1.0, 0.0), *grow)
    assert [round(1e3 * loading.peak, 1) for loading in found.loadings] == [0.5, 1.0, 2.0, 4.0]
    assert found.number() == 4


@pytest.mark.parametrize(("back", "loadings"), [(1.2, 2), (2.8, 1)])
def test_half_of_the_displacement_has_to_be_given_back(back, loadings):
    _, _, found = course((1.0, 0.0), (4.0, 4.0), (2.0, back), (4.0, 4.0))
    assert len(found.loadings) == loadings


def test_a_fluctuation_during_unloading_is_no_loading():
    down = [leg for end in (1.6, 1.2, 0.8, 0.4, 0.0) for leg in ((4.0, end - 0.02), (0.5, end))]
    _, d, found = course((1.0, 0.0), (4.0, 2.0), *down, (4.0, 0.0))
    (only,) = found.loadings
    np.testing.assert_allclose(ends(d, only), [[0.0, 2.0]], atol=0.01)
    again = [leg for end in 0.04 * np.arange(1, 51) for leg in ((0.4, end), (2.0, end))]
    _, d, found = course((1.0, 0.0), (4.0, 2.0), *down, (4.0, 0.0), *again)
    assert len(found.loadings) == 2  # whose first steps are no larger than a fluctuation
    np.testing.assert_allclose(ends(d, found.chosen("2"))[0], [0.0, 0.04], atol=0.01)


@pytest.mark.parametrize("mode", ["compression", "tension"])
def test_a_platen_may_be_lifted_further_than_it_pressed(mode):
    """In tension the way up is the test, whatever came before it."""
    legs = (5.0, 0.0), (40.0, -2.0), (20.0, 0.0), (10.0, 10.0), (5.0, 10.0)
    _, d, found = course(*legs, mode=mode)
    wanted = {"compression": [[0.0, -2.0]], "tension": [[0.0, 10.0]]}
    np.testing.assert_allclose(ends(d, found.chosen()), wanted[mode], atol=0.05)


def test_a_touch_before_the_test_is_no_loading():
    _, _, found = course((1.0, 0.0), (1.0, 0.1), (1.0, 0.0), (5.0, 4.0), (5.0, 0.0))
    assert len(found.loadings) == 1
    assert found.cycle[150] == 0


@pytest.mark.parametrize("timed", [True, False])
@pytest.mark.parametrize("first", [2.0, -2.0])
def test_a_shear_cycle_goes_to_both_sides(first, timed):
    """Loadings are counted along +x, whichever side comes first."""
    sides = [(2.0, first), (4.0, -first)] * 3
    _, d, found = course((1.0, 0.0), *sides, (2.0, 0.0), mode="shear", timed=timed)
    assert len(found.loadings) == 3
    for one in found.loadings:
        np.testing.assert_allclose(ends(d, one), [[0.0, 2.0]], atol=0.05)
    assert {"ramp", "unloading"} <= set(found.phase[d < -0.1])


def test_a_sweep_through_zero_is_unloaded_then_loaded():
    """From -g to +g without time, as published shear curves are."""
    d = np.linspace(-2e-3, 2e-3, 33)
    found = Course.of(None, d, "shear")
    assert [phase.kind for phase in found.phases] == ["unloading", "ramp"]
    assert found.chosen().ramps == (slice(16, 33),)
    assert found.cycle.tolist() == [0] * 16 + [1] * 17
    back = Course.of(None, d[::-1], "shear")
    assert d[::-1][back.chosen().last] == -2e-3  # as the file has it; the signs are checked later


def test_a_sweep_is_one_ramp_where_zero_is_no_state_of_its_own():
    """A platen comes down through zero in compression; a platen at rest begins where it rests."""
    d = np.linspace(0.5e-3, -4e-3, 200)
    found = Course.of(None, d, "compression")
    assert found.chosen().ramps == (slice(0, 200),)
    _, d, rested = course((2.0, 0.0), (4.0, 4.0))
    again = Course.of(None, 1e-3 * (d - 2.0), "shear")
    assert again.chosen().ramps == rested.chosen().ramps


def test_straight_legs_are_straight_lines():
    """Not one in a thousand is taken for bent."""
    for seed in range(20):
        time, d = history((2.0, 0.0), (10.0, 3.0), (6.0, 3.0), (10.0, 0.0), seed=seed)
        found = denoised(time, d)
        bends = np.abs(np.diff(found, 2)) > 1e-12
        assert bends.sum() <= 12  # two a corner; a bent leg has hundreds
        truth = np.interp(time, [0.0, 2.0, 12.0, 18.0, 28.0], [0.0, 0.0, 3e-3, 3e-3, 0.0])
        assert np.sqrt(np.mean((found - truth) ** 2)) < 0.3e-6


@pytest.mark.parametrize("digit", [0.0, 10e-6])
def test_a_travel_that_bends_is_followed(digit):
    """Read at the sample of a machine that gives way: slow at first, then faster than a line."""
    time, d = history((2.0, 0.0), (10.0, 3.0), (6.0, 3.0), (10.0, 0.0), noise=0.0)
    bent = d + 1e-4 * (d / 3e-3) ** 3
    read = bent + 1e-6 * np.random.default_rng(1).normal(size=len(time))
    read = np.round(read / digit) * digit if digit else read
    away = denoised(time, read) - bent
    assert np.sqrt(np.mean(away**2)) < max(0.5e-6, 0.2 * digit)


def test_loading_does_not_depend_on_the_order_of_samples():
    assert loading(["compression", "tension"]) == loading(["tension", "compression"])
    assert loading(["tension", "compression"]) == "tension+compression"
    assert loading(["shear", "shear"]) == "shear"
    assert loading(["confined_compression", "pure_shear"]) == "pure_shear+confined_compression"
