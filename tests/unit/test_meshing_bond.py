"""Part of the top that is glued: masks in another frame, peeling by area, refusals."""

import numpy as np
import pytest

from softsample.errors import InputError, MeshError
from softsample.meshing.bond import bonded_area, bonded_nodes, partial_bond
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.cylinder import mesh_cylinder
from softsample.meshing.marks import MarkedImage
from softsample.meshing.mesh import HexMesh

LENGTH, WIDTH, HEIGHT = 12e-3, 10e-3, 8e-3
WORLD = np.array([[0, -1, 0, 5.0], [1, 0, 0, -3.0], [0, 0, 1, 2.0], [0, 0, 0, 1]])
"""Sample frame to world [mm]: turned by 90 degrees, so that sample x is world y, and moved."""


@pytest.fixture(scope="module")
def cuboid():
    return mesh_cuboid(LENGTH, WIDTH, HEIGHT, 1e-3)


def painted(where, voxel=(0.5, 0.4, 0.3), flip=False):
    """Image around the sample whose voxels have the value `where(x, y, z)` of world mm."""
    shape = np.array([40, 50, 60])
    affine = np.diag([*voxel, 1.0])
    affine[:3, 3] = [-5.0, -13.0, -3.0]
    if flip:
        affine[0, 0], affine[0, 3] = -voxel[0], -5.0 + voxel[0] * (shape[0] - 1)
    places = (
        np.einsum("ij,jxyz->ixyz", affine[:3, :3], np.indices(shape))
        + affine[:3, 3, None, None, None]
    )
    values = np.asarray(where(*places), dtype=np.float32)
    return MarkedImage.in_world(values, affine, WORLD, "mask.nii.gz")


@pytest.mark.parametrize("flip", [False, True])
def test_mask_in_the_world_marks_the_nodes_of_the_sample(cuboid, flip):
    """World y > 0.5 is sample x > 3.5, whichever way the image is stored."""
    glued = bonded_nodes(cuboid, painted(lambda x, y, z: y > 0.5, flip=flip))
    x, _, z = cuboid.points.T
    np.testing.assert_array_equal(glued, np.flatnonzero((z == HEIGHT) & (x > 3.5e-3)))


def test_only_the_top_can_be_glued_by_a_mask(cuboid):
    """A mask of everything leaves base and walls alone, also walls that look up a little."""
    everything = painted(lambda x, y, z: np.ones_like(x))
    np.testing.assert_array_equal(bonded_nodes(cuboid, everything), cuboid.glued(0.0))
    leaning = cuboid.points.copy()
    leaning[:, :2] *= 1.0 - 20.0 * leaning[:, 2:]
    bent = HexMesh(leaning, cuboid.hexes)
    np.testing.assert_array_equal(bonded_nodes(bent, everything), cuboid.glued(0.0))


def test_a_low_ledge_is_no_top(cuboid):
    middle = cuboid.points[cuboid.hexes].mean(axis=1)
    stepped = HexMesh(cuboid.points, cuboid.hexes[(middle[:, 0] < 3e-3) | (middle[:, 2] < 2e-3)])
    glued = bonded_nodes(stepped, painted(lambda x, y, z: np.ones_like(x)))
    np.testing.assert_array_equal(glued, stepped.glued(0.0))


def test_what_lies_outside_the_image_is_not_glued(cuboid):
    """Three voxels of 2 mm in x and y, the first about the origin."""
    small = MarkedImage(np.ones((3, 3, 3), dtype=int), np.diag([500.0, 500.0, 125.0, 1.0]))
    glued = bonded_nodes(cuboid, small)
    near = np.all((cuboid.points[:, :2] > -1.5e-3) & (cuboid.points[:, :2] < 5.5e-3), axis=1)
    np.testing.assert_array_equal(glued, np.intersect1d(np.flatnonzero(near), cuboid.glued(0.0)))


def test_mask_that_marks_no_top_node_is_refused(cuboid):
    with pytest.raises(
        InputError, match=r"mask\.nii\.gz: marks no node of the top surface \(143 nodes 8\.0 to 8"
    ):
        bonded_nodes(cuboid, painted(lambda x, y, z: z < 6.0))


def test_intensities_and_broken_affines_are_refused():
    values = np.zeros((4, 4, 4), dtype=np.float32)
    values[1, 2, 3] = 0.5
    with pytest.raises(InputError, match=r"m\.nii: 1 voxels hold no whole number.*such as 0\.5"):
        MarkedImage.in_world(values, np.eye(4), WORLD, "m.nii")
    with pytest.raises(InputError, match=r"m\.nii: the affine is singular"):
        MarkedImage.in_world(np.zeros((4, 4, 4)), np.diag([1.0, 1.0, 0.0, 1.0]), WORLD, "m.nii")


def test_bonded_area_is_that_of_the_top(cuboid):
    assert bonded_area(cuboid, cuboid.glued(0.0)).sum() == pytest.approx(LENGTH * WIDTH)
    assert bonded_area(cuboid, cuboid.bottom).sum() == 0.0  # looks down
    with_walls = bonded_area(cuboid, cuboid.glued(2e-3))
    assert with_walls.sum() == pytest.approx(LENGTH * WIDTH)


@pytest.mark.parametrize("fraction", [1.0, 0.75, 0.5, 0.1])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -2.0), (1.0, 1.0)])
def test_peeling_leaves_the_fraction_of_the_area_beyond_a_line(fraction, direction):
    mesh = mesh_cylinder(20e-3, 10e-3, 1e-3)
    top = mesh.glued(0.0)
    glued = partial_bond(mesh, top, fraction, direction)
    area = bonded_area(mesh, top)
    assert area[np.isin(top, glued)].sum() / area.sum() == pytest.approx(fraction, abs=0.03)
    place = mesh.points[:, :2] @ np.array(direction)
    gone = np.setdiff1d(top, glued)
    assert len(gone) == 0 or place[gone].max() < place[glued].min()
    assert set(glued) <= set(top)


def test_half_of_a_cuboid_is_peeled_row_by_row(cuboid):
    glued = partial_bond(cuboid, cuboid.glued(0.0), 0.5, (1.0, 0.0))
    rows, count = np.unique(np.rint(cuboid.points[glued, 0] * 1e3), return_counts=True)
    assert set(count) == {11}
    assert rows.max() == 6.0
    assert rows.min() in (0.0, 1.0)  # 6.5 of 12 or 5.5 of 12 rows of area are as near


@pytest.mark.parametrize(
    ("fraction", "direction", "message"),
    [
        (0.0, (1, 0), "bonded fraction is 0.0: give a number above 0"),
        (1.2, (1, 0), "bonded fraction is 1.2"),
        (0.5, (0, 0), "direction of peeling is .*not both 0"),
        (0.5, (0, 0, 1), "direction of peeling is"),
    ],
)
def test_peeling_by_nothing_is_refused(cuboid, fraction, direction, message):
    with pytest.raises(MeshError, match=message):
        partial_bond(cuboid, cuboid.glued(0.0), fraction, direction)


def test_peeling_of_what_is_no_top_is_refused(cuboid):
    with pytest.raises(MeshError, match="hold no upward face"):
        partial_bond(cuboid, cuboid.bottom, 0.5, (1, 0))
