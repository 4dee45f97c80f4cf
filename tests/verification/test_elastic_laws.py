"""Every elastic law: stress against energy, exact moduli, closed forms, felupe."""

import numpy as np
import pytest
from scipy.optimize import brentq

from elastic_laws import SHAPES, SOLIDS, TYPICAL, named
from exact import linear_modulus
from softsample.constitutive.homogeneous import (
    FREE,
    homogeneous_force,
    homogeneous_normal,
)
from softsample.constitutive.law import FibreLaw, InvariantLaw, SpectralLaw
from softsample.constitutive.laws import LAWS
from softsample.constitutive.material import Material, Term, isotropic_response
from spectral import energy, stress

every_solid = pytest.mark.parametrize("solid", SOLIDS, ids=named)
isotropic_solid = pytest.mark.parametrize("solid", [s for s in SOLIDS if s.isotropic], ids=named)


def gradients(count=6, size=0.2, seed=3):
    return np.eye(3) + size * np.random.default_rng(seed).uniform(-1, 1, (count, 3, 3))


def test_every_law_is_tested_here():
    assert {*SHAPES, "fibre"} == set(TYPICAL) == set(LAWS)


@every_solid
def test_stress_is_the_derivative_of_the_energy(solid):
    """Differences of eighth order, at several steps of which the best is good to 1e-9."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    F = gradients()
    wanted = stress(F, solid)
    gaps = []
    for reach in (3e-4, 1e-3, 3e-3, 8e-3, 2e-2):
        slopes = np.zeros_like(F)
        for i in range(3):
            for j in range(3):
                step = np.zeros((3, 3))
                step[i, j] = reach
                for k, weight in weights.items():
                    ahead, behind = (energy(F + s * k * step, solid) for s in (1, -1))
                    slopes[:, i, j] += weight * (ahead - behind) / reach
        gaps.append(np.abs(slopes - wanted).max(axis=(1, 2)) / np.abs(wanted).max(axis=(1, 2)))
    assert np.min(gaps, axis=0).max() < 1e-9


@isotropic_solid
def test_principal_stresses_are_exact_slopes(solid):
    """By complex steps of the stretches, which lose no digits."""
    rng = np.random.default_rng(8)
    logs = 0.25 * rng.uniform(-1.0, 1.0, (20, 3))

    def response(log_stretch):
        volume = log_stretch.sum(axis=-1)
        isochoric = log_stretch - volume[:, None] / 3.0
        return isotropic_response(isochoric, np.expm1(volume), solid)

    found, tiny = response(logs)[1], 1e-30
    for a in range(3):
        slope = response(logs + 1j * tiny * np.eye(3)[a])[0].imag / tiny
        np.testing.assert_allclose(slope, found[:, a], atol=1e-12 * np.abs(found).max())


@every_solid
def test_initial_moduli_are_exact(solid):
    """Second derivatives of the energy at rest, without fibres."""
    plain = Material(tuple(t for t in solid.terms if not t.is_fibre), solid.poisson_ratio)
    scale = 900.0 if len(plain.terms) == 1 and solid.isotropic else 700.0
    assert plain.shear_modulus == scale == solid.shear_modulus
    tiny = 1e-30

    def slope(direction):
        logs = 1j * tiny * np.array([direction])
        volume = logs.sum(axis=-1)
        isochoric = logs - volume[:, None] / 3.0
        return isotropic_response(isochoric, np.expm1(volume), plain)[1][0].imag / tiny

    np.testing.assert_allclose(slope([1.0, -1.0, 0.0])[0], 2.0 * scale, rtol=1e-14)
    np.testing.assert_allclose(
        slope([1.0, 1.0, 1.0]), 3.0 * plain.bulk_modulus * np.ones(3), rtol=1e-14
    )
    if len(plain.terms) == 1:
        nu = plain.poisson_ratio
        assert plain.bulk_modulus == pytest.approx(
            2.0 * scale * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)), rel=1e-15
        )


def test_a_sum_of_foam_and_rubber_has_both_bulk_moduli():
    foam, rubber = Term("foam", 500.0, (6.0, 0.1)), Term("neo_hooke", 200.0)
    both = Material((foam, rubber), 0.4)
    alone = Material((foam,), 0.1).bulk_modulus + Material((rubber,), 0.4).bulk_modulus
    assert both.bulk_modulus == pytest.approx(alone, rel=1e-15)


# --- the same from elsewhere ----------------------------------------------------------------------


def invariants(F):
    J = np.linalg.det(F)
    C = J ** (-2.0 / 3.0) * F.T @ F
    return C, np.trace(C), 0.5 * (np.trace(C) ** 2 - np.trace(C @ C)), J


def textbook(solid, F):
    """Energy by the formulas as they are printed, term by term."""
    C, I1, I2, J = invariants(F)
    stretch = np.linalg.svd(F)[1]
    total = 0.5 * solid.volumetric_modulus * (J - 1.0) ** 2
    for term in solid.terms:
        p, a = term.shape, np.array(term.direction)
        formulas = {
            "neo_hooke": lambda: 0.5 * (I1 - 3.0),
            "mooney_rivlin": lambda p=p: 0.5 * ((1 - p[0]) * (I1 - 3) + p[0] * (I2 - 3)),
            "yeoh": lambda p=p: 0.5 * ((I1 - 3) + p[0] * (I1 - 3) ** 2 + p[1] * (I1 - 3) ** 3),
            "gent": lambda p=p: -0.5 * p[0] * np.log(1.0 - (I1 - 3.0) / p[0]),
            "exponential_i1": lambda p=p: (
                np.expm1(p[0] * (I1 - 3)) / (2 * p[0]) if p[0] else 0.5 * (I1 - 3)
            ),
            "exponential_i2": lambda p=p: (
                np.expm1(p[0] * (I2 - 3)) / (2 * p[0]) if p[0] else 0.5 * (I2 - 3)
            ),
            "ogden": lambda p=p: (
                2.0 / p[0] ** 2 * (np.sum((J ** (-1 / 3) * stretch) ** p[0]) - 3.0)
                if p[0]
                else np.sum(np.log(J ** (-1 / 3) * stretch) ** 2)
            ),
            "foam": lambda p=p: _foam(p, stretch, J),
            "fibre": lambda p=p, a=a: _fibre(p, I1, a @ C @ a),
        }
        total += term.modulus * formulas[term.law]()
    return total


def _foam(shape, stretch, J):
    alpha, beta = shape[0], shape[1] / (1.0 - 2.0 * shape[1])
    if alpha == 0.0:
        return np.sum(np.log(stretch) ** 2) + beta * np.log(J) ** 2
    last = (J ** (-alpha * beta) - 1.0) / beta if beta else -alpha * np.log(J)
    return 2.0 / alpha**2 * (np.sum(stretch**alpha) - 3.0 + last)


def _fibre(shape, I1, I4):
    k2, kappa, pushed = shape
    E = kappa * (I1 - 3.0) + (1.0 - 3.0 * kappa) * (I4 - 1.0)
    whole = np.expm1(k2 * E**2) / (2.0 * k2) if k2 else 0.5 * E**2
    return whole if E > 0.0 else pushed * whole


@every_solid
def test_energy_is_the_formula_of_the_textbook(solid):
    for F in gradients(count=8, seed=11):
        near = 1e-6 if solid.alpha in ((1e-3,),) else 1e-10  # the formula itself cancels there
        assert energy(F, solid) == pytest.approx(textbook(solid, F), rel=near)


@pytest.mark.parametrize("nu", [0.1, 0.49])
def test_neo_hooke_is_that_of_felupe(nu):
    import felupe

    solid = Material((Term("neo_hooke", 800.0),), nu)
    F = gradients()
    theirs = felupe.NeoHooke(mu=800.0, bulk=solid.bulk_modulus).gradient(
        [np.moveaxis(F, 0, -1)[..., None], None]
    )[0][..., 0]
    wanted = np.moveaxis(theirs, -1, 0)
    np.testing.assert_allclose(stress(F, solid), wanted, atol=1e-12 * np.abs(wanted).max())


def of_law(law, *shape):
    """One law at a shear modulus of 1 Pa."""
    return Material((Term(law, 1.0, shape),), 0.49)


def test_simple_laws_are_limits_of_the_others():
    F = gradients()
    plain = stress(F, of_law("neo_hooke"))
    for law, shape in (
        ("mooney_rivlin", (0.0,)),
        ("yeoh", (0.0, 0.0)),
        ("gent", (1e9,)),
        ("exponential_i1", (0.0,)),
        ("ogden", (2.0,)),
    ):
        same = stress(F, of_law(law, *shape))
        np.testing.assert_allclose(same, plain, atol=1e-8 * np.abs(plain).max(), err_msg=law)
    second = stress(F, of_law("mooney_rivlin", 1.0))
    for law, shape in (("exponential_i2", (0.0,)), ("ogden", (-2.0,))):
        same = stress(F, of_law(law, *shape))
        np.testing.assert_allclose(same, second, atol=1e-8 * np.abs(second).max(), err_msg=law)
    log, near = (stress(F, of_law("ogden", a)) for a in (0.0, 1e-7))
    np.testing.assert_allclose(log, near, atol=1e-6 * np.abs(log).max())


def test_gent_beyond_its_limit_keeps_its_slope():
    """In simple shear the stress over the strain is 1 / (1 - strain^2 / Jm)."""
    solid = of_law("gent", 0.25)
    ratios = [stress(deformed("shear", s, 1.0), solid)[0, 2] / s for s in (0.4, 0.4999, 0.6, 0.9)]
    assert ratios == pytest.approx([1.0 / 0.36, 1000.0, 1000.0, 1000.0], rel=1e-9)
    energies = [energy(deformed("shear", s, 1.0), solid) for s in (0.59999, 0.60001)]
    assert np.diff(energies)[0] / 2e-5 == pytest.approx(600.0, rel=1e-6)


# --- homogeneous tests ----------------------------------------------------------------------------

STRAINS = {
    "tension": [-0.3, 0.1, 0.4],
    "compression": [-0.3, 0.05, 0.25],
    "pure_shear": [-0.2, 0.05, 0.3],
    "confined_compression": [-0.15, 0.02, 0.3],
    "shear": [-0.5, 0.05, 0.4],
}


def deformed(mode, strain, lateral):
    if mode == "shear":
        return np.array([[1.0, 0.0, strain], [0.0, lateral, 0.0], [0.0, 0.0, 1.0]])
    stretch = 1.0 - strain if "compression" in mode else 1.0 + strain
    wide = lateral if mode in ("tension", "compression") else 1.0
    deep = 1.0 if mode == "confined_compression" else lateral
    return np.diag([wide, deep, stretch])


@isotropic_solid
@pytest.mark.parametrize("mode", FREE)
def test_closed_forms_are_those_of_the_whole_stress(mode, solid):
    """Free sides by a scalar root of the tensor expression."""
    strain, P = np.array(STRAINS[mode]), []
    for s in strain:
        lateral = 1.0
        if mode != "confined_compression":
            lateral = brentq(
                lambda y, s=s: stress(deformed(mode, s, y), solid)[1, 1], 0.6, 1.6, xtol=1e-15
            )
        P.append(stress(deformed(mode, s, lateral), solid))
    P = np.array(P)
    force = P[:, 0, 2] if mode == "shear" else P[:, 2, 2] * (-1 if "compression" in mode else 1)
    scale = np.abs(P).max()
    np.testing.assert_allclose(homogeneous_force(mode, strain, solid), force, atol=1e-9 * scale)
    if mode == "shear":
        found = homogeneous_normal(strain, solid)
        np.testing.assert_allclose(found, P[:, 2, 2], atol=1e-9 * scale)


@isotropic_solid
@pytest.mark.parametrize("mode", FREE)
def test_initial_slopes_are_those_of_linear_elasticity(mode, solid):
    small = 1e-6
    slope = np.diff(homogeneous_force(mode, [-small, small], solid))[0] / (2.0 * small)
    assert slope == pytest.approx(linear_modulus(mode, solid), rel=1e-6)


@pytest.mark.parametrize("alpha", [-8.0, 0.0, 2.0, 12.0])
@pytest.mark.parametrize("nu", [0.0, 0.2, 0.45])
def test_sides_of_foam_contract_by_a_power_of_the_stretch(alpha, nu):
    """Storakers' closed form of uniaxial tension, lateral stretch l^(-nu) at any strain."""
    solid = of_law("foam", alpha, nu)
    stretch = np.array([0.6, 0.9, 1.2, 1.7])
    power = np.log(stretch) if alpha == 0.0 else (stretch**alpha - 1.0) / alpha
    lateral = -nu * np.log(stretch) if alpha == 0.0 else (stretch ** (-nu * alpha) - 1.0) / alpha
    exact = 2.0 * (power - lateral) / stretch  # beta ln J = -nu ln l in the lateral balance
    np.testing.assert_allclose(
        homogeneous_force("tension", stretch - 1.0, solid), exact, rtol=1e-10
    )
    side = np.array([np.diag([s ** (-nu), s ** (-nu), s]) for s in stretch])
    np.testing.assert_allclose(stress(side, solid)[:, 0, 0], 0.0, atol=1e-12)


def test_a_foam_whose_tractions_round_more_than_its_sides_move_has_its_stress():
    alpha, nu, stretch = -45.0, 0.429, np.linspace(1.0, 0.5, 41)
    power, lateral = stretch**alpha - 1.0, stretch ** (-nu * alpha) - 1.0
    exact = -2.0 * (power - lateral) / (alpha * stretch)
    found = homogeneous_force("compression", 1.0 - stretch, of_law("foam", alpha, nu))
    np.testing.assert_allclose(found, exact, rtol=1e-9)


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Term("rubber", 1.0), "no elastic law 'rubber'; there are exponential_i1"),
        (lambda: Term("gent", 1.0), "gent has Jm; got"),
        (lambda: Term("neo_hooke", 1.0, (1.0,)), "neo_hooke has no shape parameter"),
        (lambda: Term("gent", 1.0, (-1.0,)), "gent: Jm must be finite, from 1e-06"),
        (lambda: Term("foam", 1.0, (2.0, 0.5)), "foam: nu must be finite, from 0 to 0.4995"),
        (lambda: Term("fibre", 1.0, (0.0, 0.5, 0.0)), "kappa must be finite, from 0 to 0.333"),
        (lambda: Term("fibre", 1.0, (0.0, 0.0, 0.0), (0, 0, 0)), "fibres need a modulus"),
        (lambda: Term("fibre", -1.0, (0.0, 0.0, 0.0)), "fibres need a modulus"),
        (lambda: Material((Term("fibre", 1.0, (0.0, 0.0, 0.0)),)), "positive sum"),
    ],
)
def test_what_is_no_material_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_law_says_what_it_is(law):
    assert "doi:10." in law.source
    assert law.title
    assert law.energy
    assert isinstance(law, InvariantLaw | SpectralLaw | FibreLaw)
    for parameter in law.shape:
        assert parameter.least <= parameter.low <= parameter.default <= parameter.high
        assert parameter.high <= parameter.most
