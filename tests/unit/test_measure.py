"""Cuboid and areas of shapes whose distance is known in closed form; lengths in mm."""

import numpy as np
import pytest

from phantom.draw import random_cylinder
from softsample.blindlab.phantom import random_cuboid
from softsample.errors import InputError, SegmentationError
from softsample.imaging.measure import (
    ROUND,
    MeasurementSettings,
    circularity,
    mean_width,
    measure,
    proposed_shape,
    section_area,
)

SPACING = 0.25e-3
ORIGIN = np.array([-12.0e-3, -10.0e-3, -2.5e-3])
SHAPE = (97, 81, 71)
RIM = 0.25  # mm: a sharp edge on grid points is chamfered by one cell; tissue has no such edge


def grid():
    index = np.indices(SHAPE).astype(np.float64)
    return [1e3 * (ORIGIN[k] + SPACING * index[k]) for k in range(3)]


def halfspaces(*sides):
    """Signed distance to the meeting of half-spaces: exact inside and beyond each face [m]."""
    return 1e-3 * np.max(sides, axis=0)


def box(length=18.0, width=15.0, top=lambda x, y: 12.0 + 0.0 * x, slope=0.0):
    x, y, z = grid()
    roof = (z - top(x, y)) / np.hypot(1.0, slope)
    return halfspaces(abs(x) - length / 2.0, abs(y) - width / 2.0, roof)


def test_box_is_measured_exactly():
    got = measure(box(), ORIGIN, SPACING)
    assert got["length_mm"] == pytest.approx(18.0, abs=1e-3)
    assert got["width_mm"] == pytest.approx(15.0, abs=1e-3)
    assert got["height_mm"] == pytest.approx(12.0, abs=1e-3)
    assert got["bottom_area_mm2"] == pytest.approx(270.0, rel=1e-3)  # corners are chamfered
    assert got["top_area_mm2"] == pytest.approx((18.0 - 2.0 * RIM) * (15.0 - 2.0 * RIM), rel=1e-6)
    assert got["glued_area_mm2"] == pytest.approx(270.0, rel=0.03)
    assert got["volume_real_mm3"] == pytest.approx(3240.0, rel=3e-3)
    assert got["ideal_area_mm2"] == pytest.approx(270.0, rel=1e-4)
    assert got["bottom_difference_percent"] == pytest.approx(0.0, abs=0.1)
    assert got["highest_point_mm"] == pytest.approx(12.0, abs=1e-6)


def test_lengths_between_grid_points_are_sub_voxel():
    got = measure(box(17.87, 15.11, lambda x, y: 11.93 + 0.0 * x), ORIGIN, SPACING)
    assert got["length_mm"] == pytest.approx(17.87, abs=1e-3)
    assert got["width_mm"] == pytest.approx(15.11, abs=1e-3)
    assert got["height_mm"] == pytest.approx(11.93, abs=1e-3)


def test_tilted_top():
    """Mean height in the core is that of the middle; glued is the strip within the pre-load."""
    got = measure(box(top=lambda x, y: 12.0 + 0.1 * x, slope=0.1), ORIGIN, SPACING)
    assert got["height_mm"] == pytest.approx(12.0, abs=2e-3)
    assert got["highest_point_mm"] == pytest.approx(12.9, abs=0.03)
    assert got["top_area_mm2"] == pytest.approx(270.0, rel=0.02)
    assert got["glued_area_mm2"] == pytest.approx(10.0 * 15.0, rel=0.03)
    deeper = measure(
        box(top=lambda x, y: 12.0 + 0.1 * x, slope=0.1),
        ORIGIN,
        SPACING,
        MeasurementSettings(preload_mm=0.5),
    )
    assert deeper["glued_area_mm2"] == pytest.approx(5.0 * 15.0, rel=0.05)


@pytest.mark.parametrize(("slope", "seen"), [(0.45, 1.0), (0.70, 0.0)])
def test_top_ends_at_thirty_degrees(slope, seen):
    """A roof of 24 degrees is top, one of 35 degrees is not."""
    got = measure(box(top=lambda x, y: 12.0 - slope * abs(x), slope=slope), ORIGIN, SPACING)
    assert got["top_area_mm2"] == pytest.approx(270.0 * seen, abs=12.0)  # the ridge, 0.5 mm wide


def test_taper_is_averaged_over_the_three_sections():
    x, y, z = grid()
    lean = np.hypot(1.0, 0.05)
    field = halfspaces((abs(x) - 9.0 + 0.05 * z) / lean, abs(y) - 7.5, z - 12.0)
    got = measure(field, ORIGIN, SPACING)
    expected = [18.0 - 0.1 * height for height in (0.75, 6.0, 11.25)]
    assert got["length_sections_mm"] == pytest.approx(expected, abs=5e-3)
    assert got["length_mm"] == pytest.approx(np.mean(expected), abs=5e-3)
    assert got["width_mm"] == pytest.approx(15.0, abs=1e-3)
    assert got["bottom_area_mm2"] == pytest.approx(270.0, rel=1e-3)
    assert got["bottom_difference_percent"] == pytest.approx(
        100.0 * (18.0 / np.mean(expected) - 1.0), abs=0.2
    )


def test_cylinder():
    """Section of a disc: area pi r2; mean chord over the central part c of the diameter."""
    x, y, z = grid()
    radius, core = 7.3, 0.7
    field = halfspaces(np.hypot(x, y) - radius, z - 10.0)
    got = measure(field, ORIGIN, SPACING)
    mean = radius * (np.arcsin(core) / core + np.sqrt(1.0 - core**2))
    assert got["bottom_area_mm2"] == pytest.approx(np.pi * radius**2, rel=1e-3)
    assert got["length_mm"] == pytest.approx(mean, abs=0.01)
    assert got["width_mm"] == pytest.approx(mean, abs=0.01)
    assert got["volume_real_mm3"] == pytest.approx(10.0 * np.pi * radius**2, rel=2e-3)


def test_a_cylinder_is_idealised_as_one():
    x, y, z = grid()
    field = halfspaces(np.hypot(x, y) - 7.3, z - 10.04)
    got = measure(field, ORIGIN, SPACING, shape="cylinder")
    assert got["shape"] == got["proposed_shape"] == "cylinder"
    assert got["diameter_mm"] == pytest.approx(14.6, rel=5e-4)
    assert got["length_mm"] == got["width_mm"] == got["diameter_mm"]
    assert got["height_mm"] == pytest.approx(10.04, abs=1e-3)
    assert got["ideal_area_mm2"] == pytest.approx(np.pi * 7.3**2, rel=1e-3)
    assert got["bottom_difference_percent"] == pytest.approx(0.0, abs=0.05)
    assert got["volume_ideal_mm3"] == pytest.approx(10.04 * np.pi * 7.3**2, rel=1e-3)
    assert "length_sections_mm" not in got


def test_diameter_is_that_of_the_mean_area_and_height_the_mean_of_the_core():
    """A taper, and a top that falls off by r2 / 200 mm: half of the core's rim in the mean."""
    x, y, z = grid()
    radius = np.hypot(x, y)
    field = halfspaces((radius - 8.0 + 0.05 * z) / np.hypot(1.0, 0.05), z - 10.0 + radius**2 / 200)
    got = measure(field, ORIGIN, SPACING, shape="cylinder")
    height = got["height_mm"]
    assert height == pytest.approx(10.0 - (0.35 * got["diameter_mm"]) ** 2 / 400.0, abs=2e-3)
    radii = np.array([8.0 - 0.05 * at for at in (0.75, 0.5 * height, height - 0.75)])
    assert got["diameter_sections_mm"] == pytest.approx(2.0 * radii, rel=2e-3)
    assert got["diameter_mm"] == pytest.approx(2.0 * np.sqrt(np.mean(radii**2)), rel=2e-3)
    assert got["bottom_area_mm2"] == pytest.approx(64.0 * np.pi, rel=2e-3)


def rounded(length, width, radius):
    """Cuboid of 12 mm with vertical edges of a radius, or a disc if it is half of both sides."""
    x, y, z = grid()
    beyond = [abs(x) - length / 2.0 + radius, abs(y) - width / 2.0 + radius]
    wall = np.hypot(*np.maximum(beyond, 0.0)) + np.minimum(np.max(beyond, axis=0), 0.0) - radius
    return halfspaces(wall, z - 12.0)


@pytest.mark.parametrize(("length", "width"), [(15.0, 15.0), (18.0, 12.0), (9.0, 9.0)])
@pytest.mark.parametrize("share", [0.05, 0.2, 1.0 / 3.0])
def test_rounded_edges_make_no_cuboid_round(length, width, share):
    """A corner of radius r leaves (1 - pi/4) r2 of its rectangle empty."""
    found = circularity(rounded(length, width, share * width), ORIGIN, SPACING)
    empty = 4.0 * share**2 * width**2 / (length * width)  # over that of an ellipse
    assert found == pytest.approx(empty * width / length, abs=0.02)
    assert proposed_shape(found) == "cuboid"


def test_a_cuboid_that_is_turned_is_not_round():
    x, y, z = grid()
    for angle in np.radians([8.0, 30.0, 45.0]):  # at 8 degrees an upright rectangle is as empty
        u, v = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
        found = circularity(halfspaces(abs(u) - 6.0, abs(v) - 6.0, z - 12.0), ORIGIN, SPACING)
        assert found < 0.1


@pytest.mark.parametrize("ratio", [1.0, 1.05, 1.1])
def test_discs_and_ellipses_are_round(ratio):
    x, y, z = grid()
    field = halfspaces(7.0 * (np.hypot(x / ratio, y) / 7.0 - 1.0), z - 12.0)
    found = circularity(field, ORIGIN, SPACING)
    assert found == pytest.approx(1.0 / ratio, abs=5e-3)
    assert proposed_shape(found) == "cylinder"


@pytest.mark.parametrize(("draw", "round_"), [(random_cuboid, False), (random_cylinder, True)])
def test_uneven_samples_are_told_apart(draw, round_):
    found = []
    for seed in range(12):
        shape = draw(seed)
        axes = [np.arange(-h, h, 0.5) for h in shape.box[:2]] + [np.arange(-1.0, shape.box[2], 0.5)]
        value = 1e-3 * shape.value(*np.meshgrid(*axes, indexing="ij"))
        origin = 1e-3 * np.array([axis[0] for axis in axes])
        found.append(circularity(value, origin, 0.5e-3))
    assert all((value > ROUND) == round_ for value in found)
    assert abs(np.array(found) - ROUND).min() > 0.08


def test_area_of_a_section_with_a_hole():
    x, y = np.meshgrid(np.arange(60) - 29.3, np.arange(60) - 30.2, indexing="ij")
    ring = np.abs(np.hypot(x, y) - 15.0) - 5.0
    assert section_area(ring, 2.0) == pytest.approx(4.0 * np.pi * (20.0**2 - 10.0**2), rel=2e-3)


def test_rounded_vertical_edges_do_not_shorten_the_mean_width():
    x, y = np.meshgrid(*(np.arange(80.0) - 39.5,) * 2, indexing="ij")
    corner = np.hypot(np.clip(abs(x) - 25.0, 0.0, None), np.clip(abs(y) - 20.0, 0.0, None)) - 5.0
    rounded = np.where(corner > -5.0, corner, np.maximum(abs(x) - 30.0, abs(y) - 25.0))
    assert mean_width(rounded, 1.0, 0.7) == pytest.approx(60.0, abs=1e-9)
    assert mean_width(rounded, 1.0, 1.0) < 59.7


def test_a_grid_that_is_none_is_refused():
    with pytest.raises(InputError, match="are not a grid"):
        measure(box()[0], ORIGIN, SPACING)
    with pytest.raises(InputError, match="negative inside"):
        measure(np.full(SHAPE, np.nan), ORIGIN, SPACING)
    with pytest.raises(InputError, match="no grid layer at z = 0"):
        measure(box(), ORIGIN + np.array([0.0, 0.0, 0.1e-3]), SPACING)


def test_a_flat_or_cut_sample_is_refused():
    with pytest.raises(SegmentationError, match=r"is 1\.2 mm high"):
        measure(box(top=lambda x, y: 1.2 + 0.0 * x), ORIGIN, SPACING)
    with pytest.raises(SegmentationError, match="cut by its grid at the top"):
        measure(box(top=lambda x, y: 99.0 + 0.0 * x), ORIGIN, SPACING)
    with pytest.raises(SegmentationError, match="cut by its grid"):
        measure(box(length=40.0), ORIGIN, SPACING)
