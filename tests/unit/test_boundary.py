"""What is held, what may touch, where the platens are."""

import numpy as np
import pytest

from softsample.errors import InputError
from softsample.fem.boundary import (
    ContactSettings,
    glued_boundary,
    mode_boundary,
    platen_boundary,
)
from softsample.fem.motion import BASE, FREE, PLATEN
from softsample.fem.setup import set_up
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh

EVERYTHING = ContactSettings()
THEIRS = ContactSettings(release=False, side_walls=False, base_platen=False)


@pytest.fixture(scope="module")
def cuboid():
    return mesh_cuboid(4e-3, 3e-3, 3e-3, 1e-3)


@pytest.mark.parametrize(
    ("mode", "direction"),
    [("tension", [0, 0, 1]), ("shear", [1, 0, 0]), ("compression", [0, 0, -1])],
)
def test_glued_top_and_base_are_held(cuboid, mode, direction):
    boundary = glued_boundary(cuboid, mode, cuboid.glued(0.0))
    height = cuboid.points[:, 2]
    np.testing.assert_array_equal(boundary.held == BASE, height == 0.0)
    np.testing.assert_array_equal(boundary.held == PLATEN, height == height.max())
    np.testing.assert_array_equal(boundary.direction, direction)
    assert len(boundary.candidates) == 0
    base, platen = boundary.platens().glued
    np.testing.assert_array_equal(base, np.flatnonzero(height == 0.0))
    np.testing.assert_array_equal(platen, np.flatnonzero(height == height.max()))


def test_glue_reaches_down_the_sides_by_its_depth(cuboid):
    boundary = glued_boundary(cuboid, "tension", cuboid.glued(1e-3))
    second = np.isclose(cuboid.points[:, 2], 2e-3)
    inside = np.all(np.abs(cuboid.points[:, :2]) < [1.9e-3, 1.4e-3], axis=1)
    assert np.all(boundary.held[second & ~inside] == PLATEN)
    assert np.all(boundary.held[second & inside] == FREE)


def test_base_keeps_what_both_want(cuboid):
    boundary = glued_boundary(cuboid, "tension", cuboid.glued(5e-3))
    assert np.all(boundary.held[cuboid.bottom] == BASE)


def test_platen_starts_at_the_highest_node(crooked):
    boundary = platen_boundary(crooked, EVERYTHING)
    np.testing.assert_array_equal(boundary.planes[1], [0, 0, 1, crooked.points[:, 2].max()])
    np.testing.assert_array_equal(boundary.planes[0], [0, 0, -1, 0])
    np.testing.assert_array_equal(boundary.direction, [0, 0, -1])
    assert set(np.unique(boundary.held)) == {FREE, BASE}
    assert boundary.release


def test_surface_nodes_off_the_base_may_touch(cuboid):
    candidates = platen_boundary(cuboid, EVERYTHING).candidates
    np.testing.assert_array_equal(candidates, np.setdiff1d(cuboid.boundary, cuboid.bottom))


def test_a_platen_inside_the_sample_and_a_bond_of_nothing_are_refused(cuboid):
    with pytest.raises(InputError, match="gap: -0.001 m would put the platen into the sample"):
        platen_boundary(cuboid, EVERYTHING, gap=-1e-3)
    with pytest.raises(InputError, match="no node of the mesh is bonded"):
        glued_boundary(cuboid, "shear", np.empty(0, dtype=np.int64))


def test_without_side_walls_only_faces_that_look_up_may_touch(cuboid):
    boundary = platen_boundary(cuboid, THEIRS)
    np.testing.assert_array_equal(boundary.candidates, cuboid.glued(0.0))
    assert boundary.planes[0, 3] == np.inf
    assert not boundary.release


@pytest.mark.parametrize(("lean", "counted"), [(0.15, False), (0.26, True)])
def test_leaning_walls_count_from_a_normal_of_0_2(cuboid, lean, counted):
    """Walls that lean inwards by `lean` per height have a normal of lean / sqrt(1 + lean^2)."""
    points = cuboid.points.copy()
    points[:, 0] -= lean * points[:, 2] * np.sign(points[:, 0]) * (np.abs(points[:, 0]) > 1.9e-3)
    mesh = HexMesh(points, cuboid.hexes)
    walls = np.abs(cuboid.points[:, 0]) > 1.9e-3
    walls &= (points[:, 2] > 0.0) & (points[:, 2] < 2.9e-3)
    touchable = np.isin(np.flatnonzero(walls), platen_boundary(mesh, THEIRS).candidates)
    assert np.all(touchable == counted)


def test_mode_decides_between_glue_and_contact(cuboid):
    glued = cuboid.glued(0.0)
    assert len(mode_boundary(cuboid, "compression", glued, EVERYTHING).candidates) > 0
    for mode in ("tension", "shear", "pure_shear"):
        boundary = mode_boundary(cuboid, mode, glued, EVERYTHING)
        assert len(boundary.candidates) == 0
        assert np.sum(boundary.held == PLATEN) == len(glued)


@pytest.mark.parametrize(("mode", "confined"), [("tension", ()), ("pure_shear", (0,))])
def test_sliding_ends_hold_along_the_axis_alone(cuboid, mode, confined):
    glued = cuboid.glued(0.0)
    boundary = mode_boundary(cuboid, mode, glued, EVERYTHING, "sliding")
    ends = np.union1d(cuboid.bottom, glued)
    np.testing.assert_array_equal(boundary.candidates, ends)
    assert np.all(boundary.held[glued] == PLATEN)
    assert np.all(boundary.held[cuboid.bottom] == BASE)
    assert boundary.friction == (0.0, 0.0)
    assert not boundary.release
    platens = boundary.platens()
    assert not any(len(nodes) for nodes in platens.glued)
    np.testing.assert_array_equal(platens.mobile, [axis not in confined for axis in range(3)])


@pytest.mark.parametrize(("ends", "friction"), [("sliding", 0.0), (0.3, 0.3), (np.float64(2), 2.0)])
def test_friction_of_the_ends_is_that_of_both_platens_unless_the_config_says_so(
    cuboid, ends, friction
):
    def of(contact):
        return mode_boundary(cuboid, "compression", cuboid.glued(0.0), contact, ends)

    assert of(EVERYTHING).friction == (friction, friction)
    assert of(ContactSettings(friction=0.1)).friction == (friction, 0.1)
    assert of(ContactSettings(base_friction=0.2)).friction == (0.2, friction)
    assert np.isin(cuboid.bottom, of(EVERYTHING).candidates).all()


@pytest.mark.parametrize("ends", ["bonded", "sliding", 0.5])
def test_a_chamber_leaves_the_axis_alone(cuboid, ends):
    boundary = mode_boundary(
        cuboid, "confined_compression", cuboid.glued(0.0), ContactSettings(friction=0.4), ends
    )
    np.testing.assert_array_equal(boundary.platens().mobile, [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(boundary.direction, [0, 0, -1])
    assert boundary.friction == (0.0, 0.0)


@pytest.mark.parametrize(
    ("mode", "ends", "message"),
    [
        ("shear", "sliding", "sliding leaves simple shear homogeneous.*closed form"),
        ("tension", 0.3, r"friction \(0.3\) holds no sample in tension; choose bonded or sliding"),
        ("shear", 0.3, "holds no sample in shear"),
        ("pure_shear", 0.0, "holds no sample in pure_shear"),
        ("compression", "unknown", "'unknown' is neither bonded, sliding nor a coefficient"),
        ("compression", -0.1, "-0.1 is neither"),
        ("compression", np.nan, "nan is neither"),
        ("compression", np.inf, "inf is neither"),
    ],
)
def test_ends_that_a_mode_cannot_have_are_refused(cuboid, mode, ends, message):
    with pytest.raises(InputError, match=message):
        mode_boundary(cuboid, mode, cuboid.glued(0.0), EVERYTHING, ends)


def test_set_up_passes_the_ends_on(cuboid):
    glued = np.isin(np.arange(len(cuboid.points)), cuboid.glued(0.0))

    sample, sections = (cuboid, {"glued": glued}, {}), {"solver": {}, "contact": {}, "material": {}}

    assert set_up(sample, "compression", sections)[1].friction == (np.inf, np.inf)
    assert set_up(sample, "compression", sections, 0.2)[1].friction == (0.2, 0.2)
