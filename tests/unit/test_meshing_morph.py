"""Moved meshes against the moved solid's formula."""

import numpy as np
import pytest

from softsample.meshing.hexahedral import mesh_solid
from softsample.meshing.levelset import LevelSet
from softsample.meshing.morph import shifted
from softsample.meshing.quality import scaled_jacobian

SPACING, RADIUS, HEIGHT = 0.4e-3, 5e-3, 8e-3  # m


@pytest.fixture(scope="module")
def case():
    """A cylinder with a spherical top, its mesh and a shift that grows with height."""
    axes = [np.arange(-7.2e-3, 7.3e-3, SPACING)] * 2 + [np.arange(-2e-3, 10.1e-3, SPACING)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    rise = np.maximum(z - (HEIGHT - RADIUS), 0.0)
    origin = np.array([a[0] for a in axes])
    distance = np.sqrt(x**2 + y**2 + rise**2) - RADIUS
    surface = LevelSet(distance, origin, SPACING)
    sigma = LevelSet(0.02e-3 + 0.01 * np.clip(z, 0.0, HEIGHT), origin, SPACING)
    return mesh_solid(distance, origin, SPACING, 1e-3), surface, sigma


@pytest.mark.parametrize("times", [-1.0, 1.0, 2.0])
def test_surface_moves_by_the_wanted_length(case, times):
    mesh, surface, sigma = case
    moved = shifted(mesh, surface, sigma, times)
    base = np.isin(np.arange(len(mesh.points)), mesh.bottom)
    skin = np.setdiff1d(mesh.boundary, np.flatnonzero(base))
    way = surface(moved.points[skin]) - surface(mesh.points[skin])
    np.testing.assert_allclose(way, times * sigma(mesh.points[skin]), atol=2e-6)
    np.testing.assert_array_equal(moved.points[base, 2], mesh.points[base, 2])
    rim = (
        base
        & np.isin(np.arange(len(mesh.points)), mesh.hexes)
        & (np.hypot(*mesh.points[:, :2].T) > RADIUS - 0.1e-3)
    )
    radius = np.hypot(*moved.points[rim, :2].T) - np.hypot(*mesh.points[rim, :2].T)
    np.testing.assert_allclose(radius, times * 0.02e-3, atol=2e-6)


def test_inside_follows_smoothly(case):
    """Elements keep their shape, and no node inside moves further than the surface."""
    mesh, surface, sigma = case
    moved = shifted(mesh, surface, sigma, 1.0)
    way = np.linalg.norm(moved.points - mesh.points, axis=1)
    inside = np.setdiff1d(np.arange(len(mesh.points)), mesh.boundary)
    assert 0.0 < way[inside].max() <= way[mesh.boundary].max()
    assert np.abs(scaled_jacobian(moved) - scaled_jacobian(mesh)).max() < 0.03


def test_no_shift_moves_nothing(case):
    mesh, surface, sigma = case
    np.testing.assert_allclose(shifted(mesh, surface, sigma, 0.0).points, mesh.points, atol=1e-12)
