from itertools import pairwise

import numpy as np
import pytest

from softsample.errors import InputError
from softsample.protocol import loading_ramp, phases, smooth_step


def history(*legs, rate=100.0, noise=1e-6, seed=3):
    """Displacement [m] of legs (duration [s], end [mm]), with white reading noise."""
    times, ends = np.cumsum([0.0, *(leg[0] for leg in legs)]), [0.0, *(leg[1] for leg in legs)]
    time = np.arange(0.0, times[-1] + 0.5 / rate, 1.0 / rate)
    clean = np.interp(time, times, 1e-3 * np.array(ends))
    return time, clean + noise * np.random.default_rng(seed).normal(size=len(time))


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
