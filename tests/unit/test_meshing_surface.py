"""Meshes of STL files: volume, distance and element shape, walls below the base, refusals."""

import os
from functools import cache

import numpy as np
import pytest
import pyvista

from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import MeshError
from softsample.fem.boundary import ContactSettings, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.imaging.measure import measure
from softsample.imaging.settings import SegmentationSettings
from softsample.imaging.surface import segmentation_from_surface
from softsample.io import read_surface, write_surface
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.hexahedral import mesh_solid
from softsample.meshing.quality import element_volumes, scaled_jacobian, surface_samples
from softsample.meshing.sample import mesh_ideal, mesh_real
from softsample.meshing.surface import (
    TriangleSurface,
    base_centre,
    boundary_surface,
    distance_grid,
    level_surface,
)
from softsample.shapes import IdealShape, element_size

MM = 1e-3
PLACE = (3.0, -2.0, 11.0)  # of the base's middle in the file, mm

needs_jit = pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="minutes in plain Python"
)


def cylinder(radius=7.0, height=9.0, sides=160):
    solid = pyvista.Cylinder(
        center=(0, 0, height / 2),
        direction=(0, 0, 1),
        radius=radius,
        height=height,
        resolution=sides,
    )
    return solid.triangulate().clean()


def moved(solid, change):
    bent = solid.copy()
    bent.points = np.column_stack(change(*solid.points.T)).astype(np.float32)
    return bent


def frustum():
    """Narrower to the top and leaning by 0.3, so that one wall is undercut."""
    return moved(cylinder(), lambda x, y, z: (x * (1 - 0.03 * z) + 0.3 * z, y * (1 - 0.03 * z), z))


def block():
    """Cuboid of 14 x 12 whose top is a paraboloid from 10 down to 8.7 at the corners."""
    box = pyvista.Box(bounds=(-7, 7, -6, 6, 0, 10), level=23).triangulate().clean()
    return moved(box, lambda x, y, z: (x, y, z * (1.0 - 0.0015 * (x**2 + y**2))))


SHAPES = {"cylinder": cylinder, "frustum": frustum, "block": block}


@cache
def shape(name):
    return SHAPES[name]().compute_normals(auto_orient_normals=True, split_vertices=False)


def saved(solid, folder):
    path = folder / "sample.stl"
    solid.translate(PLACE, inplace=False).save(path)
    return path


@needs_jit
@pytest.mark.parametrize("name", SHAPES)
def test_mesh_of_an_stl_has_its_volume_and_surface(name, tmp_path):
    mesh = mesh_solid(*distance_grid(read_surface(saved(shape(name), tmp_path)), 0.25 * MM), 5e-4)
    assert scaled_jacobian(mesh).min() > 0.2
    assert element_volumes(mesh).sum() / MM**3 == pytest.approx(shape(name).volume, rel=5e-3)
    points, area = surface_samples(mesh)
    away = np.abs(
        pyvista.PolyData(points / MM).compute_implicit_distance(shape(name))["implicit_distance"]
    )
    assert area @ away / area.sum() < 0.004  # mm
    base = mesh.points[mesh.bottom]
    assert np.all(base[:, 2] == 0.0)
    np.testing.assert_allclose(base.mean(axis=0), 0.0, atol=0.05 * MM)


@needs_jit
@pytest.mark.parametrize("size", [1.0, 0.5])
def test_sharp_edges_stay_so_that_a_platen_meets_the_whole_top(size, tmp_path):
    """A chamfer of half an element would take 8 % of the contact from a block of 16 x 12 mm."""
    path = saved_block(tmp_path, ".stl")
    found = segmentation_from_surface(read_surface(path))
    mesh = mesh_solid(found.distance, found.origin, found.spacing, size * MM)
    quads = mesh.points[mesh.boundary_quads]
    top = quads[(quads[:, :, 2] > 8.9 * MM).all(axis=1)]
    across = np.cross(top[:, 2] - top[:, 0], top[:, 3] - top[:, 1])
    assert 0.5 * across[:, 2].sum() / MM**2 == pytest.approx(16.0 * 12.0, rel=0.02)
    assert mesh.highest / MM == pytest.approx(9.0, abs=2e-3)
    assert scaled_jacobian(mesh).min() > 0.4


@needs_jit
def test_a_block_given_as_surface_resists_a_platen_as_the_ideal_block_does(tmp_path):
    found = segmentation_from_surface(read_surface(saved_block(tmp_path, ".stl")))
    meshes = (
        mesh_solid(found.distance, found.origin, found.spacing, MM),
        mesh_cuboid(16 * MM, 12 * MM, 9 * MM, MM),
    )
    material = OgdenMaterial((1200.0, 100.0), (-8.0, 16.0), 0.49)
    real, ideal = (
        ExplicitModel(mesh, SolverSettings()).run(
            material, platen_boundary(mesh, ContactSettings()), 0.9 * MM
        )
        for mesh in meshes
    )
    late = real.displacement > 0.6 * MM  # tops are 0.01 mm uneven; chamfers would take 8 %
    np.testing.assert_allclose(real.force[late], ideal.force[late], rtol=0.02)


def saved_block(folder, ending):
    """A block of 16 x 12 x 9 mm turned by 20 degrees about z, its base off the origin."""
    box = pyvista.Box(bounds=(-8, 8, -6, 6, 0, 9), level=7).triangulate().clean()
    path = folder / f"sample{ending}"
    box.rotate_z(20.0, inplace=False).translate(PLACE, inplace=False).save(path)
    return path


def saved_disc(folder, ending):
    solid = cylinder(sides=64).compute_normals(auto_orient_normals=True, split_vertices=False)
    path = folder / f"sample{ending}"
    solid.translate(PLACE, inplace=False).save(path)
    return path


POLYGON = 32.0 * np.sin(2.0 * np.pi / 64.0)  # area of 64 sides with corners at radius 1
SOLIDS = {
    ".stl": (saved_disc, "cylinder", (POLYGON * 7.0**2, 9.0)),
    ".ply": (saved_block, "cuboid", (16.0 * 12.0, 9.0)),
    ".vtp": (saved_disc, "cylinder", (POLYGON * 7.0**2, 9.0)),
}


@needs_jit
@pytest.mark.parametrize("ending", SOLIDS)
def test_from_a_file_to_meshes_of_both_geometries(ending, tmp_path):
    save, kind, (area, height) = SOLIDS[ending]
    found = segmentation_from_surface(read_surface(save(tmp_path, ending)))
    grid = (found.distance, found.origin, found.spacing)
    report = measure(*grid, shape=kind)
    assert report["proposed_shape"] == kind
    ideal = IdealShape.of_report(report)
    assert ideal.area / MM**2 == pytest.approx(area, rel=2e-3)
    assert ideal.height / MM == pytest.approx(height, rel=1e-4)
    assert found.volume / MM**3 == pytest.approx(area * height, rel=2e-3)
    size = element_size(ideal, 0.5 * MM, (8, 40))
    for made in (mesh_real(*grid, size, MM), mesh_ideal(ideal, size)):
        assert made.report["volume_mm3"] == pytest.approx(area * height, rel=5e-3)
        assert abs(made.report["volume_difference_percent"]) < 0.5


def test_a_surface_comes_into_the_sample_frame_as_an_image_does(tmp_path):
    """+x is normal to the walls nearest to the shear axis; the frame's place is told."""
    coarse = SegmentationSettings(grid_spacing_mm=0.5)
    surface = read_surface(saved_block(tmp_path, ".ply"))
    found = segmentation_from_surface(surface, coarse)
    x = [np.cos(np.radians(20.0)), np.sin(np.radians(20.0)), 0.0]
    np.testing.assert_allclose(found.sample_to_world[:3, 0], x, atol=1e-6)
    np.testing.assert_allclose(found.sample_to_world[:3, 3] / MM, PLACE, atol=1e-5)
    got = measure(found.distance, found.origin, found.spacing)
    assert (got["length_mm"], got["width_mm"]) == pytest.approx((16.0, 12.0), abs=2e-3)
    along_y = segmentation_from_surface(surface, coarse, shear_axis=(0.0, 1.0, 0.0))
    got = measure(along_y.distance, along_y.origin, along_y.spacing)
    assert (got["length_mm"], got["width_mm"]) == pytest.approx((12.0, 16.0), abs=2e-3)
    # the mask lies on the distance's own grid
    assert found.mask.sum() * (found.spacing / MM) ** 3 == pytest.approx(16.0 * 12.0 * 9.0, rel=0.1)
    low = (found.distance_affine_mm @ [*np.argwhere(found.mask).min(axis=0), 1.0])[2]
    assert low == pytest.approx(PLACE[2])
    assert found.summary()["boundary_sigma_mm"] == pytest.approx(0.1 * found.spacing / MM)
    assert found.summary()["snr"] is None


def test_a_lying_surface_stands_up_along_its_loading_axis(tmp_path):
    path = tmp_path / "lying.stl"
    pyvista.Box(bounds=(0, 9, -6, 6, -8, 8), level=3).triangulate().clean().save(path)
    axes = {"loading_axis": (1.0, 0.0, 0.0), "shear_axis": (0.0, 0.0, 1.0)}
    found = segmentation_from_surface(
        read_surface(path), SegmentationSettings(grid_spacing_mm=0.5), **axes
    )
    got = measure(found.distance, found.origin, found.spacing)
    sizes = [got[f"{name}_mm"] for name in ("length", "width", "height")]
    assert sizes == pytest.approx([16.0, 12.0, 9.0], abs=2e-3)


@pytest.mark.parametrize(("edge", "expected"), [(4.0, 1.0 / 6.0), (12.0, 0.25), (28.0, 0.35)])
def test_the_grid_suits_the_size_of_the_sample(edge, expected, tmp_path):
    box = pyvista.Box(bounds=(0, edge, 0, edge, 0, edge)).triangulate().clean()
    found = segmentation_from_surface(read_surface(saved(box, tmp_path)))
    assert found.spacing / MM == pytest.approx(expected)
    assert found.volume / MM**3 == pytest.approx(edge**3, rel=5e-3)


def test_a_surface_of_slicer_comes_into_the_world_of_images(tmp_path):
    surface, path = level_surface(*level_set()), tmp_path / "a.stl"
    place = np.eye(4)
    place[:3, 3] = [40.0, -70.0, 33.0]
    write_surface(path, surface, place)
    expected = surface.moved(place).points
    np.testing.assert_allclose(read_surface(path).points.max(axis=0), expected.max(axis=0), 1e-6)


def test_distance_is_exact_beside_the_walls_and_below_the_base(tmp_path):
    """A pyramid's walls and edges go on below z = 0 as planes, and so does their distance."""
    corners = np.array([[-6, -5, 0], [6, -5, 0], [6, 5, 0], [-6, 5, 0]], dtype=float)
    points = np.concatenate([corners, corners * 0.75 + [0, 0, 6]])
    solid = pyvista.PolyData(points).delaunay_3d().extract_surface(algorithm="dataset_surface")
    distance, origin, spacing = distance_grid(
        read_surface(saved(solid.triangulate(), tmp_path)), 0.5 * MM
    )
    x, y, z = (
        (origin[a] + spacing * i) / MM for a, i in enumerate(np.indices(distance.shape, float))
    )
    slopes = (np.abs(x) - 6.0 + 0.25 * z, np.abs(y) - 5.0 + 1.25 / 6.0 * z)
    planes = [slope / np.hypot(1.0, k) for slope, k in zip(slopes, (0.25, 1.25 / 6.0), strict=True)]
    inside = (np.maximum(*planes) < 0.0) & (z < 3.0)
    expected = np.maximum.reduce([*planes, z - 6.0])[inside]
    np.testing.assert_allclose(distance[inside] / MM, expected, atol=2e-6)
    assert np.all(distance[(np.maximum(*planes) > 1e-6) & (z < 6.0)] > 0.0)
    assert origin[2] <= -2.5 * MM
    assert (origin[2] / spacing) % 1.0 == 0.0


def holed(solid):
    return solid.extract_cells(range(5, solid.n_cells)).extract_surface(algorithm="dataset_surface")


SPOILT = {
    "hole": (holed, r"sample\.stl: not a closed surface, 7 edges have one.*; close its holes"),
    "inward": (lambda solid: solid.flip_faces(), "normals look inward; flip them"),
    "metres": (
        lambda solid: solid.scale(1e-3),
        "x 0.009 mm large .is it in m.*export .* in mm",
    ),
    "two": (lambda solid: solid + solid.translate((20, 0, 0)), "2 separate surfaces; keep the"),
}


@pytest.mark.parametrize("fault", SPOILT)
def test_a_bad_surface_is_refused_with_its_cure(fault, tmp_path):
    spoil, message = SPOILT[fault]
    with pytest.raises(MeshError, match=message):
        read_surface(saved(spoil(shape("cylinder")), tmp_path))


def test_triangles_that_look_to_opposite_sides_are_refused(tmp_path):
    whole = read_surface(saved(shape("cylinder"), tmp_path))
    triangles = whole.triangles.copy()
    triangles[3] = triangles[3, ::-1]
    with pytest.raises(MeshError, match="look to opposite sides; make the normals consistent"):
        TriangleSurface(whole.points, triangles).check_closed()


def test_two_solids_that_touch_are_refused(tmp_path):
    """Their common wall is an inner one: each of its edges has more than two triangles."""
    box = pyvista.Box(bounds=(0, 8, 0, 8, 0, 8), level=1).triangulate().clean()
    both = box + box.translate((8, 0, 0), inplace=False)
    with pytest.raises(MeshError, match="not a closed surface.*remove inner walls"):
        read_surface(saved(both, tmp_path))


def test_polygons_and_doubled_points_are_no_obstacle(tmp_path):
    """As a CAD program may save them: squares, each with points of its own."""
    box = pyvista.Box(bounds=(0, 8, 0, 9, 0, 7), level=2)
    path = tmp_path / "squares.vtp"
    box.separate_cells().extract_surface(algorithm="dataset_surface").save(path)
    assert pyvista.read(path).n_points == 4 * box.n_cells
    assert read_surface(path).volume / MM**3 == pytest.approx(8.0 * 9.0 * 7.0, rel=1e-6)


def test_what_is_no_stl_is_refused(tmp_path):
    (tmp_path / "solid.step").write_text("ISO-10303-21;\n")
    with pytest.raises(MeshError, match=r"not a surface by its ending; give \.stl, \.ply, \.vtp"):
        read_surface(tmp_path / "solid.step")
    with pytest.raises(MeshError, match="no such surface"):
        read_surface(tmp_path / "none.stl")
    (tmp_path / "text.stl").write_text("solid nothing\nendsolid\n")
    with pytest.raises(MeshError, match=r"text\.stl: not a readable STL file"):
        read_surface(tmp_path / "text.stl")


def test_a_thin_surface_and_a_base_that_is_not_quite_square_are_taken(tmp_path):
    box = pyvista.Box(bounds=(0, 18, 0, 15, 0, 2.5), level=9).triangulate().clean()
    assert read_surface(saved(box, tmp_path)).volume / MM**3 == pytest.approx(675.0, rel=1e-4)
    for degrees in (1.0, 3.0):
        strip = pyvista.Box(bounds=(-5, 5, -5, 5, 0, 10), level=19).triangulate().clean()
        leaning = read_surface(saved(strip.rotate_x(degrees, inplace=False), tmp_path))
        with pytest.raises(MeshError, match="lowest face is not flat"):
            base_centre(leaning)
    tilted = shape("block").rotate_x(0.2, inplace=False)
    centre = base_centre(read_surface(saved(tilted, tmp_path)))
    np.testing.assert_allclose(centre[:2] / MM, PLACE[:2], atol=0.1)


def test_a_surface_without_a_flat_base_is_refused(tmp_path):
    ball = pyvista.Sphere(radius=6.0, theta_resolution=60, phi_resolution=60)
    with pytest.raises(MeshError, match="lowest face is not flat.*cut the base flat"):
        distance_grid(read_surface(saved(ball, tmp_path)), 0.5 * MM)


def test_spacing_and_surface_are_checked():
    with pytest.raises(MeshError, match="give positive lengths"):
        distance_grid(TriangleSurface(np.zeros((0, 3)), np.zeros((0, 3), int)), 0.0)
    with pytest.raises(MeshError, match="holds no triangles"):
        distance_grid(TriangleSurface(np.zeros((0, 3)), np.zeros((0, 3), int)), 1e-3)


def level_set():
    """A block of 12 x 10 x 8 mm with round edges whose walls lean; no grid plane at z = 0."""
    spacing, origin = 0.25, np.array([-8.0, -7.0, -3.1])
    x, y, z = (
        origin[k] + spacing * i for k, i in enumerate(np.indices((66, 58, 60)).astype(float))
    )
    outside = np.stack([np.abs(x - 0.1 * z) - 6.0, np.abs(y) - 5.0, z - 8.0]) + 1.0
    far = np.linalg.norm(np.clip(outside, 0.0, None), axis=0)
    return MM * (far + np.minimum(outside.max(axis=0), 0.0) - 1.0), MM * origin, MM * spacing


def test_the_surface_of_a_distance_is_closed_and_stands_on_a_flat_base():
    surface = level_surface(*level_set())
    surface.check_closed()
    assert surface.points[:, 2].min() == 0.0
    section = 12.0 * 10.0 - (4.0 - np.pi)
    rounded_top = (4.0 - np.pi) * 0.25 * (2 * 12.0 + 2 * 10.0) - 1.1  # edges, less in the corners
    assert surface.volume / MM**3 == pytest.approx(section * 8.0 - rounded_top, rel=3e-3)
    base = surface.area_vectors[np.all(surface.points[surface.triangles, 2] == 0.0, axis=1)]
    assert -base[:, 2].sum() / MM**2 == pytest.approx(section, rel=3e-3)


def test_a_surface_is_written_in_the_world_of_slicer(tmp_path):
    surface, path = level_surface(*level_set()), tmp_path / "a.stl"
    place = np.diag([1.0, -1.0, -1.0, 1.0])  # upside down
    place[:3, 3] = [40.0, -70.0, 33.0]
    write_surface(path, surface, place)
    assert b"SPACE=LPS" in path.read_bytes()[:80]
    assert not path.read_bytes().startswith(b"solid")  # what readers take for text
    found = pyvista.read(path)
    assert found.is_manifold
    assert found.volume == pytest.approx(surface.volume / MM**3, rel=1e-5)
    low, high = surface.points.min(axis=0) / MM, surface.points.max(axis=0) / MM
    expected = [-40 - high[0], -40 - low[0], 70 + low[1], 70 + high[1], 33 - high[2], 33 - low[2]]
    np.testing.assert_allclose(found.bounds, expected, atol=1e-5)  # LPS: x and y change sign
    write_surface(path, surface)
    assert b"SPACE" not in path.read_bytes()[:80]
    np.testing.assert_allclose(read_surface(path).points.max(axis=0) / MM, high, atol=1e-5)


def test_the_boundary_of_a_mesh_is_a_closed_surface():
    surface = boundary_surface(mesh_cuboid(6e-3, 4e-3, 5e-3, 1e-3))
    surface.check_closed()
    assert surface.volume == pytest.approx(120e-9)
    assert len(surface.triangles) == 4 * (24 + 30 + 20)
