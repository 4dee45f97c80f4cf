"""The idealised sample: exact volume, divisions as the paper's, flat faces, refusals."""

import numpy as np
import pytest

from softsample.errors import MeshError
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.quality import check_topology, element_volumes, scaled_jacobian
from softsample.meshing.sample import mesh_ideal
from softsample.shapes import IdealShape


def test_divisions_round_half_up_and_volume_is_exact():
    mesh = mesh_cuboid(0.0051, 0.0040, 0.00325, 0.5e-3)  # 10.2, 8, 6.5 elements
    assert len(mesh.hexes) == 10 * 8 * 7
    assert element_volumes(mesh).sum() == pytest.approx(0.0051 * 0.0040 * 0.00325, rel=1e-12)
    assert scaled_jacobian(mesh).min() == pytest.approx(1.0, abs=1e-12)
    check_topology(mesh)


def test_box_stands_on_the_origin_with_length_along_x():
    points = mesh_cuboid(0.006, 0.004, 0.002, 0.5e-3).points
    np.testing.assert_allclose(points.min(axis=0), [-0.003, -0.002, 0.0], atol=1e-18)
    np.testing.assert_allclose(points.max(axis=0), [0.003, 0.002, 0.002], atol=1e-18)


def test_flags_are_the_bottom_and_the_top_face():
    made = mesh_ideal(IdealShape("cuboid", 0.003, 0.002, 0.001), 0.5e-3)
    height = made.mesh.points[:, 2]
    np.testing.assert_array_equal(made.point_data["bottom"], height == 0.0)
    np.testing.assert_array_equal(made.point_data["glued"], height == 0.001)
    assert made.report["volume_difference_percent"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("edges", [(0.0, 1e-3, 1e-3), (1e-3, -1e-3, 1e-3), (1e-3, 1e-3, np.nan)])
def test_edges_must_be_positive(edges):
    with pytest.raises(MeshError, match="must be positive"):
        mesh_cuboid(*edges, 0.5e-3)


def test_element_larger_than_the_cuboid_is_refused():
    with pytest.raises(MeshError, match="smaller mesh element size"):
        mesh_cuboid(5e-3, 5e-3, 0.9e-3, 2e-3)
