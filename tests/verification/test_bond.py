"""What a pre-load bonds: the contact of Hertz, and what glue adds to it."""

import dataclasses

import numpy as np
import pytest

from softsample.constitutive.ogden import unit_modulus
from softsample.errors import SimulationError
from softsample.fem.boundary import ContactSettings
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.bond import bonded_area
from softsample.meshing.mesh import HexMesh
from softsample.meshing.sample import SampleMesh, ideal_hexes
from softsample.response.bond import BondSettings, bonded_by_contact, by_rule, touched_nodes
from softsample.shapes import IdealShape

LAW = (-8.0, 16.0), 0.49
CONTACT = ContactSettings()
SOLVER = SolverSettings(loading_time_s=0.04, curve_error_percent=2.0)
RADIUS, PRELOAD = 40e-3, 0.5e-3


@pytest.fixture(scope="module")
def domed():
    """A wide cylinder whose top is a paraboloid."""
    flat = ideal_hexes(IdealShape("cylinder", 24e-3, 24e-3, 14e-3), 1e-3)
    way = np.hypot(flat.points[:, 0], flat.points[:, 1]) ** 2 / (2.0 * RADIUS)
    points = flat.points.copy()
    points[:, 2] *= 1.0 - way / flat.highest
    return HexMesh(points, flat.hexes)


def touched(mesh, fill=0.0):
    return touched_nodes(ExplicitModel(mesh, SOLVER), PRELOAD, fill, *LAW, CONTACT)


def test_a_dome_is_bonded_where_hertz_has_contact(domed):
    """a^2 = R d, where the platen would pass 2 R d if the dome did not yield."""
    found = bonded_area(domed, touched(domed)).sum()
    assert found == pytest.approx(np.pi * RADIUS * PRELOAD, rel=0.12)  # measured 1.07
    assert found < 0.7 * bonded_area(domed, domed.glued(PRELOAD)).sum()


def test_glue_fills_the_gap_beside_the_contact(domed):
    dry, wet = set(touched(domed)), set(touched(domed, 0.2e-3))
    assert dry < wet < set(domed.glued(PRELOAD + 0.2e-3))


def test_a_flat_top_is_bonded_as_a_whole():
    mesh = ideal_hexes(IdealShape("cuboid", 12e-3, 12e-3, 9e-3), 1.5e-3)
    top = np.flatnonzero(mesh.points[:, 2] > mesh.highest - 1e-9)
    assert set(top) <= set(touched(mesh))


def test_the_mesh_of_a_sample_gets_the_nodes(domed):
    bare = SampleMesh(domed, {"glued": np.zeros(len(domed.points), np.uint8)}, {}, {})
    settings = BondSettings("contact")
    found = bonded_by_contact(bare, PRELOAD, settings, *LAW, CONTACT, SOLVER)
    assert np.flatnonzero(found.point_data["glued"]).tolist() == touched(domed).tolist()
    assert not bare.point_data["glued"].any()


SECTIONS = {
    "solver": dataclasses.asdict(SOLVER),
    "contact": {},
    "material": {"alpha": LAW[0], "poisson_ratio": LAW[1], "region_stiffness": {}},
    "ends": "bonded",
}


def compared(domed):
    sample = domed, {"glued": np.ones(len(domed.points), np.uint8)}, {}
    material, bond = unit_modulus(0.5, *LAW, 1500.0), BondSettings()
    return by_rule(sample, "tension", material, 1e-3, 0.04, PRELOAD, bond, SECTIONS)


def test_the_rules_are_compared_by_the_force_of_the_same_test(domed):
    """Force grows with the area of a thin sample's bond, with its radius on a deep one."""
    found = compared(domed)
    areas = [bonded_area(domed, ids).sum() for ids in (touched(domed), domed.glued(PRELOAD))]
    assert [found["contact_mm2"], found["within_depth_mm2"]] == pytest.approx(
        [1e6 * area for area in areas]
    )
    part = areas[0] / areas[1]
    assert part < 1.0 + 0.01 * found["force_percent"] < np.sqrt(part)
    assert found["displacement_mm"][-1] == pytest.approx(1.0)
    work = [np.dot(found["force_ratio"], found["displacement_mm"]), sum(found["displacement_mm"])]
    assert found["force_percent"] == pytest.approx(100.0 * (work[0] / work[1] - 1.0), abs=2.0)


def test_what_cannot_be_simulated_is_left_open(domed, monkeypatch):
    def refuse(*_):
        raise SimulationError("elements give way")

    monkeypatch.setattr("softsample.response.bond.mode_boundary", refuse)
    found = compared(domed)
    assert found["force_percent"] is None
    assert found["force_ratio"] is None
    assert found["contact_mm2"] < found["within_depth_mm2"]
