"""The idealised round sample: exact volume, nodes on one circle, element shape, refusals."""

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
from softsample.meshing.sample import mesh_ideal
from softsample.shapes import IdealShape

DIAMETER, HEIGHT = 20e-3, 12e-3
SIZES = (5e-3, 2e-3, 1e-3, 0.5e-3)


def on_the_wall(mesh):
    """Nodes of faces that do not lie in an end of the cylinder, by the faces alone."""
    height = mesh.points[mesh.boundary_quads][..., 2]
    return np.unique(mesh.boundary_quads[np.ptp(height, axis=1) > 0.0])


def sides_of(mesh):
    """Corners of the polygon that a section is."""
    return len(on_the_wall(mesh)) // len(np.unique(mesh.points[:, 2]))


@pytest.mark.parametrize("size", SIZES)
def test_wall_nodes_are_on_one_circle_and_elements_well_shaped(size):
    mesh = mesh_cylinder(DIAMETER, HEIGHT, size)
    check_topology(mesh)
    assert scaled_jacobian(mesh).min() > 0.75
    radius = np.linalg.norm(mesh.points[:, :2], axis=1)
    np.testing.assert_allclose(radius[on_the_wall(mesh)], radius.max(), rtol=1e-14)
    sides = sides_of(mesh)
    beyond = 2.0 * radius.max() / DIAMETER - 1.0
    assert beyond == pytest.approx(np.pi**2 / (3.0 * sides**2), rel=0.05)


@pytest.mark.parametrize("size", SIZES[1:])
def test_elements_have_the_wanted_size(size):
    edges = edge_lengths(mesh_cylinder(DIAMETER, HEIGHT, size)) / size
    assert 0.65 < edges.min() < edges.max() < 1.35


@pytest.mark.parametrize("size", SIZES)
def test_volume_and_sections_are_those_of_the_cylinder(size):
    mesh = mesh_cylinder(DIAMETER, HEIGHT, size)
    volume = element_volumes(mesh).sum()
    assert volume == pytest.approx(np.pi / 4 * DIAMETER**2 * HEIGHT, rel=1e-12)


def test_the_polygon_comes_to_the_circle_with_rate_two():
    coarse, fine = (
        2.0 * np.linalg.norm(mesh_cylinder(DIAMETER, HEIGHT, size).points[:, :2], axis=1).max()
        for size in (1e-3, 0.25e-3)
    )
    assert DIAMETER < fine < coarse
    assert (coarse - DIAMETER) / (fine - DIAMETER) == pytest.approx(16.0, rel=0.15)  # rounded parts


def test_the_mesh_of_the_shape_reports_its_volume_whatever_the_elements():
    made = mesh_ideal(IdealShape("cylinder", DIAMETER, DIAMETER, HEIGHT), 5e-3)
    assert made.report["volume_difference_percent"] == pytest.approx(0.0, abs=1e-9)
    assert made.report["element_size_mm"] == pytest.approx(5.0)
    height = made.mesh.points[:, 2]
    np.testing.assert_array_equal(made.point_data["bottom"], height == 0.0)
    np.testing.assert_array_equal(made.point_data["glued"], height == HEIGHT)


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
