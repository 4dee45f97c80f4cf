"""Regions of a label image on the elements, and their stiffness."""

import numpy as np
import pytest

from softsample.errors import InputError
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.marks import MarkedImage
from softsample.meshing.regions import element_regions, relative_stiffness

VOXELS_TO_MM = np.array([[0, 0, 2.0, -9.0], [2.0, 0, 0, -9.0], [0, 2.0, 0, -1.0], [0, 0, 0, 1]])
"""Voxel (i, j, k) is at x = 2 k - 9, y = 2 i - 9, z = 2 j - 1 mm, so that z = 0 is between two."""


@pytest.fixture(scope="module")
def mesh():
    return mesh_cuboid(12e-3, 10e-3, 8e-3, 1e-3)


def layered(lower, upper):
    """Layers of 4 mm: `lower` on the base, `upper` on it, 0 below the base."""
    values = np.zeros((10, 10, 10), dtype=np.float32)
    values[:, 1:3], values[:, 3:] = lower, upper
    return MarkedImage.in_world(values, VOXELS_TO_MM, np.eye(4), "labels.nii")


def test_elements_have_the_label_at_their_middle(mesh):
    regions = element_regions(mesh, layered(3, 7))
    height = mesh.points[mesh.hexes, 2].mean(axis=1)
    np.testing.assert_array_equal(regions, np.where(height < 4e-3, 3, 7))


def test_labels_beside_the_sample_are_refused(mesh):
    with pytest.raises(InputError, match=r"labels\.nii: labels no element.*world frame"):
        element_regions(mesh, layered(0, 0))


def test_stiffness_follows_the_labels_and_is_one_without():
    regions = np.array([0, 2, 2, 5, 0])
    np.testing.assert_array_equal(
        relative_stiffness(regions, {2: 0.5, "5": 3, 9: 4.0}), [1.0, 0.5, 0.5, 3.0, 1.0]
    )
    np.testing.assert_array_equal(
        relative_stiffness(regions, {0: 2.0, 2: 0.5, 5: 3.0}), [2.0, 0.5, 0.5, 3.0, 2.0]
    )


def test_label_without_a_stiffness_is_refused_with_its_cure():
    with pytest.raises(
        InputError, match=r"labels 5, 8 have no stiffness \(known are 0, 2\); .*\{5: 1\.0\}\}"
    ):
        relative_stiffness(np.array([0, 2, 8, 5]), {2: 0.5})


def test_stiffness_has_to_be_positive():
    with pytest.raises(InputError, match="region_stiffness of label 2 is -1"):
        relative_stiffness(np.array([0, 2]), {2: -1.0})
