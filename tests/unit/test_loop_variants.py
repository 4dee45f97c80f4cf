"""Runs of changed models: what differs by its sign, what is made of them, and how many they are."""

from dataclasses import asdict, replace

import numpy as np
import pandas as pd
import pytest

import laboratory
from softsample.constitutive.material import Relaxation
from softsample.constitutive.ogden import Fibres, OgdenMaterial
from softsample.errors import SimulationError
from softsample.fem.boundary import ContactSettings, mode_boundary, platen_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.loop.effects import library
from softsample.loop.model import Material, Model, State
from softsample.loop.specimen import Specimen
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.marks import MarkedImage
from softsample.meshing.sample import mesh_ideal
from softsample.protocol import History
from softsample.response.changes import for_all_fractions
from softsample.response.curves import ResponseCurves, before_zero
from softsample.response.elastic import Elastic, Tables
from softsample.response.perturbations import (
    STEPS,
    changed_boundaries,
    changed_materials,
    homogeneous_perturbations,
    perturbations_of,
    simulate_perturbations,
)
from softsample.response.pieces import MechanicalTest, MeshedSample, PerturbationSettings, mesher
from softsample.response.unit import EXACT, homogeneous_response, response_table
from softsample.shapes import IdealShape

MM = 1e-3
SOLID = OgdenMaterial((600.0, 400.0), (-8.0, 16.0), 0.49)
ANISOTROPY, PARTIAL_BOND, PLATEN_TILT, RATIO, RELAXATION = (
    library()[name]
    for name in (
        "anisotropy", "partial_bond", "platen_tilt", "poisson_ratio", "viscoelastic_relaxation",
    )
)  # fmt: skip
SIDES = ("ahead", "behind", "beside")
SOLVER = SolverSettings(loading_time_s=0.1)


def mesh_shifted(shift, width=7 * MM):
    shape = IdealShape("cuboid", 9 * MM, width, 6 * MM)
    return MeshedSample.of(mesh_ideal(shape.grown(shift), 1.0 * MM))


def mechanical_test(mode, travel, fibre_ratio=0.1, **more):
    steps = PerturbationSettings(fibre_ratio=fibre_ratio)
    return MechanicalTest(mode, SOLID, travel, ContactSettings(), SOLVER, steps, **more)


def forces(mode, travel):
    """Force [N] along the travel, whole and with a strip of the glue missing, by its side."""
    test = mechanical_test(mode, travel)
    sample = mesh_shifted(0.0)
    model = ExplicitModel(sample.mesh, SOLVER)
    whole = mode_boundary(sample.mesh, mode, sample.glued, test.contact)
    held = {"whole": whole, **changed_boundaries(sample, test)}
    return {
        name: model.run(SOLID, one, travel, loading_time=0.1).force for name, one in held.items()
    }


def test_in_tension_opposite_sides_of_a_cuboid_are_alike():
    found = forces("tension", 0.6 * MM)
    ahead, behind = found["partial_bond_ahead"], found["partial_bond_behind"]
    np.testing.assert_allclose(ahead, behind, atol=1e-4 * ahead.max())
    assert ahead[-1] < 0.97 * found["whole"][-1]


def test_in_shear_it_matters_from_which_end_the_glue_is_missing():
    found = forces("shear", 2.4 * MM)
    whole, ahead, behind, beside = (
        found[name] for name in ("whole", *(f"partial_bond_{s}" for s in SIDES))
    )
    early = len(whole) // 5
    lost_ahead, lost_behind = (
        1.0 - part[[early, -1]] / whole[[early, -1]] for part in (ahead, behind)
    )
    assert lost_ahead[1] > 1.3 * lost_ahead[0] > 0.0
    assert 0.0 < lost_behind[1] < 0.8 * lost_behind[0]
    assert 0.0 < 1.0 - beside[-1] / whole[-1] < lost_behind[1]


@pytest.mark.parametrize(
    ("side", "parts"),
    [(1.0, (1, 0, 0)), (-1.0, (0, 1, 0)), (0.0, (0, 0, 1)), (-0.4, (0, 0.4, 0.6))],
)
def test_missing_glue_goes_by_its_side(side, parts):
    specimen = laboratory.Lab().specimens()[2]
    names = [f"partial_bond_{where}" for where in SIDES]
    assert specimen.mode == "shear"

    def change(name):
        return specimen.elastic.change_per_mu(name, 0.7, specimen.travel)

    found = PARTIAL_BOND.elastic(specimen, 0.7, specimen.travel, {"missing": 0.25, "side": side})
    expected = sum(2.0 * part * change(name) for part, name in zip(parts, names, strict=True))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)


def specimen_of(mode, plain, runs):
    """What effects need of a specimen, from the force [N] of runs and of the changed ones."""
    pair = np.stack([plain.force] * 2)
    curves = ResponseCurves(np.array([0.0, 1.0]), plain.displacement, pair, before_zero(mode))
    changes = {name: run.force - plain.force for name, run in runs.items()}
    elastic = Elastic(curves, for_all_fractions(changes, curves, 0.5))
    travel, ramp = plain.displacement, np.full(len(plain.force), "ramp")
    return Specimen("block", mode, np.arange(len(travel)), travel, plain.force, ramp, elastic)


FEW = 0.01
"""Stiffness of fibres that leave the deformation as it is, over the shear modulus."""


class Block:
    """A block with and without fibres."""

    def __init__(self, mode, travel, width=7 * MM, few=FEW, **more):
        self.mode, self.travel = mode, travel
        self.test = mechanical_test(mode, travel, few, **more)
        sample = mesh_shifted(0.0, width)
        self.model = ExplicitModel(sample.mesh, SOLVER)
        self.held = mode_boundary(sample.mesh, mode, sample.glued, self.test.contact)
        self.plain = self.run(SOLID)
        materials = changed_materials(self.test)
        self.runs = {name: self.run(materials[name]) for name in materials if "fibres_" in name}
        self.largest = np.abs(self.runs["fibres_ahead"].force - self.plain.force).max()

    def run(self, material):
        return self.model.run(material, self.held, self.travel, loading_time=0.1)

    def change(self, *along):
        """Force by fibres of their own run."""
        fibres = Fibres(FEW * SOLID.shear_modulus, along)
        return self.run(SOLID.plus(fibres)).force - self.plain.force


@pytest.fixture(scope="module")
def blocks():
    return {
        "tension": Block("tension", 1.2 * MM),
        "shear": Block("shear", 2.4 * MM),
        "square": Block("tension", 1.2 * MM, 9 * MM),
    }


@pytest.mark.parametrize(("mode", "limit"), [("tension", 0.005), ("shear", 0.05)])
@pytest.mark.parametrize("angle", [15.0, -15.0, 30.0, -30.0, 70.0])
def test_fibres_at_any_angle_are_made_of_three_runs(blocks, mode, limit, angle):
    """Against a run of their own, with few fibres, as parts of the change by those at 45 deg."""
    block = blocks[mode]
    specimen = specimen_of(mode, block.plain, block.runs)
    x, z = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    values = {"k1": 0.1, "angle_deg": angle}
    found = ANISOTROPY.elastic(specimen, 0.6, block.plain.displacement, values)
    assert np.abs(found - block.change(x, 0.0, z)).max() < limit * block.largest


@pytest.mark.parametrize(("name", "limit"), [("square", 0.01), ("shear", 0.05)])
@pytest.mark.parametrize(("azimuth", "elevation"), [(20.0, 50.0), (-60.0, 35.0), (80.0, 10.0)])
def test_fibres_lie_in_each_test_as_its_piece_was_cut(blocks, name, limit, azimuth, elevation):
    """Loaded along 3 and sheared against 1, and sheared to the other side."""
    block = blocks[name]
    specimen = specimen_of(block.mode, block.plain, block.runs)
    specimen = replace(specimen, material_z=3, material_x=-1)
    effect = library(tests=[specimen])["anisotropy"]
    values = {"k1": 0.1, "azimuth_deg": azimuth, "elevation_deg": elevation}
    one, up = np.radians(azimuth), np.radians(elevation)
    x, y, z = -np.cos(up) * np.cos(one), np.cos(up) * np.sin(one), np.sin(up)
    there = block.plain.displacement
    found = effect.elastic(specimen, 0.6, there, values)
    assert np.abs(found - block.change(x, y, z)).max() < limit * block.largest
    if name == "shear":
        back = effect.elastic(specimen, 0.6, -there, values)
        assert np.abs(back + block.change(-x, y, z)).max() < limit * block.largest


@pytest.mark.parametrize(("mode", "travel"), [("tension", 1.2 * MM), ("shear", 2.4 * MM)])
def test_many_fibres_add_less_each(mode, travel):
    """Four times mu, between and along the runs; in proportion to few they were far off."""
    block = Block(mode, travel, few=0.1, many_fibres=True)
    specimen = specimen_of(mode, block.plain, block.runs)
    there = block.plain.displacement
    for angle in (0.0, 45.0, -45.0):
        x, z = np.sin(np.radians(angle)), np.cos(np.radians(angle))
        run = block.run(SOLID.plus(Fibres(4.0 * SOLID.shear_modulus, (x, 0.0, z))))
        found, few = (
            ANISOTROPY.elastic(specimen, 0.6, there, {"k1": k1, "angle_deg": angle})
            for k1 in (4.0, 0.1)
        )
        added = run.force - block.plain.force
        assert np.abs(found - added).max() < 0.08 * run.force.max(), angle
        assert np.abs(40.0 * few - added).max() > 0.12 * run.force.max(), angle


def test_fibres_add_the_same_force_to_any_law():
    """Sliding, pulled to a stretch of two, where an exponent of 16 spans decades: by hand."""
    shape, reach, terms = IdealShape("cuboid", 9 * MM, 9 * MM, 9 * MM), 9 * MM, (-8.0, 16.0)
    curves, _ = homogeneous_response(shape, "tension", reach, EXACT, terms, 0.4999, 60)
    solid = OgdenMaterial((0.6, 0.4), terms, 0.4999)
    steps = {"many_fibres": True, "ends": "sliding"}
    test = replace(mechanical_test("tension", reach, **steps), material=solid)
    changes = perturbations_of("ideal", shape, mesh_shifted, test)
    table = pd.DataFrame(response_table(curves, "tension"))
    elastic = Elastic.of_tables("tension", Tables(table, [changes], solid), shape=shape)
    travel = np.linspace(0.0, reach, 200)
    ramp, none = np.full(200, "ramp"), np.zeros(200)
    strip = Specimen("strip", "tension", np.arange(200.0), travel, none, ramp, elastic)
    law, stretch = library()["elastic_law"], 1.0 + travel / shape.height
    k1, angle = 0.3, np.radians(30.0)
    values = {
        "elastic_law": {"share": 1.0, "alpha": 3.0},
        "anisotropy": {"k1": k1, "angle_deg": 30.0},
    }
    found = Model((law, ANISOTROPY)).predict(strip, State(Material(1.0, 0.6), values))
    c, s = np.cos(angle) ** 2, np.sin(angle) ** 2
    few = 4.0 * k1 * (c * stretch**2 + s / stretch - 1.0) * (c * stretch - 0.5 * s / stretch**2)
    expected = 2.0 / 3.0 * (stretch**2 - stretch**-2.5) + few
    assert np.abs(found / shape.area - expected).max() < 5e-3 * expected.max()


def test_the_setting_of_few_fibres_changes_no_run_with_many():
    """Which is not in proportion to them, so that it cannot be scaled to its default."""
    one, other = (
        changed_materials(mechanical_test("shear", 2.4 * MM, ratio, many_fibres=True))
        for ratio in (0.1, 0.05)
    )
    assert one["fibres_z_many"] == other["fibres_z_many"]
    assert one["fibres_z"] != other["fibres_z"]
    assert STEPS.keys().isdisjoint(name for name in one if name.endswith("_many"))


@pytest.mark.parametrize("mode", ["tension", "shear"])
def test_sliding_pieces_have_fibres_if_directions_are_stated(mode):
    """In closed form; without directions, and of the normal force, there are none."""
    shape = IdealShape("cuboid", 9 * MM, 9 * MM, 9 * MM)
    stated, silent, normal = (
        homogeneous_perturbations(shape, mechanical_test(mode, 1.0 * MM, ends="sliding", **more))
        for more in ({"many_fibres": True}, {}, {"many_fibres": True, "normal": True})
    )
    third = "behind" if mode == "shear" else "x"
    names = [f"fibres_{name}" for name in ("z", "ahead", third)]
    both = {*names, *(f"{name}_many" for name in names)}
    assert {name for name in stated[1] if "fibres" in name} == both
    assert not any("fibres" in name for _, found in (silent, normal) for name in found)
    few = mechanical_test(mode, 1.0 * MM, 0.05, many_fibres=True, ends="sliding")
    _, half = homogeneous_perturbations(shape, few)
    for name in names if mode == "shear" else names[:1]:  # the others flatten the section
        assert half[name] == pytest.approx(stated[1][name], rel=1e-6, abs=1e-15)


def test_fibres_have_a_direction_of_the_material_if_all_tests_state_theirs():
    one, other = laboratory.Lab().specimens()[:2]
    stated = [replace(one, material_z=1), replace(other, material_z=2)]
    names = [p.name for p in library(tests=stated)["anisotropy"].parameters]
    assert names == ["k1", "azimuth_deg", "elevation_deg"]
    assert library(tests=[stated[0], other])["anisotropy"] == ANISOTROPY


@pytest.mark.parametrize(
    ("mode", "travel"), [("tension", 1.5 * MM), ("compression", 1.5 * MM), ("shear", 2.4 * MM)]
)
def test_other_ratios_are_made_of_two_runs(mode, travel):
    """Against runs of their own, as parts of the change at the end."""
    test = mechanical_test(mode, travel)
    sample = mesh_shifted(0.0)
    model = ExplicitModel(sample.mesh, SOLVER)
    held = mode_boundary(sample.mesh, mode, sample.glued, test.contact)

    def run(of):
        return model.run(of, held, travel, loading_time=0.1)

    plain, changed = run(SOLID), changed_materials(test)
    runs = {name: run(changed[name]) for name in changed if name.startswith("poisson_")}
    specimen = specimen_of(mode, plain, runs)
    for nu, limit in ((0.493, 0.15), (0.48, 0.03), (0.42, 0.01), (0.35, 0.03)):
        own = run(replace(SOLID, poisson_ratio=nu)).force - plain.force
        found = RATIO.elastic(specimen, 0.5, plain.displacement, {"nu": nu})
        assert np.abs(found - own).max() < limit * np.abs(own).max()


@pytest.mark.parametrize(
    ("mode", "travel"), [("tension", 1.5 * MM), ("compression", 1.5 * MM), ("shear", 2.4 * MM)]
)
def test_relaxation_that_spares_the_bulk_is_made_of_runs_with_other_ratios(mode, travel):
    """Against a run of a solid whose isochoric stress relaxes, until the sample lets go."""
    g, tau = 0.3, 8.0
    history = History(np.array([0.0, 10.0, 40.0, 50.0]), travel * np.array([0.0, 1.0, 1.0, 0.0]))
    test = mechanical_test(mode, travel)
    sample = mesh_shifted(0.0)
    model = ExplicitModel(sample.mesh, SOLVER)
    held = mode_boundary(sample.mesh, mode, sample.glued, test.contact)

    def run(of, through=travel):
        return model.run(of, held, through, loading_time=0.1)

    own = run(replace(SOLID, relaxation=Relaxation((g,), (tau,))), history)
    changed = changed_materials(test)
    ratios = {name: run(changed[name]) for name in changed if name.startswith("poisson_")}
    elastic = replace(specimen_of(mode, run(SOLID), ratios).elastic, contact=mode == "compression")
    time = np.linspace(0.0, 50.0, 2501)
    way = np.interp(time, history.time, history.travel)
    specimen = Specimen("block", mode, time, way, 0.0 * time, np.full(2501, "ramp"), elastic)

    def off(bulk):
        """Greatest error of the effect as a part of the peak."""
        values = {"g1": g, "tau1_s": tau, "g2": 0.0, "g3": 0.0, "tau3_s": 60.0, "bulk": bulk}
        state = State(Material(1.0, 0.5), {RELAXATION.name: values})
        found = Model((RELAXATION,)).predict(specimen, state)
        return np.abs(np.interp(own.time, time, found) - own.force).max() / own.force.max()

    assert off(1.0) < 0.012
    if mode != "shear":
        assert off(0.0) > 0.04


def wedge():
    """A block whose top rises by 3 degrees along x."""
    mesh = mesh_cuboid(9 * MM, 7 * MM, 6 * MM, MM)
    points = mesh.points.copy()
    points[:, 2] *= 1.0 + np.tan(np.radians(3.0)) * points[:, 0] / (6 * MM)
    return replace(mesh, points=points)


@pytest.mark.parametrize("mesh", [mesh_shifted(0.0).mesh, wedge()], ids=["cuboid", "wedge"])
def test_a_tilt_about_any_axis_is_made_of_those_about_two(mesh):
    """Against runs of their own, as parts of the peak; a wedge meets a platen that follows it."""
    test = mechanical_test("compression", 1.2 * MM)
    model = ExplicitModel(mesh, SOLVER)

    def run(held):
        return model.run(SOLID, held, test.travel, loading_time=0.1)

    plain = run(platen_boundary(mesh, test.contact))
    runs = {
        name: run(held)
        for name, held in changed_boundaries(MeshedSample(mesh, mesh.glued(0.0)), test).items()
        if name.startswith("platen_tilt_")
    }
    specimen = specimen_of("compression", plain, runs)
    for axis in (30.0, 140.0, -60.0, -110.0):
        tilt = (np.cos(np.radians(axis)), np.sin(np.radians(axis)))
        own = run(platen_boundary(mesh, test.contact, tilt_deg=tilt)).force - plain.force
        values = {"tilt_deg": 1.0, "axis_deg": axis}
        found = PLATEN_TILT.elastic(specimen, 0.6, plain.displacement, values)
        assert np.abs(own).max() > 0.05 * plain.force[-1]
        assert np.abs(found - own).max() < 0.02 * plain.force[-1]


def test_no_slip_is_added_to_a_platen_that_slips():
    test = replace(mechanical_test("compression", MM), contact=ContactSettings(friction=0.0))
    _, found = simulate_perturbations(mesh_shifted, test)
    assert "platen_tilt_x" in found
    assert not [name for name in found if name.startswith(("platen_slip", "platen_friction"))]


def test_ratios_of_changed_materials_are_below_that_of_the_model():
    test = replace(mechanical_test("tension", MM), material=replace(SOLID, poisson_ratio=0.46))
    found = changed_materials(test)
    ratios = [found[f"poisson_{less}_less"].poisson_ratio for less in ("0.02", "0.09")]
    assert ratios == pytest.approx([0.44, 0.37])


def test_a_run_of_another_ratio_is_made_where_elements_do_not_stand_the_lowest(monkeypatch):
    """What is found of a ratio between is about the same; of one run alone nothing is."""
    run = ExplicitModel.run

    def crushed(model, material, *given, **named):
        if material.poisson_ratio < 0.41:
            raise SimulationError("element 1 is crushed")
        return run(model, material, *given, **named)

    test = mechanical_test("tension", 1.0 * MM)
    travel, whole = simulate_perturbations(mesh_shifted, test)
    monkeypatch.setattr(ExplicitModel, "run", crushed)
    _, nearer = simulate_perturbations(mesh_shifted, test)
    assert "poisson_0.09_less" in whole
    assert {name for name in nearer if name.startswith("poisson_")} == {
        "poisson_0.02_less", "poisson_0.04_less",
    }  # fmt: skip
    curves = ResponseCurves(np.array([0.5]), travel, travel[None])  # no more than zero at rest
    alone = {"poisson_0.02_less": nearer["poisson_0.02_less"]}
    far, near, nothing = (
        Elastic(curves, laboratory.alike(curves, changes)).ratio_change_per_mu(0.5, travel, 0.46)
        for changes in (whole, nearer, alone)
    )
    np.testing.assert_allclose(near, far, atol=0.02 * np.abs(far).max())
    assert not nothing.any()


def test_changed_models_have_the_glue_and_the_regions_of_the_image():
    """A ball of tissue, its half x > 0 glued and its upper part three times as stiff."""
    axis = np.arange(-6.0, 6.1, 0.5) * MM
    points = np.stack(np.meshgrid(axis, axis, axis + 4.0 * MM, indexing="ij"), axis=-1)
    ball = np.linalg.norm(points - [0.0, 0.0, 2.0 * MM], axis=-1) - 5.0 * MM
    origin = points[0, 0, 0]
    to_index = np.eye(4)
    to_index[:3, :3] /= 0.5 * MM
    to_index[:3, 3] = -origin / (0.5 * MM)
    marks = {
        "bond_mask": MarkedImage((points[..., 0] > 0.0).astype(int), to_index),
        "labels": MarkedImage(np.where(points[..., 2] > 4.0 * MM, 2, 1), to_index),
    }
    settings = {"element_size_mm": 1.5, "elements_across": (1, 100), "boundary_shift_mm": 0.0}
    given = {
        "mesh": settings, "preload_mm": 1.0, "element_size_mm": 1.5, "mode": "tension",
        "bond": {"rule": "within_depth", "fill_mm": 0.0},
        "region_stiffness": {"1": 1.0, "2": 3.0},
    }  # fmt: skip
    grid = (ball, origin, 0.5 * MM)
    shape = IdealShape("cuboid", 12 * MM, 12 * MM, 6 * MM)
    of_marked, of_plain = (mesher("real", shape, lambda m=m: (grid, m), given) for m in (marks, {}))
    marked, plain = of_marked(0.0), of_plain(0.0)
    assert plain.stiffness is None
    middle = marked.mesh.points[marked.mesh.hexes].mean(axis=1)[:, 2]
    assert set(marked.stiffness[middle < 3.5 * MM]) == {1.0}
    assert set(marked.stiffness[middle > 4.5 * MM]) == {3.0}
    assert plain.mesh.points[plain.glued, 0].min() < -MM < marked.mesh.points[marked.glued, 0].min()
    assert marked.model(SOLVER) is not None
    simulated = {
        "material": {"alpha": (-8.0, 16.0), "poisson_ratio": 0.49, "region_stiffness": {"1": 1.0}},
        "contact": asdict(ContactSettings()), "solver": asdict(SOLVER),
    }  # fmt: skip
    deep = given | simulated | {"preload_mm": 2.5}
    by_contact = deep | {"bond": {"rule": "contact", "fill_mm": 0.0}}
    within, touched = (
        mesher("real", shape, lambda: (grid, {}), of)(0.0).glued for of in (deep, by_contact)
    )
    assert set(touched) < set(within)
    of_mask = mesher("real", shape, lambda: (grid, marks), by_contact)(0.0)
    assert of_mask.glued.tolist() == marked.glued.tolist()
    larger = of_marked(0.2 * MM)
    assert np.ptp(larger.mesh.points[:, 0]) > np.ptp(marked.mesh.points[:, 0])
    assert larger.stiffness.max() == 3.0


@pytest.mark.parametrize("mode", ["tension", "compression", "shear"])
def test_a_verdict_costs_at_most_22_runs_a_mode(mode, monkeypatch):
    """Those at two loading times of the plain model are among them."""
    runs, run = [], ExplicitModel.run

    def counted(*given, **named):
        runs.append(given)
        return run(*given, **named)

    monkeypatch.setattr(ExplicitModel, "run", counted)
    test = mechanical_test(mode, 0.5 * MM)
    simulate_perturbations(mesh_shifted, test)
    assert len(runs) <= 22
