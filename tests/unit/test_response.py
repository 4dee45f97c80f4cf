"""Response curves at displacements of either sign, from tables of every mode and channel."""

import numpy as np
import pandas as pd
import pytest

import laboratory
from softsample.constitutive.homogeneous import FREE, homogeneous_force, homogeneous_normal
from softsample.constitutive.ogden import unit_modulus
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import SolverSettings
from softsample.protocol import MODES, travel_sign
from softsample.response import force
from softsample.response.changes import for_all_fractions, table_of_changes
from softsample.response.curves import ResponseCurves, before_zero
from softsample.response.elastic import Elastic, Tables
from softsample.response.perturbations import perturbations_of
from softsample.response.pieces import MechanicalTest, PerturbationSettings
from softsample.response.unit import (
    EXACT,
    ResponseSettings,
    homogeneous_response,
    modulus_fractions,
    response_table,
)
from softsample.shapes import ALONG_RADIUS, IdealShape, Indenter

ALPHA, RATIO = (-8.0, 16.0), 0.47
SOLID = unit_modulus(0.5, ALPHA, RATIO, 1.0)
SHAPE = IdealShape("cylinder", 20e-3, 20e-3, 10e-3)
REACH = 3e-3
TRAVEL = np.linspace(0.0, REACH, 41)
FORCE = 2.0 * TRAVEL + 500.0 * TRAVEL**2
MIRRORED = {"none": 0.0, "odd": -1.0, "even": 1.0}


class MeshedError(Exception):
    """Ends a run before it begins."""


@pytest.mark.parametrize("kind", ["sphere", "flat"])
def test_a_sample_is_as_fine_below_an_indenter_by_one_call_as_in_a_study(monkeypatch, kind):
    def stop(mesh, settings):
        raise MeshedError(mesh)

    monkeypatch.setattr(force, "ExplicitModel", stop)
    shape, ends = IdealShape("cuboid", 30e-3, 30e-3, 10e-3), Indenter(kind, 3e-3)
    with pytest.raises(MeshedError) as found:
        force.force_curve(shape, "indentation", SOLID, 1e-3, ends=ends)
    (mesh,) = found.value.args
    top = mesh.points[np.isclose(mesh.points[:, 2], shape.height)]
    places = np.unique(top[np.isclose(top[:, 1], 0.0), 0].round(9))
    below = places[np.abs(places) < 0.5 * ends.radius]
    assert len(below) > 2
    assert np.diff(below).max() <= 1.001 * ends.radius / ALONG_RADIUS


def response(mode):
    """File of a response in closed form."""
    law = (modulus_fractions(ResponseSettings()), ALPHA, RATIO)
    curves, _ = homogeneous_response(SHAPE, mode, REACH, *law, 60)
    return pd.DataFrame(response_table(curves, mode))


def exact(mode, channel, fraction, displacement):
    """Force over modulus [m2] along the displacement, or along +z, by the closed form."""
    solid, strain = unit_modulus(fraction, ALPHA, RATIO, 1.0), displacement / SHAPE.height
    if channel == "force_normal" and mode == "shear":
        return SHAPE.area * homogeneous_normal(strain, solid)
    sign = travel_sign(mode) if channel == "force_normal" else 1.0
    return sign * SHAPE.area * homogeneous_force(mode, strain, solid)


@pytest.mark.parametrize(("mode", "stretch"), [("tension", 2.2), ("pure_shear", 2.2)])
def test_a_closed_form_is_exact_between_its_fractions_at_large_stretches(mode, stretch):
    travel = (stretch - 1.0) * SHAPE.height
    table = homogeneous_response(SHAPE, mode, travel, EXACT, ALPHA, RATIO, 60)[0]
    curves = ResponseCurves.of_table(pd.DataFrame(response_table(table, mode)), mode)
    for fraction in (0.3, 0.99, 0.999, 0.9999, 0.99999):
        force = exact(mode, "force", fraction, curves.displacement)
        found = curves.force_per_mu(fraction, curves.displacement)
        np.testing.assert_allclose(found, force, atol=1e-5 * force.max())


@pytest.mark.parametrize("before", ["none", "smooth", "odd", "even"])
def test_before_zero_a_curve_is_what_it_says(before):
    curves = ResponseCurves(np.array([0.5]), TRAVEL, FORCE[None], before)
    there = np.array([0.2e-3, REACH, 1.1 * REACH])
    forward, back = (curves.force_per_mu(0.5, way * there) for way in (1.0, -1.0))
    assert np.all(np.diff(forward) > 0.0)
    if before == "smooth":
        ahead = 2.0 * -there + 500.0 * there**2
        np.testing.assert_allclose(back[0], ahead[0], rtol=1e-3)
    else:
        np.testing.assert_allclose(back, MIRRORED[before] * forward, rtol=1e-12)
    assert curves.force_per_mu(0.5, np.zeros(1)) == 0.0


@pytest.mark.parametrize("before", ["none", "smooth", "odd", "even"])
def test_curves_made_of_curves_keep_what_they_are_before_zero(before):
    """Else a force that is mirrored, or nothing, would have changes that are neither."""
    curves = ResponseCurves(np.array([0.2, 0.8]), TRAVEL, np.stack([FORCE, 1.5 * FORCE]), before)
    made = {
        "smoothed": curves.smoothed(),
        "minus": curves.minus(curves.like(np.stack([FORCE, FORCE]))),
        "carried": for_all_fractions({"x": -0.1 * curves.curve(0.6)}, curves, 0.6)["x"],
        "fibres": for_all_fractions({"fibres_z": 0.1 * FORCE}, curves, 0.6)["fibres_z"],
    }
    assert {name: of.before for name, of in made.items()} == dict.fromkeys(made, before)
    one = laboratory.alike(curves, {"one": -0.1 * FORCE})
    elastic = Elastic(curves, {**one, "all": made["carried"]})
    for name in ("one", "all"):
        back = elastic.change_per_mu(name, 0.6, -TRAVEL[5:])
        forward = elastic.change_per_mu(name, 0.6, TRAVEL[5:])
        expected = {**MIRRORED, "smooth": None}[before]
        if expected is not None:
            np.testing.assert_allclose(back, expected * forward, rtol=1e-12, atol=1e-30)


def test_the_side_before_zero_is_that_of_the_mode():
    sides = {(mode, channel): before_zero(mode, channel)
             for mode in MODES for channel in ("force", "force_normal")}  # fmt: skip
    assert sides["shear", "force"] == "odd"
    assert sides["shear", "force_normal"] == "even"
    assert {sides[mode, "force"] for mode in ("compression", "confined_compression")} == {"none"}
    assert {sides[mode, "force"] for mode in ("tension", "pure_shear")} == {"smooth"}


@pytest.mark.parametrize("channel", ["force", "force_normal"])
@pytest.mark.parametrize("mode", FREE)
def test_a_table_gives_back_the_closed_form_at_other_fractions_and_places(mode, channel):
    curves = ResponseCurves.of_table(response(mode), mode, channel)
    there = np.array([0.01, 0.33, 0.777, 1.0]) * REACH
    for fraction in (0.0, 0.31, 0.9, 1.0):
        wanted = exact(mode, channel, fraction, there)
        found = curves.force_per_mu(fraction, there)
        np.testing.assert_allclose(found, wanted, atol=2e-4 * np.abs(wanted).max())


@pytest.mark.parametrize("fraction", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("mode", FREE)
def test_curves_go_on_beyond_their_ends_as_the_closed_form_does(mode, fraction):
    """A pull becomes a push; a seventh of the travel further on, the end is still followed."""
    curves = ResponseCurves.of_table(response(mode), mode)
    sides = [1.05, 1.15] if before_zero(mode) == "none" else [-0.15, -0.05, 1.05, 1.15]
    there = np.array(sides) * REACH
    wanted = exact(mode, "force", fraction, there)
    found = curves.force_per_mu(fraction, there)
    np.testing.assert_allclose(found, wanted, atol=5e-3 * np.abs(wanted).max())
    further = np.diff(curves.force_per_mu(fraction, np.array([1.3, 1.4, 1.5]) * REACH))
    np.testing.assert_allclose(further[0], further[1])


@pytest.mark.parametrize(("channel", "sign"), [("force", -1.0), ("force_normal", 1.0)])
def test_shear_to_the_other_side_is_the_closed_form_there(channel, sign):
    curves = ResponseCurves.of_table(response("shear"), "shear", channel)
    there = np.array([-1.0, -0.4, -0.02]) * REACH
    wanted = exact("shear", channel, 0.6, there)
    np.testing.assert_allclose(wanted, sign * exact("shear", channel, 0.6, -there))
    found = curves.force_per_mu(0.6, there)
    np.testing.assert_allclose(found, wanted, atol=2e-4 * np.abs(wanted).max())


def test_changes_of_a_file_are_those_of_their_channel():
    """Their names end alike; units and signs are those of files."""
    curves, fraction = response("shear"), 0.6
    grid = np.linspace(0.0, 1.05 * REACH, 64)
    force, normal = (exact("shear", c, fraction, grid) for c in ("force", "force_normal"))
    changes = {"fibres_z": -0.1 * force, "fibres_z_normal": 0.3 * normal}
    table = table_of_changes("shear", fraction, grid, changes)
    assert list(table) == [
        "mu1_fraction", "displacement_mm", "fibres_z_mm2", "fibres_z_normal_mm2"
    ]  # fmt: skip
    for channel, part in (("force", -0.1), ("force_normal", 0.3)):
        elastic = Elastic.of_tables("shear", Tables(curves, [table], SOLID), channel)
        assert set(elastic.perturbations) == {"fibres_z"}
        assert not elastic.contact
        for there in (TRAVEL[1:], -TRAVEL[1:]):
            wanted = part * elastic.force_per_mu(fraction, there)
            found = elastic.change_per_mu("fibres_z", fraction, there)
            np.testing.assert_allclose(found, wanted, atol=2e-3 * np.abs(wanted).max())


@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.8, 1.0])
def test_changes_in_closed_form_hold_at_every_fraction(fraction):
    """Within 4 %. The part of the force differs between terms: from one fraction it is far off."""
    test = MechanicalTest(
        "compression", SOLID, REACH, ContactSettings(), SolverSettings(), PerturbationSettings(),
        "sliding",
    )  # fmt: skip
    changes = perturbations_of("ideal", SHAPE, lambda out: None, test)
    elastic = Elastic.of_tables("compression", Tables(response("compression"), [changes], SOLID))
    softer = unit_modulus(fraction, ALPHA, RATIO - 0.09, 1.0)
    force = SHAPE.area * homogeneous_force("compression", TRAVEL / SHAPE.height, softer)
    wanted = force - exact("compression", "force", fraction, TRAVEL)
    found = elastic.change_per_mu("poisson_0.09_less", fraction, TRAVEL)
    largest = np.abs(wanted).max()
    np.testing.assert_allclose(found, wanted, atol=0.04 * largest)
    one = changes[changes["mu1_fraction"] == (0.98 if fraction < 0.5 else 0.02)]
    elastic = Elastic.of_tables("compression", Tables(response("compression"), [one], SOLID))
    far = elastic.change_per_mu("poisson_0.09_less", fraction, TRAVEL)
    assert np.abs(far - wanted).max() > 0.25 * largest


def test_a_pressed_sample_bears_nothing_before_contact_whatever_is_changed():
    table = response("compression")
    grid = np.linspace(0.0, 1.05 * REACH, 64)
    change = 0.2 * exact("compression", "force", 0.6, grid)
    changes = table_of_changes("compression", 0.6, grid, {"poisson_0.02_less": change})
    elastic = Elastic.of_tables("compression", Tables(table, [changes], SOLID))
    assert elastic.contact
    gone = np.array([-1e-3, -1e-6])
    smallest = 1e-12 * elastic.force_per_mu(0.6, np.array([REACH]))[0]
    assert np.abs(elastic.force_per_mu(0.6, gone)).max() < smallest
    assert np.abs(elastic.change_per_mu("poisson_0.02_less", 0.6, gone)).max() < smallest
    assert elastic.change_per_mu("poisson_0.02_less", 0.6, np.array([1e-3]))[0] > 0.0


def test_a_sample_of_known_shape_weighs_no_more_than_1200_kg_in_a_cubic_metre():
    """Of a disc of 20 mm and 10 mm: 3.14 cm3, 37 mN."""
    tables = Tables(response("compression"), [], SOLID)
    known, unknown = (
        Elastic.of_tables("compression", tables, shape=shape) for shape in (SHAPE, None)
    )
    assert known.weight == pytest.approx(0.03698, rel=1e-3)
    assert unknown.weight is None


@pytest.mark.parametrize("ends", ["bonded", "sliding", 0.3])
@pytest.mark.parametrize("friction", [None, 0.2])
def test_changed_models_rub_on_the_platens_as_the_unchanged_one_does(block, ends, friction):
    contact = ContactSettings(friction=friction)
    test = MechanicalTest(
        "compression", SOLID, REACH, contact, SolverSettings(), PerturbationSettings(), ends
    )
    glued = block.glued(1e-4)
    plain = mode_boundary(block, "compression", glued, contact, ends)
    changed = mode_boundary(block, "compression", glued, test.platen_contact)
    assert changed.friction == plain.friction
    np.testing.assert_array_equal(changed.held, plain.held)
