"""What other programs and ParaView are given; CalculiX runs it and meets the solver's curves."""

import shutil
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import pyvista

from peers import read_calculix_forces
from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import InputError
from softsample.export.abaqus import write_abaqus
from softsample.export.febio import write_febio
from softsample.export.series import write_series
from softsample.fem.boundary import (
    ContactSettings,
    glued_boundary,
    mode_boundary,
    platen_boundary,
)
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.fem.fields import Snapshot, contact_report, principal_hencky_strains
from softsample.fem.motion import FREE, PLATEN
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.graded import graded_hexes
from softsample.meshing.mesh import HexMesh
from softsample.meshing.sample import ideal_hexes
from softsample.shapes import IdealShape, Indenter

MATERIAL = OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49)
TRAVEL = {"compression": 3.9e-3, "tension": 3.25e-3, "shear": 3.9e-3}
STICKY = ContactSettings(release=False, side_walls=False, base_platen=False)
PULL = np.diag([0.9, 0.9, 1.3])

needs_calculix = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="needs CalculiX, Debian package calculix-ccx"
)


def cuboid(size_mm=2):
    return mesh_cuboid(23e-3, 20e-3, 13e-3, 1e-3 * size_mm)


def dome():
    """The cuboid with an arched top and slanted walls: a platen meets it little by little."""
    mesh = cuboid()
    x, y, z = mesh.points.T
    narrower = 1.0 - 0.1 * (z / z.max()) ** 2
    lower = 1.0 - 0.08 * ((x / x.max()) ** 2 + (y / y.max()) ** 2)
    return HexMesh(np.column_stack([x * narrower, y * narrower, z * lower]), mesh.hexes)


def turned():
    """A bonded cylinder in torsion."""
    mesh = ideal_hexes(IdealShape("cylinder", 20e-3, 20e-3, 8e-3), 1.4e-3)
    return mesh, mode_boundary(mesh, "torsion", mesh.glued(0.0), ContactSettings())


def indented(kind, ends):
    indenter = Indenter(kind, 4e-3, ends)
    fine, near = (0.5e-3, 2e-3) if kind == "sphere" else (0.7e-3, 4e-3)
    mesh = graded_hexes(IdealShape("cylinder", 20e-3, 20e-3, 8e-3), fine, near, 3e-3)
    return mesh, mode_boundary(mesh, "indentation", mesh.glued(0.0), ContactSettings(), indenter)


def difference(folder, mesh, boundary, travel):
    """Largest difference of CalculiX and the solver along the curve, over its peak."""
    write_abaqus(
        folder / "test.inp", mesh, MATERIAL, boundary, travel, program="calculix", increments=10
    )
    run = subprocess.run(["ccx", "test"], cwd=folder, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout[-2000:]
    time, force = read_calculix_forces(folder / "test.dat")
    assert time[-1] == 1.0
    assert len(time) > 10
    theirs = 1e-3 * boundary.spin * force[:, 2] if boundary.spin else force @ boundary.direction
    solved = ExplicitModel(mesh, SolverSettings()).run(MATERIAL, boundary, travel)
    ours = np.interp(time * travel, solved.displacement, solved.force)
    return np.abs(theirs - ours).max() / np.abs(theirs).max()


@needs_calculix
@pytest.mark.parametrize("mode", TRAVEL)
def test_calculix_runs_the_glued_cuboid_to_the_same_curve(tmp_path, mode):
    mesh = cuboid()
    boundary = glued_boundary(mesh, mode, mesh.glued(0.0))
    assert difference(tmp_path, mesh, boundary, TRAVEL[mode]) < 0.01  # measured 0.005 to 0.008


@needs_calculix
@pytest.mark.parametrize(
    "contact",
    [STICKY, ContactSettings(), ContactSettings(friction=0.0)],
    ids=["sticky", "default", "smooth"],
)
def test_calculix_runs_a_touching_platen_to_the_same_curve(tmp_path, contact):
    """Slip counted from the start of the step instead of first touch would cost 2 %."""
    mesh = dome()
    boundary = platen_boundary(mesh, contact)
    assert difference(tmp_path, mesh, boundary, 3.9e-3) < 0.0125  # measured 0.003 to 0.008


@needs_calculix
def test_calculix_turns_a_cylinder_with_the_same_torque_and_axial_force(tmp_path):
    mesh, boundary = turned()
    assert difference(tmp_path, mesh, boundary, 3e-3) < 0.0125  # measured 0.008
    time, force = read_calculix_forces(tmp_path / "test.dat", "AXIS")
    run = ExplicitModel(mesh, SolverSettings()).run(MATERIAL, boundary, 3e-3)
    ours = np.interp(3e-3 * time, run.displacement, run.force_vector[:, 2])
    assert ours.min() < -0.04  # it pushes on the platens
    np.testing.assert_allclose(force[:, 2], ours, atol=0.02 * np.abs(ours).max())


@needs_calculix
@pytest.mark.parametrize(
    ("kind", "ends"),
    [
        ("sphere", "sliding"),
        pytest.param("sphere", "bonded", marks=pytest.mark.long),
        ("flat", "sliding"),
    ],
)
def test_calculix_indents_a_cylinder_to_the_same_curve(tmp_path, kind, ends):
    assert difference(tmp_path, *indented(kind, ends), 0.8e-3) < 0.015  # measured 0.007 to 0.0113


def test_abaqus_gets_moduli_as_they_are_and_every_set(tmp_path):
    mesh, path = cuboid(5), tmp_path / "test.inp"
    boundary = glued_boundary(mesh, "shear", mesh.glued(0.0))
    write_abaqus(path, mesh, MATERIAL, boundary, 2e-3)
    lines = path.read_text().splitlines()
    law = [float(x) for x in lines[lines.index("*HYPERELASTIC, OGDEN, N=2") + 1].split(",")]
    np.testing.assert_allclose(law[:4], [1196.8e-6, -8.0, 113.1e-6, 16.0], rtol=1e-9)
    np.testing.assert_allclose(law[4], 2e6 / MATERIAL.bulk_modulus, rtol=1e-9)
    assert law[5] > 1e9  # no second volumetric term, and not CalculiX's default for zero
    assert "*ELEMENT, TYPE=C3D8R, ELSET=SAMPLE" in lines
    assert {"*NSET, NSET=BASE", "*NSET, NSET=BONDED", "BONDED, 1, 1, 2"} <= set(lines)
    assert not any("CONTACT" in line or "PLATEN" in line for line in lines)


def test_abaqus_gets_rough_contact(tmp_path):
    mesh, path = dome(), tmp_path / "test.inp"
    write_abaqus(path, mesh, MATERIAL, platen_boundary(mesh, STICKY), 2e-3)
    lines = path.read_text().splitlines()
    assert {"*FRICTION, ROUGH", "*SURFACE BEHAVIOR, NO SEPARATION"} <= set(lines)
    assert "PLATEN, 3, 3, -2" in lines
    corner = lines[lines.index("*NODE, NSET=PLATEN") + 1].split(",")
    assert float(corner[3]) == pytest.approx(1e3 * mesh.highest)


def test_abaqus_turns_a_rigid_top_by_the_angle_of_the_rim(tmp_path):
    mesh, boundary = turned()
    write_abaqus(tmp_path / "test.inp", mesh, MATERIAL, boundary, 3e-3)
    lines = (tmp_path / "test.inp").read_text().splitlines()
    axis = len(mesh.points) + 1
    assert {f"{axis}, 0, 0, 8", f"*RIGID BODY, REF NODE={axis}, TIE NSET=BONDED"} <= set(lines)
    (turn,) = [line for line in lines if line.startswith("AXIS, 6, 6, ")]
    assert float(turn.split(",")[3]) == pytest.approx(0.3)


@pytest.mark.parametrize(("ends", "friction"), [("sliding", []), (0.3, ["*FRICTION", "0.3"])])
def test_abaqus_gets_a_ball_that_slides_as_the_test_says(tmp_path, ends, friction):
    mesh, boundary = indented("sphere", ends)
    write_abaqus(tmp_path / "test.inp", mesh, MATERIAL, boundary, 0.8e-3)
    lines = (tmp_path / "test.inp").read_text().splitlines()
    first = lines.index("*SURFACE INTERACTION, NAME=PLATENCONTACT") + 1
    assert lines[first : lines.index("*BOUNDARY")] == friction
    first = lines.index("*NODE, NSET=PLATEN") + 1
    last = next(k for k, line in enumerate(lines) if k > first and line.startswith("*"))
    ball = np.array([line.split(",")[1:] for line in lines[first:last]], float)
    lower = ball[: len(ball) // 2]
    np.testing.assert_allclose(np.linalg.norm(lower - [0.0, 0.0, 12.0], axis=1), 4.0, rtol=1e-8)


def test_what_cannot_be_exported_is_refused(tmp_path):
    mesh = cuboid(5)
    boundary = glued_boundary(mesh, "tension", mesh.glued(0.0))
    with pytest.raises(InputError, match="no program 'ansys'; there are abaqus, calculix"):
        write_abaqus(tmp_path / "a.inp", mesh, MATERIAL, boundary, 1e-3, program="ansys")
    with pytest.raises(InputError, match="the platen must move, got 0 m"):
        write_febio(tmp_path / "a.feb", mesh, MATERIAL, boundary, 0.0)
    held = np.where(boundary.held == PLATEN, FREE, boundary.held)
    unmoved = replace(boundary, held=held)
    with pytest.raises(InputError, match="no node is bonded"):
        write_abaqus(tmp_path / "a.inp", mesh, MATERIAL, unmoved, 1e-3)
    for held_otherwise in (
        replace(boundary, friction=(0.0, 0.0)),
        replace(boundary, confined=(0,)),
    ):
        with pytest.raises(InputError, match="a base that slips and walls are not exported"):
            write_abaqus(tmp_path / "a.inp", mesh, MATERIAL, held_otherwise, 1e-3)
    (tmp_path / "a.dat").write_text("\n")
    with pytest.raises(InputError, match="holds no forces"):
        read_calculix_forces(tmp_path / "a.dat")


def ids(text):
    return np.array(text.split(","), dtype=int) - 1


def test_febio_gets_doubled_moduli_every_node_and_the_sets(tmp_path):
    mesh, path = cuboid(5), tmp_path / "test.feb"
    boundary = glued_boundary(mesh, "tension", mesh.glued(0.0))
    write_febio(path, mesh, MATERIAL, boundary, 2e-3)
    root = ET.parse(path).getroot()
    assert root.attrib == {"version": "4.0"}
    law = root.find("Material/material[@type='Ogden']")
    values = {child.tag: float(child.text) for child in law}
    assert values["c1"] == pytest.approx(2 * 1196.8e-6)
    assert values["c2"] == pytest.approx(2 * 113.1e-6)
    assert (values["m1"], values["m2"], values["pressure_model"]) == (-8.0, 16.0, 2.0)
    assert values["k"] == pytest.approx(1e-6 * MATERIAL.bulk_modulus)
    nodes = [node.text.split(",") for node in root.iterfind("Mesh/Nodes/node")]
    np.testing.assert_allclose(np.array(nodes, float), 1e3 * mesh.points, atol=1e-8)
    hexes = [ids(element.text) for element in root.iterfind("Mesh/Elements/elem")]
    np.testing.assert_array_equal(hexes, mesh.hexes)
    sets = {node_set.get("name"): ids(node_set.text) for node_set in root.iterfind("Mesh/NodeSet")}
    assert set(sets) == {"BASE", "BONDED"}
    np.testing.assert_array_equal(sets["BASE"], mesh.bottom)
    np.testing.assert_array_equal(sets["BONDED"], mesh.glued(0.0))
    prescribed = root.findall("Boundary/bc[@type='prescribed displacement']")
    moves = {bc.findtext("dof"): float(bc.findtext("value")) for bc in prescribed}
    assert moves == {"x": 0.0, "y": 0.0, "z": 2.0}
    assert all(bc.find("value").get("lc") == "1" for bc in prescribed)


@pytest.mark.parametrize(("release", "pulls"), [(True, True), (False, False)])
def test_febio_gets_sticky_platens(tmp_path, release, pulls):
    mesh, path = dome(), tmp_path / "test.feb"
    write_febio(path, mesh, MATERIAL, platen_boundary(mesh, ContactSettings(release)), 2e-3)
    root = ET.parse(path).getroot()
    contacts = root.findall("Contact/contact[@type='sticky']")
    pairs = {pair.get("name"): pair for pair in root.iterfind("Mesh/SurfacePair")}
    surfaces = {surface.get("name"): surface for surface in root.iterfind("Mesh/Surface")}
    points = np.array([n.text.split(",") for n in root.iterfind("Mesh/Nodes/node")], float)
    assert len(contacts) == 2
    for contact, height, up in zip(contacts, (0.0, 1e3 * mesh.highest), (1, -1), strict=True):
        assert (float(contact.findtext("max_traction")) > 0.0) is pulls
        pair = pairs[contact.get("surface_pair")]
        assert not np.isin(
            [ids(quad.text) for quad in surfaces[pair.findtext("primary")]], mesh.bottom
        ).any()
        face = points[ids(surfaces[pair.findtext("secondary")][0].text)]
        np.testing.assert_allclose(face[:, 2], height)
        assert np.sign(np.cross(face[1] - face[0], face[2] - face[1])[2]) == up  # to the sample
    moved = root.find("Rigid/rigid_bc[@name='PLATEN_z']")
    assert float(moved.findtext("value")) == pytest.approx(-2.0)
    assert root.find("Output/logfile/rigid_body_data").text == "3"  # material of the platen


def test_febio_turns_a_rigid_top_about_the_axis(tmp_path):
    mesh, boundary = turned()
    write_febio(tmp_path / "test.feb", mesh, MATERIAL, boundary, 3e-3)
    root = ET.parse(tmp_path / "test.feb").getroot()
    body = root.find("Material/material[@type='rigid body']")
    assert body.findtext("center_of_mass") == "0,0,8"
    assert root.find("Boundary/bc[@type='rigid']").findtext("rb") == body.get("name")
    (turn,) = root.findall("Rigid/rigid_bc[@type='rigid_rotation']")
    assert (turn.findtext("dof"), turn.find("value").get("lc")) == ("Rw", "1")
    assert float(turn.findtext("value")) == pytest.approx(0.3)
    fixed = root.find("Rigid/rigid_bc[@type='rigid_fixed']")
    held = {child.tag for child in fixed if child.text == "1"}
    assert held == {"Rx_dof", "Ry_dof", "Rz_dof", "Ru_dof", "Rv_dof"}
    assert not root.findall("Boundary/bc[@type='prescribed displacement']")
    assert root.find("Output/logfile/rigid_body_data").get("data").startswith("Mx;My;Mz")


def test_febio_gets_a_ball_that_slides(tmp_path):
    mesh, boundary = indented("sphere", 0.3)
    write_febio(tmp_path / "test.feb", mesh, MATERIAL, boundary, 0.8e-3)
    root = ET.parse(tmp_path / "test.feb").getroot()
    (contact,) = root.findall("Contact/contact")
    assert (contact.get("type"), contact.findtext("fric_coeff")) == ("sliding-elastic", "0.3")
    points = np.array([n.text.split(",") for n in root.iterfind("Mesh/Nodes/node")], float)
    faces = root.find("Mesh/Surface[@name='PLATEN_face']")
    corners = points[np.array([ids(face.text) for face in faces])]
    np.testing.assert_allclose(np.linalg.norm(corners - [0, 0, 12.0], axis=-1), 4.0, rtol=1e-8)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert (normal[:, 2] < 0.0).all()  # towards the sample


def snapshot(mesh, travel, displacement):
    held = np.where(mesh.points[:, 2] >= mesh.highest - 1e-9, PLATEN, 0).astype(np.int8)
    return Snapshot(travel, displacement, held, np.zeros(mesh.points.shape))


def test_a_series_comes_back_with_its_times_and_fields(tmp_path):
    mesh = cuboid(5)
    shots = [
        snapshot(mesh, f * 1e-3, f * mesh.points @ (PULL - np.eye(3))) for f in (0.0, 0.5, 1.0)
    ]
    write_series(tmp_path / "C3.pvd", mesh, shots)
    assert not list(tmp_path.rglob(".partial*"))
    reader = pyvista.get_reader(tmp_path / "C3.pvd")
    assert reader.time_values == [0.0, 0.5, 1.0]
    reader.set_active_time_value(1.0)
    grid = reader.read()[0]
    np.testing.assert_allclose(grid.point_data["displacement_mm"], 1e3 * shots[-1].displacement)
    np.testing.assert_array_equal(grid.point_data["held"], shots[-1].held)
    strains = np.log([0.9, 0.9, 1.3])
    np.testing.assert_allclose(
        grid.cell_data["principal_hencky_strains"], np.tile(strains, (grid.n_cells, 1))
    )
    np.testing.assert_allclose(grid.cell_data["max_principal_hencky_strain"], strains[-1])


def test_principal_strains_are_those_of_a_turned_stretch():
    mesh = cuboid(5)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    strains = principal_hencky_strains(mesh, mesh.points @ (PULL @ turn - np.eye(3)))
    np.testing.assert_allclose(strains, np.tile(np.log([0.9, 0.9, 1.3]), (len(mesh.hexes), 1)))


def test_contact_of_a_flat_top_is_length_times_width_and_the_pressure_uniform():
    mesh = cuboid(2)
    still = snapshot(mesh, 0.0, np.zeros(mesh.points.shape))
    top = still.held == PLATEN
    on_edges = (np.abs(mesh.points[:, 0]) > 11.49e-3).astype(int)
    on_edges += np.abs(mesh.points[:, 1]) > 9.99e-3
    cell = (23e-3 / 12) * 2e-3
    still.contact_force[top, 2] = -100.0 * cell / 2.0 ** on_edges[top]
    report = contact_report(mesh, still)
    assert report["contact_area_m2"] == pytest.approx(23e-3 * 20e-3)
    assert report["mean_contact_pressure_pa"] == pytest.approx(100.0)
    assert report["max_contact_pressure_pa"] == pytest.approx(100.0)


def test_contact_counts_corners_and_leaves_walls_out():
    mesh = cuboid(2)
    still = snapshot(mesh, 0.0, np.zeros(mesh.points.shape))
    still.held[mesh.points[:, 0] > 0.0] = 0
    half = contact_report(mesh, still)["contact_area_m2"]  # up to the middle of the open faces
    assert half == pytest.approx(20e-3 * (11.5e-3 + 23e-3 / 24))
    still.held[:] = 0
    assert set(contact_report(mesh, still).values()) == {0.0}


def test_walls_that_bulge_below_the_edge_of_the_top_do_not_touch():
    mesh = cuboid(2)
    bulge = 0.4 * np.sin(np.pi * mesh.points[:, 2] / mesh.highest)[:, None]
    barrel = snapshot(mesh, 0.0, mesh.points * [1.0, 1.0, 0.0] * bulge)
    area = contact_report(mesh, barrel)["contact_area_m2"]
    assert area == pytest.approx(23e-3 * 20e-3)


def test_an_arched_top_touches_by_half_of_its_faces_in_part():
    mesh = dome()
    crown = snapshot(mesh, 0.0, np.zeros(mesh.points.shape))
    faces = (mesh.boundary_quads[:, :, None] == np.flatnonzero(crown.held == PLATEN)).any(axis=2)
    assert faces.sum() == 4  # one node at the crown, in four faces
    area = contact_report(mesh, crown)["contact_area_m2"]
    assert area == pytest.approx(0.9**2 * 23e-3 / 12 * 2e-3, rel=0.01)
