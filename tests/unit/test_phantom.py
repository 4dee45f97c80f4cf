"""The phantoms themselves, against closed forms; lengths in mm."""

from dataclasses import replace

import numpy as np
import pytest

from phantom.draw import random_cylinder, random_scan
from phantom.scan import TISSUE, Scan
from phantom.shapes import ImperfectCylinder
from phantom.sizes import measured, surface_points
from softsample.blindlab.phantom import (
    ImperfectCuboid,
    Waves,
    gradient,
    random_cuboid,
    signed_distance,
)

FLAT = Waves()
BOX = ImperfectCuboid(10.0, 8.0, 6.0, (FLAT,) * 4, FLAT, 0.0, (0.0, 0.0), 1.0)
DISC = ImperfectCylinder(9.0, 5.0, (), FLAT, FLAT, 0.0, (0.0, 0.0), 1.0)
UPPER = 1.0 - np.sqrt(1.0 - 0.25**2)
"""What the round of the rim takes from the upper section of the cuboid on each side."""
QUIET = Scan(snr=1e6, bias=0.0, texture=0.0)


def test_rounded_box_is_measured_as_in_closed_form():
    """Section: rectangle less corners; the top's rim loses what a quarter round leaves out.

    The upper of the three sections lies 0.25 mm within the round.
    """
    got = measured(BOX)
    lost = 2.0 * UPPER / 3.0
    corners = (4.0 - np.pi) * 1.0**2
    straight = (10.0 * 8.0 - corners) * 5.0
    inner, rim = 8.0 * 6.0, 2.0 * (8.0 + 6.0)
    cap = inner * 1.0 + rim * np.pi / 4.0 + 2.0 / 3.0 * np.pi  # a half ball in four corners
    assert got.volume == pytest.approx(straight + cap, rel=2e-4)
    assert (got.length, got.width, got.height) == pytest.approx(
        (10.0 - lost, 8.0 - lost, 6.0), abs=2e-3
    )
    assert got.highest == pytest.approx(6.0, abs=1e-3)
    assert got.bottom_area == pytest.approx(80.0 - corners, rel=1e-3)


def test_disc_is_measured_as_in_closed_form():
    got, core = measured(DISC), 0.7
    assert got.bottom_area == pytest.approx(np.pi * 4.5**2, rel=1e-3)
    mean_radius = 4.5 - UPPER / 3.0
    mean_chord = mean_radius * (np.arcsin(core) / core + np.sqrt(1.0 - core**2))
    assert got.length == pytest.approx(mean_chord, abs=1e-2)


@pytest.mark.parametrize("shape", [random_cuboid(3, 2.0), random_cylinder(3, 2.0)])
def test_distance_is_exact_to_a_micrometre(shape):
    """Points at a known way along the normal of surface points."""
    points, _ = surface_points(shape, 0.6)
    points = points[points[:, 2] > 0.5]
    normal = gradient(shape, points)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    for way in (-0.3, 0.02, 0.3):
        assert np.abs(signed_distance(shape, points + way * normal) - way).max() < 1e-3


def test_signal_of_an_image_is_that_of_its_tissue_and_film():
    """Partial volume keeps the sum; a film adds its volume times its brightness."""
    image, affine = QUIET.image(BOX)
    voxel = abs(np.linalg.det(affine[:3, :3]))
    assert image.sum() * voxel / TISSUE == pytest.approx(measured(BOX).volume, rel=2e-3)
    wet, _ = replace(QUIET, film=0.08).image(BOX)
    area = np.linalg.norm(surface_points(BOX)[1], axis=1).sum()
    gain = (wet.astype(float) - image).sum() * voxel / TISSUE
    assert gain == pytest.approx(0.08 * 2.2 * area, rel=0.15)  # its ripple has no zero mean


def test_noise_bias_and_texture_are_as_ordered():
    clean, _ = QUIET.image(BOX)
    inside = clean > 0.99 * TISSUE
    noisy, _ = replace(QUIET, snr=20.0).image(BOX)
    assert np.std(noisy[inside]) == pytest.approx(TISSUE / 20.0, rel=0.03)
    assert np.mean(noisy[clean == 0]) == pytest.approx(1.2533 * TISSUE / 20.0, rel=0.02)  # Rayleigh
    grey, _ = replace(QUIET, texture=0.3).image(BOX)
    assert np.ptp(grey[inside]) / TISSUE == pytest.approx(0.3, abs=0.03)
    biased, _ = replace(QUIET, bias=0.3).image(BOX)
    assert 0.1 < np.abs(biased[inside] / TISSUE - 1.0).max() <= 0.31


def test_the_same_seed_gives_the_same_phantom():
    shape = random_cuboid(7)
    assert shape == random_cuboid(7)
    assert shape != random_cuboid(8)
    scan = random_scan(7, shape, "isotropic", 0.05)
    first, affine = scan.image(shape)
    again, same = random_scan(7, shape, "isotropic", 0.05).image(shape)
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(affine, same)
    assert scan.tissue_mask(shape).shape == first.shape
