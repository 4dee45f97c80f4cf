"""A top without relief: the error of its surface is no relief."""

import numpy as np
import pytest

from phantom.scan import Scan
from phantom.sizes import measured
from softsample.blindlab.phantom import ImperfectCuboid, Waves
from softsample.imaging import relief
from softsample.imaging.segment import segment

FLAT = Waves((0.0,), ((0.0, 0.0),), (0.0,))
BUMPS = Waves((0.15,), ((0.45, 0.37),), (0.0,))


def highest(top, voxel, snr, slope=0.02):
    """Highest point found, over the true one [mm]."""
    shape = ImperfectCuboid(18.0, 16.0, 10.0, (FLAT,) * 4, top, 0.0, (slope, 0.0), 0.1)
    scan = Scan(voxel=voxel, margin=0.5, snr=snr)
    return 1e3 * segment(*scan.image(shape)).highest_point[2] - measured(shape).highest


# the highest point of the surface's error, and of what the edge's rounding does: 0.07 to 0.15 mm
@pytest.mark.parametrize(
    ("voxel", "snr", "slope"),
    [((0.3, 0.3, 0.5), 25.0, 0.02), ((0.5, 0.5, 0.5), 10.0, 0.02), ((0.3, 0.3, 0.8), 25.0, 0.0)],
)
def test_the_highest_point_of_a_flat_top_is_that_of_its_plane(voxel, snr, slope):
    assert highest(FLAT, voxel, snr, slope) == pytest.approx(0.0, abs=0.05)


def test_relief_stays_as_it_is(monkeypatch):
    now = highest(BUMPS, (0.5, 0.5, 0.5), 25.0)
    monkeypatch.setattr(relief, "SHOWN", 0.0)
    assert highest(BUMPS, (0.5, 0.5, 0.5), 25.0) == now


def test_tissue_below_the_error_is_filled_up_and_what_stands_out_is_cut_off():
    x, z = 0.25e-3 * np.arange(-40, 41), 0.25e-3 * np.arange(60)
    top = 10e-3 + 0.01 * x[:, None] + 0.0 * x
    error = 0.02e-3 * np.random.default_rng(0).normal(size=top.shape)
    wide = np.maximum(abs(x[:, None]), abs(x))
    rim = 0.1e-3 * (wide > 8e-3)
    walls = wide - 9e-3
    exact, distance = (
        np.maximum(walls[:, :, None], z - height[:, :, None]) for height in (top, top + error + rim)
    )
    sigma = np.full(distance.shape, 0.02e-3)
    found = relief.without_error(distance, sigma, np.array([-10e-3, -10e-3, 0.0]), 0.25e-3)
    near = (abs(exact) < 0.5e-3) & (walls < -0.5e-3)[:, :, None]
    assert np.abs(found - exact)[near].max() < 0.01e-3
    assert np.abs(distance - exact)[near].max() > 0.1e-3
