"""Other laws than the model's: their forces, and that a diagnosis finds them."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

import laboratory
from softsample.constitutive.homogeneous import homogeneous_force, homogeneous_normal
from softsample.constitutive.material import Material, Term
from softsample.constitutive.ogden import OgdenMaterial, unit_modulus
from softsample.loop.candidates import candidates
from softsample.loop.diagnose import diagnose
from softsample.loop.effects.base import SOLID
from softsample.loop.model import FIXED
from softsample.loop.noise import NoiseSettings
from softsample.loop.posed import LoopSettings
from softsample.loop.specimen import Specimen
from softsample.loop.verdict import elastic_law
from softsample.protocol import travel_sign
from softsample.records import Record
from softsample.response.closed_form import ClosedForm, two_terms
from softsample.response.curves import ResponseCurves
from softsample.response.elastic import Elastic, Tables
from softsample.response.law_response import LawResponse
from softsample.response.unit import homogeneous_response, response_table
from softsample.shapes import IdealShape

MU, NU = 1300.0, 0.49
INCOMPRESSIBLE = 0.4999
STRIP = IdealShape("cuboid", 10e-3, 4e-3, 30e-3)
BLOCK = IdealShape("cuboid", 10e-3, 8e-3, 10e-3)
MODES = ("tension", "compression", "shear", "pure_shear", "confined_compression")
SETTINGS = LoopSettings(
    NoiseSettings(floor_percent=0.2, fine_percent=0.1, scale_percent=0.2, contact_zero_mm=0.005)
)
PAIRS = [
    (1.0, (-20.0, 16.0)), (0.0, (-8.0, 2.0)), (0.5, (-8.0, 16.0)), (0.3, (-45.0, 40.0)),
    (0.6, (-20.0, 1e-9)),
]  # fmt: skip


def two(fraction, alpha):
    """Two Ogden terms; one alone at either end."""
    if fraction == 0.0:
        return OgdenMaterial((1.0,), alpha[1:], NU)
    return unit_modulus(fraction, alpha, NU, 1.0)


def area(shape, mode, travel, solid, normal=False):
    """Force over modulus of a material by the module that knows every law."""
    strain = travel / shape.height
    if normal:
        return shape.area * homogeneous_normal(strain, solid)
    return shape.area * homogeneous_force(mode, strain, solid)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("normal", [False, True])
def test_fast_closed_forms_are_those_of_every_law(mode, normal):
    if normal and mode != "shear":
        pytest.skip("along the travel")
    travel = np.linspace(0.0, 0.5 * BLOCK.height, 41)
    closed = ClosedForm(BLOCK.area, mode, travel / BLOCK.height, normal, NU)
    for fraction, alpha in PAIRS:
        wanted = area(BLOCK, mode, travel, two(fraction, alpha), normal)
        found = closed.ogden(two_terms(fraction, alpha))
        np.testing.assert_allclose(found, wanted, atol=2e-7 * np.abs(wanted).max())
    for alpha, nu in ((-10.0, 0.0), (8.0, 0.3), (0.0, 0.2)):
        wanted = area(BLOCK, mode, travel, Material((Term("foam", 1.0, (alpha, nu)),), nu), normal)
        found = closed.foam(alpha, nu)
        np.testing.assert_allclose(found, wanted, atol=1e-6 * np.abs(wanted).max() + 1e-18)


@pytest.mark.parametrize(("alpha", "push"), [(2.0, 0.25), (-2.0, 0.5)])
def test_twisted_cylinders_are_those_of_rivlin(alpha, push):
    """Both solids of Mooney. R. S. Rivlin (1949), doi:10.1098/rsta.1949.0009."""
    strain = np.linspace(0.0, 0.5, 65)
    along, normal = (
        ClosedForm(BLOCK.area, "torsion", strain, across, 0.49999).ogden(((1.0, alpha),))
        for across in (False, True)
    )
    np.testing.assert_allclose(along, 0.5 * BLOCK.area * strain, rtol=1e-4)
    np.testing.assert_allclose(normal[1:], -push * BLOCK.area * strain[1:] ** 2, rtol=2e-3)


@pytest.mark.parametrize("alpha", [-20.0, 16.0])
def test_each_radius_of_a_twisted_cylinder_is_sheared(alpha):
    strain = np.linspace(0.0, 0.5, 65)
    found = ClosedForm(BLOCK.area, "torsion", strain, False, NU).ogden(((1.0, alpha),))
    solid = OgdenMaterial((1.0,), (alpha,), NU)

    def moment(radius):
        return 2.0 * radius**2 * homogeneous_force("shear", [0.5 * radius], solid)[0]

    wanted = BLOCK.area * quad(moment, 0.0, 1.0, epsabs=1e-10)[0]
    assert found[-1] == pytest.approx(wanted, rel=2e-4)


@pytest.mark.parametrize("mode", ["tension", "compression", "shear"])
def test_other_laws_are_exact_where_the_response_is_in_closed_form(mode):
    elastic = laboratory.exact(mode, BLOCK, 0.4)
    travel = np.linspace(1e-4, 0.4 * BLOCK.height, 333)
    for fraction, alpha in PAIRS:
        force = elastic.force_per_mu(fraction, travel)
        force = force + elastic.exponents_change_per_mu(fraction, travel, alpha)
        wanted = area(BLOCK, mode, travel, two(fraction, alpha))
        np.testing.assert_allclose(force, wanted, atol=3e-3 * wanted.max())
    foam = Material((Term("foam", 1.0, (8.0, 0.1)),), 0.1)
    for fraction in (0.2, 0.9):  # the fraction of the model has no part in it
        force = elastic.force_per_mu(fraction, travel)
        force = force + elastic.foam_change_per_mu(fraction, travel, 8.0, 0.1)
        wanted = area(BLOCK, mode, travel, foam)
        np.testing.assert_allclose(force, wanted, atol=3e-3 * wanted.max())


def test_both_channels_and_both_directions_of_a_shear():
    columns, _ = homogeneous_response(
        BLOCK, "shear", 5e-3, np.array([0.0, 0.5, 1.0]), SOLID.alpha, NU, 60
    )
    table = pd.DataFrame(response_table(columns, "shear"))
    travel = np.linspace(-5e-3, 5e-3, 101)
    for channel, normal in (("force", False), ("force_normal", True)):
        elastic = Elastic.of_tables("shear", Tables(table, [], SOLID), channel, BLOCK)
        force = elastic.force_per_mu(0.5, travel)
        force = force + elastic.exponents_change_per_mu(0.5, travel, (-20.0, 2.0))
        wanted = area(BLOCK, "shear", travel, two(0.5, (-20.0, 2.0)), normal)
        np.testing.assert_allclose(force, wanted, atol=5e-3 * np.abs(wanted).max())


def test_between_runs_a_law_is_interpolated_and_at_a_run_it_is_the_run():
    """A synthetic test: the force of the closed form times a factor of exponent and travel."""
    travel = np.linspace(0.0, 3e-3, 61)

    def real(alpha):
        return area(BLOCK, "tension", travel, two(1.0, (alpha,))) * factor(alpha)

    def factor(alpha):
        return 1.2 + 0.01 * alpha * travel / 3e-3

    ends = np.stack([real(16.0), real(-8.0)])
    curves = ResponseCurves(np.array([0.0, 1.0]), travel, ends)
    broken = np.where(travel < 2e-3, real(25.0), np.nan)
    runs = {-20.0: real(-20.0), 2.0: real(2.0), 25.0: broken}
    laws = LawResponse(curves, BLOCK, "tension", (-8.0, 16.0), NU, runs=runs)
    for alpha, there, close in (
        (-20.0, 1.0, 1e-3),
        (2.0, 1.0, 1e-3),
        (-14.0, 1.0, 0.02),
        (25.0, 0.6, 1e-2),
    ):
        found = curves.force_per_mu(1.0, travel) + laws.ogden_change(1.0, travel, (alpha, 16.0))
        wanted, inside = real(alpha), travel <= there * travel[-1]
        off = np.abs(found - wanted)[inside].max() / wanted[inside].max()
        assert off < close, alpha
    found = curves.force_per_mu(1.0, travel) + laws.ogden_change(1.0, travel, (25.0, 16.0))
    broke, closed = 39, area(BLOCK, "tension", travel, two(1.0, (25.0,)))
    beside = factor(16.0) * factor(25.0)[broke] / factor(16.0)[broke]  # of the next run, from there
    assert found[-1] == pytest.approx((closed * beside)[-1], rel=2e-3)
    assert np.all(np.isfinite(laws.ogden_change(0.5, travel, (-30.0, 25.0))))
    assert np.all(laws.ogden_change(0.5, travel, (-8.0, 16.0)) == 0.0)
    assert laws.knows_foams


def test_a_response_far_from_its_closed_form_says_nothing_of_foams():
    travel = np.linspace(0.0, 3e-3, 61)
    ends = np.stack([area(BLOCK, "compression", travel, two(0.0, (1.0, a))) for a in (16.0, -8.0)])
    late = ends * -np.expm1(-((travel / 1e-3) ** 2))
    curves = ResponseCurves(np.array([0.0, 1.0]), travel, late, "none")
    assert not LawResponse(curves, BLOCK, "compression", (-8.0, 16.0), NU).knows_foams


@pytest.mark.parametrize("touched", [1, 2, 5])
def test_a_platen_that_touches_late_changes_another_law_nowhere_before(touched):
    travel = np.linspace(0.0, 3e-3, 61)
    ends = np.stack([area(BLOCK, "compression", travel, two(0.0, (1.0, a))) for a in (16.0, -8.0)])
    ends[:, :touched] = 0.0
    curves = ResponseCurves(np.array([0.0, 1.0]), travel, 1.2 * ends, "none")
    laws = LawResponse(curves, BLOCK, "compression", (-8.0, 16.0), NU)
    change = laws.ogden_change(0.5, travel, (-20.0, 16.0))
    assert np.all(np.isfinite(change))
    assert np.abs(change[touched:]).max() > 0.0


def specimen(mode, shape, strain, stress, nu=NU):
    """A test with sliding ends: rest, loading and back, of a stress [Pa] against strain."""
    way = np.concatenate([np.zeros(150), np.linspace(0, 1, 500), np.linspace(1, 0, 500)])
    force = shape.area * stress(strain * way)
    noise = np.random.default_rng(7).normal(size=len(way)) * 5e-4 * force.max()
    table = pd.DataFrame({
        "time_s": 0.05 * np.arange(len(way)),
        "displacement_mm": travel_sign(mode) * 1e3 * strain * shape.height * way,
        "force_N": travel_sign(mode) * (force + noise),
    })  # fmt: skip
    record = Record.of_table(table).marked(mode)
    return Specimen.of_record(mode, mode, record, laboratory.exact(mode, shape, 1.02 * strain, nu))


def found(tests, laws=("ogden_exponents", "compressible_foam")):
    """Diagnosis with the laws and what might be taken for them."""
    names = (*laws, "machine_compliance", "force_offset", "displacement_zero")
    effects = [e for e in candidates(tests, STRIP.height, SOLID) if e.name in names]
    assert len(effects) == len(names)
    return diagnose(tests, SETTINGS, effects)


def size(state, effect, parameter):
    """Value of a parameter of an effect."""
    return state.values[effect][parameter]  # noqa: PD011 - no table


def strip():
    """Its one uniaxial test is that of a foam as well, one of Poisson's ratio 1/2."""

    def stress(strain):
        return MU * (1.0 + strain - (1.0 + strain) ** -2)

    return found([specimen("tension", STRIP, 0.6, stress, INCOMPRESSIBLE)], ["ogden_exponents"])


def test_a_neo_hookean_strip_is_found():
    selection = strip().selection
    assert selection.final.model.names == ("ogden_exponents",)
    fit = selection.steps[0].chosen.fit  # before its form is doubted
    assert fit.model.names == ("ogden_exponents",)
    assert fit.state.material.mu1_fraction < 0.02
    assert fit.state.material.mu == pytest.approx(MU, rel=0.02)
    assert size(fit.state, "ogden_exponents", "alpha2") == pytest.approx(2.0, abs=0.2)
    assert not fit.at_end[FIXED:].any()
    law = elastic_law(fit.state.values, SOLID)
    assert law["name"] == "ogden"
    assert law["alpha"][1] == pytest.approx(2.0, abs=0.2)


def test_one_steep_term_is_found_in_shear_and_compression():
    """Of an incompressible solid, by hand."""

    def sheared(gamma):
        s = 0.5 * gamma + np.sqrt(1.0 + 0.25 * gamma**2)
        return 2.0 * MU / -20.0 * (s**-20.0 - s**20.0) / (s + 1.0 / s)

    def pressed(strain):
        s = 1.0 - strain
        return -2.0 * MU / -20.0 * (s**-21.0 - s ** (0.5 * 20.0 - 1.0))

    tests = [
        specimen("shear", BLOCK, 0.3, sheared, INCOMPRESSIBLE),
        specimen("compression", BLOCK, 0.15, pressed, INCOMPRESSIBLE),
    ]
    fit = found(tests).selection.final
    assert fit.model.names[0] == "ogden_exponents"
    assert fit.state.material.mu1_fraction > 0.9
    assert size(fit.state, "ogden_exponents", "alpha1") == pytest.approx(-20.0, abs=1.5)
    assert fit.state.material.mu == pytest.approx(MU, rel=0.05)


def test_a_foam_is_found():
    foam = Material((Term("foam", MU, (6.0, 0.1)),), 0.1)
    tests = [specimen(mode, BLOCK, reach, lambda e, mode=mode: homogeneous_force(mode, e, foam))
             for mode, reach in (("compression", 0.4), ("shear", 0.4))]  # fmt: skip
    fit = found(tests).selection.final
    assert fit.model.names[0] == "compressible_foam"
    values = {p: size(fit.state, "compressible_foam", p) for p in ("share", "alpha", "nu")}
    assert values["share"] == pytest.approx(1.0, abs=0.05)
    assert values["nu"] == pytest.approx(0.1, abs=0.03)
    assert values["alpha"] == pytest.approx(6.0, abs=1.0)
    assert fit.state.material.mu == pytest.approx(MU, rel=0.03)
    law = elastic_law(fit.state.values, SOLID)
    assert (law["name"], law["poisson_ratio"]) == ("foam", values["nu"])


def test_the_law_of_the_model_is_named_where_nothing_else_is_found():
    law = elastic_law({"force_offset": {}}, SOLID)
    assert law == {"name": "ogden", "alpha": [-8.0, 16.0], "poisson_ratio": NU}


def test_without_a_shape_other_laws_are_no_candidates():
    tests = laboratory.Lab(seed=1).specimens()
    bare = [replace(s, elastic=replace(s.elastic, laws=None)) for s in tests]
    here, there = ({e.name for e in candidates(t, 13e-3, SOLID)} for t in (tests, bare))
    assert here - there == {"elastic_law", "ogden_exponents"}
