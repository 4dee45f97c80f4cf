"""The idealised round sample: polygon's volume, nodes on the circle, element shape, refusals."""

import numpy as np
import pytest

from softsample.errors import MeshError
from softsample.meshing.cylinder import mesh_cylinder
from softsample.meshing.quality import (
    check_topology,
    edge_lengths,
    element_volumes,
    scaled_jacobian,
)

DIAMETER, HEIGHT = 20e-3, 12e-3
SIZES = (5e-3, 2e-3, 1e-3, 0.5e-3)


def on_the_wall(mesh):
    """Nodes of faces that do not lie in an end of the cylinder, by the faces alone."""
    height = mesh.points[mesh.boundary_quads][..., 2]
    return np.unique(mesh.boundary_quads[np.ptp(height, axis=1) > 0.0])


@pytest.mark.parametrize("size", SIZES)
def test_wall_nodes_are_on_the_circle_and_elements_well_shaped(size):
    mesh = mesh_cylinder(DIAMETER, HEIGHT, size)
    check_topology(mesh)
    assert scaled_jacobian(mesh).min() > 0.75
    radius = np.linalg.norm(mesh.points[:, :2], axis=1)
    np.testing.assert_allclose(radius[on_the_wall(mesh)], DIAMETER / 2, rtol=1e-14)
    assert radius.max() <= DIAMETER / 2 * (1.0 + 1e-14)


@pytest.mark.parametrize("size", SIZES[1:])
def test_elements_have_the_wanted_size(size):
    edges = edge_lengths(mesh_cylinder(DIAMETER, HEIGHT, size)) / size
    assert 0.65 < edges.min() < edges.max() < 1.35


@pytest.mark.parametrize("size", SIZES)
def test_volume_is_that_of_the_inscribed_polygon(size):
    mesh = mesh_cylinder(DIAMETER, HEIGHT, size)
    sides = len(on_the_wall(mesh)) // len(np.unique(mesh.points[:, 2]))
    polygon = sides / 2 * (DIAMETER / 2) ** 2 * np.sin(2 * np.pi / sides)
    volume = element_volumes(mesh).sum()
    assert volume == pytest.approx(polygon * HEIGHT, rel=1e-12)
    lacking = 1.0 - volume / (np.pi / 4 * DIAMETER**2 * HEIGHT)
    assert lacking == pytest.approx(2 * np.pi**2 / (3 * sides**2), rel=0.05)


def test_volume_converges_to_the_cylinder_with_rate_two():
    exact = np.pi / 4 * DIAMETER**2 * HEIGHT
    coarse, fine = (
        1.0 - element_volumes(mesh_cylinder(DIAMETER, HEIGHT, size)).sum() / exact
        for size in (1e-3, 0.25e-3)
    )
    assert 0.0 < fine < 2e-4
    assert coarse / fine == pytest.approx(16.0, rel=0.15)  # the parts are rounded


def test_ends_are_flat_and_found_by_the_mesh():
    mesh = mesh_cylinder(DIAMETER, HEIGHT, 2e-3)
    height = mesh.points[:, 2]
    assert len(np.unique(height)) == 7
    np.testing.assert_array_equal(mesh.bottom, np.flatnonzero(height == 0.0))
    np.testing.assert_array_equal(mesh.glued(0.0), np.flatnonzero(height == HEIGHT))
    np.testing.assert_allclose(mesh.points[mesh.bottom].mean(axis=0), 0.0, atol=1e-17)


@pytest.mark.parametrize("lengths", [(0.0, 1e-2, 1e-3), (1e-2, np.inf, 1e-3), (1e-2, 1e-2, -1.0)])
def test_lengths_must_be_positive(lengths):
    with pytest.raises(MeshError, match=r"must be positive.*check the measured cylinder"):
        mesh_cylinder(*lengths)


@pytest.mark.parametrize(("diameter", "height"), [(2e-3, 1e-2), (1e-2, 0.4e-3)])
def test_cylinder_too_small_for_the_elements_is_refused(diameter, height):
    with pytest.raises(MeshError, match="smaller mesh element size"):
        mesh_cylinder(diameter, height, 1e-3)
