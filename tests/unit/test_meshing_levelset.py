"""The smooth signed distance against SciPy's spline and against solids with a formula."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from softsample.errors import MeshError
from softsample.meshing.levelset import LevelSet

SPACING = 0.25e-3  # m
RADIUS, HEIGHT = 2.0e-3, 4.0e-3  # m, a cylinder that ends in a half sphere


def dome(points):
    """Exact distance [m] to a cylinder with a spherical top, walls endless downwards."""
    x, y, z = np.moveaxis(points, -1, 0)
    rise = np.maximum(z - (HEIGHT - RADIUS), 0.0)
    return np.sqrt(x**2 + y**2 + rise**2) - RADIUS


@pytest.fixture(scope="module")
def surface():
    axes = [np.arange(-3.5e-3, 3.6e-3, SPACING)] * 2 + [np.arange(-2e-3, 6.1e-3, SPACING)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return LevelSet(dome(grid), grid[0, 0, 0], SPACING)


def test_value_is_the_cubic_spline_of_scipy():
    values = np.random.default_rng(1).normal(size=(7, 6, 5))
    places = np.random.default_rng(2).uniform(0.0, [6.0, 5.0, 4.0], (40, 3))
    surface = LevelSet(values, np.array([1.0, 2.0, 3.0]), 0.5)
    expected = map_coordinates(values, places.T, order=3, mode="mirror")
    np.testing.assert_allclose(surface([1.0, 2.0, 3.0] + 0.5 * places), expected, atol=1e-12)


def test_gradient_is_the_difference_quotient():
    values = np.random.default_rng(3).normal(size=(6, 6, 6))
    surface = LevelSet(values, np.zeros(3), 0.5)
    points = np.random.default_rng(4).uniform(0.1, 2.4, (20, 3))
    _, gradient = surface.with_gradient(points)
    for axis in range(3):
        step = 1e-6 * np.eye(3)[axis]
        slope = (surface(points + step) - surface(points - step)) / 2e-6
        np.testing.assert_allclose(gradient[:, axis], slope, atol=1e-7)


def test_points_land_on_the_surface_and_rim_points_stay_in_the_base_plane(surface):
    points = np.random.default_rng(5).normal(size=(50, 3))
    points *= 2.2e-3 / np.linalg.norm(points, axis=1)[:, None]
    points[:, 2] += 1e-3
    in_plane = np.arange(50) < 10
    points[in_plane, 2] = 0.0
    landed = surface.project(points, in_plane)
    assert np.abs(dome(landed)).max() < 2e-6  # m, what the spline leaves at the dome's foot
    assert np.all(landed[in_plane, 2] == 0.0)


@pytest.mark.parametrize("width", [5.0e-3, 5.1e-3])
def test_volume_of_a_block_is_exact_wherever_its_walls_lie_on_the_grid(width):
    axes = [np.arange(-7e-3, 7.01e-3, SPACING)] * 2 + [np.arange(-2e-3, 7.01e-3, SPACING)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    block = np.maximum.reduce(
        [np.abs(grid[..., 0]) - width, np.abs(grid[..., 1]) - 4e-3, grid[..., 2] - 5e-3]
    )
    exact = 2.0 * width * 8e-3 * 5e-3
    assert LevelSet(block, grid[0, 0, 0], SPACING).volume == pytest.approx(exact, rel=1e-3)


def test_volume_is_that_of_cylinder_and_half_sphere(surface):
    exact = np.pi * RADIUS**2 * (HEIGHT - RADIUS) + 2.0 / 3.0 * np.pi * RADIUS**3
    assert surface.volume == pytest.approx(exact, rel=1e-3)  # midpoint rule, 0.125 mm


def test_highest_point_is_the_pole(surface):
    x, y, z = surface.highest_point
    assert np.hypot(x, y) < 5e-5
    assert z == pytest.approx(HEIGHT, abs=1e-6)


def grid_with(change):
    distance = np.full((12, 12, 12), 1e-3)
    distance[4:8, 4:8, :8] = -1e-3
    return change(distance)


def no_number(distance):
    distance[0, 0, 0] = np.nan
    return distance


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (no_number, "1 values that are no numbers"),
        (np.abs, "nowhere negative"),
        (lambda d: -d, "touches the border"),
        (lambda d: d[0], "three-dimensional"),
    ],
)
def test_unusable_grid_is_refused_with_its_reason(change, message):
    with pytest.raises(MeshError, match=message):
        _ = LevelSet(grid_with(change), np.zeros(3), SPACING).inside_box
