"""The mesh objective against its formula written plainly, and its gradient against differences."""

import numpy as np
import pytest

from softsample.meshing.mesh import CORNERS
from softsample.meshing.optimise import Problem, Stage, optimise, shape_energy

CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
    dtype=np.float64,
)
PAIR = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])


def two_cubes(seed, noise):
    points = np.concatenate([CUBE, CUBE[4:] + np.eye(3)[2]])
    return points + noise * np.random.default_rng(seed).normal(size=points.shape)


def plain_energy(points, hexes, volume_weight, barrier):
    """The formula of the docstring, one corner at a time, with determinants from LAPACK."""
    total = 0.0
    for element in hexes:
        for corner, *others in CORNERS:
            edges = points[element[others]] - points[element[corner]]
            det = np.linalg.det(edges)
            size = 0.5 * (det + np.hypot(det, barrier))
            total += (np.sum(edges**2) / 3.0) ** 3 / size**2 - 1.0
            total += volume_weight * (0.5 * (size + 1.0 / size) - 1.0)
    return total / 8.0


def bowl(points):
    """A level set with a curved gradient."""
    return points[:, 2] - 0.3 * points[:, 0] ** 2, np.column_stack(
        [-0.6 * points[:, 0], np.zeros(len(points)), np.ones(len(points))]
    )


def problem(free=None):
    return Problem(
        hexes=PAIR,
        free=np.ones((12, 3), dtype=bool) if free is None else free,
        surface=np.array([8, 9, 10, 11]),
        faces=np.array([[8, 9, 10, 11], [4, 5, 9, 8]]),
        distance=bowl,
        pins=np.array([9]),
        targets=np.array([[1.2, 0.1, 2.2]]),
        volume_weight=0.5,
    )


@pytest.mark.parametrize(("noise", "barrier"), [(0.1, 1e-3), (0.6, 0.3)])
def test_energy_is_its_formula_also_for_inverted_elements(noise, barrier):
    points = two_cubes(1, noise)
    energy = shape_energy(points, PAIR, CORNERS, 0.5, barrier, np.zeros_like(points))
    assert energy == pytest.approx(plain_energy(points, PAIR, 0.5, barrier), rel=1e-9)


def test_cube_has_no_energy():
    assert shape_energy(CUBE, PAIR[:1], CORNERS, 0.5, 0.0, np.zeros((8, 3))) == pytest.approx(0.0)


@pytest.mark.parametrize(("noise", "barrier"), [(0.1, 1e-3), (0.4, 0.3)])
def test_gradient_is_the_difference_quotient(noise, barrier):
    points, stage = two_cubes(2, noise), Stage(7.0, barrier, 0)
    _, gradient = problem().energy(points, stage)
    slope = np.empty_like(gradient)
    for index in np.ndindex(points.shape):
        step = np.zeros_like(points)
        step[index] = 1e-6
        upper, lower = (problem().energy(points + s * step, stage)[0] for s in (1.0, -1.0))
        slope[index] = (upper - lower) / 2e-6
    np.testing.assert_allclose(gradient, slope, rtol=1e-5, atol=1e-6 * np.abs(slope).max())


def test_fixed_coordinates_stay_and_the_rest_untangles():
    points = two_cubes(3, 0.0)
    points[6] = [0.2, 0.2, 0.5]  # pushed through the middle of both cubes
    free = np.ones((12, 3), dtype=bool)
    free[:4] = False
    moved = points
    for barrier in (0.3, 1e-3):
        moved = optimise(problem(free), moved, Stage(0.0, barrier, 100))
    np.testing.assert_array_equal(moved[:4], points[:4])
    np.testing.assert_allclose(moved, two_cubes(3, 0.0), atol=1e-3)  # two cubes again
