"""Closed forms of homogeneous tests against the full stress, felupe and known limits."""

import numpy as np
import pytest
from scipy.optimize import brentq

from exact import incompressible_stress, linear_modulus
from softsample.constitutive.homogeneous import (
    FREE,
    fibre_force,
    homogeneous_force,
    homogeneous_normal,
)
from softsample.constitutive.ogden import Fibres, OgdenMaterial
from softsample.errors import InputError
from spectral import stress as ogden_stress

pytestmark = pytest.mark.nojit

EXPONENTS = [(-8.0, 16.0), (-7.3, 11.9), (2.0, -4.0), (0.7, 25.0), (-25.0, 1.3)]
STRAINS = {
    "tension": [-0.4, 0.0, 0.1, 0.5, 1.5],
    "compression": [-0.5, 0.02, 0.2, 0.35],
    "pure_shear": [-0.3, 0.05, 0.4, 1.2],
    "confined_compression": [-0.2, 0.01, 0.2, 0.6],
    "shear": [-1.0, -0.2, 0.05, 0.5, 1.5],
}


def gradient(mode, strain, lateral):
    """Deformation gradient of a test whose free faces are stretched by `lateral`."""
    sign = -1.0 if mode in ("compression", "confined_compression") else 1.0
    stretch = 1.0 + sign * strain
    if mode == "shear":
        return np.array([[1.0, 0.0, strain], [0.0, lateral, 0.0], [0.0, 0.0, 1.0]])
    return np.diag(
        {
            "tension": [lateral, lateral, stretch],
            "compression": [lateral, lateral, stretch],
            "pure_shear": [1.0, lateral, stretch],
            "confined_compression": [1.0, 1.0, stretch],
        }[mode]
    )


def solved(mode, strain, solid):
    """Nominal stress (3, 3) with free faces, by a scalar root of the full tensor expression."""
    if mode == "confined_compression":
        return ogden_stress(gradient(mode, strain, 1.0), solid)

    def side(lateral):
        return ogden_stress(gradient(mode, strain, lateral), solid)[1, 1]

    return ogden_stress(gradient(mode, strain, brentq(side, 0.3, 3.0, xtol=1e-15)), solid)


@pytest.mark.parametrize("nu", [0.0, 0.1, 0.3, 0.49, 0.4999])
@pytest.mark.parametrize("alpha", EXPONENTS)
@pytest.mark.parametrize("mode", FREE)
def test_force_and_normal_force_are_those_of_the_full_stress(mode, alpha, nu):
    solid = OgdenMaterial((700.0, 200.0), alpha, nu)
    strain = np.array(STRAINS[mode])
    stress = np.array([solved(mode, s, solid) for s in strain])
    if mode == "shear":
        force = stress[:, 0, 2]
        scale = np.abs(stress[:, 2, 2]).max()
        np.testing.assert_allclose(
            homogeneous_normal(strain, solid), stress[:, 2, 2], atol=1e-9 * scale
        )
    else:
        force = stress[:, 2, 2] * (-1.0 if "compression" in mode else 1.0)
    np.testing.assert_allclose(
        homogeneous_force(mode, strain, solid), force, atol=1e-9 * np.abs(force).max()
    )


@pytest.mark.parametrize("alpha", EXPONENTS)
@pytest.mark.parametrize("mode", ["tension", "compression", "shear"])
def test_incompressible_limit_is_the_known_closed_form(mode, alpha):
    """What is left falls in proportion to mu / K."""
    strain, fraction = np.linspace(0.02, 0.25, 8), 0.7
    terms = list(zip((fraction, 1.0 - fraction), alpha, strict=True))
    exact = incompressible_stress(mode, strain, terms)
    gaps = []
    for nu in (0.49995, 0.499995):
        solid = OgdenMaterial((fraction, 1.0 - fraction), alpha, nu)
        gaps.append(np.abs(homogeneous_force(mode, strain, solid) - exact).max() / exact.max())
    assert gaps[0] < 0.1
    assert gaps[1] < 0.13 * gaps[0]


def incompressible_planar(strain, terms):
    stretch = 1.0 + strain
    return sum(2.0 * m / a * (stretch ** (a - 1.0) - stretch ** (-a - 1.0)) for m, a in terms)


def incompressible_normal(strain, terms):
    """Horgan and Murphy (2010): pressure from faces that are neither sheared nor held."""
    x = 0.5 * strain + np.sqrt(1.0 + 0.25 * strain**2)
    total = sum(2.0 * m / a * ((x**a - 1.0) + x**2 * (x**-a - 1.0)) for m, a in terms)
    return total / (1.0 + x**2)


@pytest.mark.parametrize("alpha", EXPONENTS)
@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (lambda g, s: homogeneous_force("pure_shear", g, s), incompressible_planar),
        (homogeneous_normal, incompressible_normal),
    ],
)
def test_incompressible_limit_of_planar_tension_and_of_the_normal_force(ours, theirs, alpha):
    strain = np.linspace(0.05, 0.25, 8)
    exact = theirs(strain, [(0.6, alpha[0]), (0.4, alpha[1])])
    gaps = [
        np.abs(ours(strain, OgdenMaterial((0.6, 0.4), alpha, nu)) - exact).max()
        for nu in (0.49995, 0.499995)
    ]
    assert gaps[0] < 0.1 * np.abs(exact).max()
    assert gaps[1] < 0.13 * gaps[0]


@pytest.mark.parametrize("nu", [0.1, 0.3, 0.45, 0.49])
@pytest.mark.parametrize(("mode", "test"), [("tension", "uniaxial"), ("pure_shear", "planar")])
def test_exponent_two_is_the_neo_hookean_solid_of_felupe(mode, test, nu):
    import felupe

    solid = OgdenMaterial((1000.0,), (2.0,), nu)
    stretch = np.linspace(1.0 if mode == "pure_shear" else 0.75, 1.6, 14)
    view = felupe.ViewMaterial(felupe.NeoHooke(mu=1000.0, bulk=solid.bulk_modulus))
    force = getattr(view, test)(stretches=stretch)[1]
    ours = homogeneous_force(mode, stretch - 1.0, solid)
    np.testing.assert_allclose(ours, force, atol=1e-6 * np.abs(force).max())


@pytest.mark.parametrize("nu", [0.0, 0.1, 0.3, 0.49, 0.4999])
@pytest.mark.parametrize("mode", FREE)
def test_initial_slope_is_that_of_linear_elasticity(mode, nu):
    """The modulus from Hooke's law itself: strains of the faces that are free are solved for."""
    solid = OgdenMaterial((500.0, 300.0), (-3.0, 5.0), nu)
    small = 1e-6
    slope = np.diff(homogeneous_force(mode, [-small, small], solid))[0] / (2.0 * small)
    assert slope == pytest.approx(linear_modulus(mode, solid), rel=1e-6)
    if mode == "shear":
        assert slope == pytest.approx(800.0, rel=1e-6)
        return
    lame = solid.bulk_modulus - 2.0 * 800.0 / 3.0
    hooke = lame + 2.0 * 800.0 * np.eye(3)
    free = np.flatnonzero(FREE[mode])
    strain = np.array([0.0, 0.0, 1.0])
    strain[free] = np.linalg.solve(hooke[np.ix_(free, free)], -hooke[free, 2])
    assert slope == pytest.approx(hooke[2] @ strain, rel=1e-6)


@pytest.mark.parametrize("nu", [0.1, 0.49])
def test_shear_force_is_odd_and_normal_force_even(nu):
    solid = OgdenMaterial((700.0, 200.0), (-8.0, 16.0), nu)
    strain = np.linspace(0.05, 1.5, 9)
    both = [homogeneous_force("shear", s, solid) for s in (strain, -strain)]
    np.testing.assert_allclose(both[1], -both[0], rtol=1e-11)
    normal = [homogeneous_normal(s, solid) for s in (strain, -strain)]
    np.testing.assert_allclose(normal[1], normal[0], rtol=1e-10)


def test_compression_is_tension_of_the_other_sign():
    solid = OgdenMaterial((700.0, 200.0), (-8.0, 16.0), 0.3)
    strain = np.linspace(-0.3, 0.3, 7)
    one, other = (
        homogeneous_force("compression", strain, solid),
        homogeneous_force("tension", -strain, solid),
    )
    np.testing.assert_allclose(one, -other, rtol=1e-14)


@pytest.mark.parametrize("alpha", [(-45.0,), (-8.0,), (0.5,), (2.0,), (45.0,)])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4999])
def test_large_strains_and_exponents_have_an_answer(alpha, nu):
    """From 90 % compression to a stretch of three the faces that are free bear nothing."""
    solid = OgdenMaterial((1000.0,), alpha, nu)
    for mode, strain in (
        ("tension", [1.0, 2.0]),
        ("compression", [0.6, 0.9]),
        ("pure_shear", [2.0]),
        ("confined_compression", [0.9]),
        ("shear", [-3.0, 3.0]),
    ):
        force = homogeneous_force(mode, strain, solid)
        assert np.all(np.isfinite(force))
        assert np.all(force * np.asarray(strain) > 0.0)


@pytest.mark.parametrize(
    ("alpha", "nu", "strain"),
    [
        ((2.0,), 0.0, 0.37), ((2.0,), 0.1, 0.41), ((2.0,), 0.3, 0.60), ((2.0,), 0.45, 0.89),
        ((-8.0, 16.0), 0.0, 0.35), ((-8.0, 16.0), 0.1, 0.37), ((-8.0, 16.0), 0.3, 0.43),
        ((-8.0, 16.0), 0.45, 0.53), ((-8.0, 16.0), 0.49, 0.61),
    ],
)  # fmt: skip
def test_compression_has_its_maximum_where_the_page_says(alpha, nu, strain):
    """`docs/solver.md`: the quadratic volumetric energy softens."""
    solid = OgdenMaterial((1.0,) * len(alpha), alpha, nu)
    strains = np.linspace(0.0, 0.95, 951)
    rising = np.diff(homogeneous_force("compression", strains, solid)) > 0.0
    assert strains[np.argmin(rising)] == pytest.approx(strain, abs=0.0055)


def pulled(x):
    """Stretch along x, y and z of an incompressible pull, and its derivative by the strain."""
    return np.array([x**-0.5, x**-0.5, x]), np.array([-0.5 * x**-1.5, -0.5 * x**-1.5, 1.0 + 0 * x])


@pytest.mark.parametrize("along", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (1, 2, 3)])
def test_few_fibres_add_the_slope_of_their_energy(along):
    """``(I4 - 1)^2`` by hand: of pull and push, and of simple shear of an incompressible solid."""
    fibres = Fibres(1.0, along)
    squares = np.square(along) / np.sum(np.square(along))
    for mode, sign in (("tension", 1.0), ("compression", -1.0)):
        strain = np.array([0.01, 0.1, 0.3, 0.9])
        stretch, slope = pulled(1.0 + sign * strain)
        added = 4.0 * (squares @ stretch**2 - 1.0) * (squares @ (stretch * slope)) * sign
        found = fibre_force(mode, strain, fibres, 1e6)
        assert found == pytest.approx(added, rel=1e-4, abs=1e-6)
    strain = np.array([-0.4, 0.1, 0.6])
    x, y, z = along / np.linalg.norm(along)
    square = (x + strain * z) ** 2 + y**2 + z**2
    added = 4.0 * (square - 1.0) * (x + strain * z) * z
    assert fibre_force("shear", strain, fibres, 1.0) == pytest.approx(added, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("stretch", [0.6, 1.3, 2.0])
@pytest.mark.parametrize("k1", [0.1, 5.0])
def test_many_fibres_across_a_pull_flatten_its_section(stretch, k1):
    """Both sides of a neo-Hookean solid of modulus 1 without traction, fibres along x: by hand."""

    def pressures(across):  # of either side
        square = across**2
        return square + 4.0 * k1 * (square - 1.0) * square, 1.0 / (square * stretch**2)

    across = brentq(lambda x: np.subtract(*pressures(x)), 0.2, 3.0, xtol=1e-15)
    added = stretch - pressures(across)[1] / stretch - (stretch - stretch**-2)
    mode, sign = ("tension", 1.0) if stretch > 1.0 else ("compression", -1.0)
    found = fibre_force(mode, sign * (stretch - 1.0), Fibres(k1, (1.0, 0.0, 0.0)), 1.0)
    assert found == pytest.approx([sign * added], rel=1e-5)


def test_foam_bulges_less_than_rubber_when_the_sides_are_held():
    """Confined compression meets the bulk modulus: cork crushes, rubber does not."""
    foam, rubber = (
        homogeneous_force("confined_compression", 0.1, OgdenMaterial((1.0,), (2.0,), nu))[0]
        for nu in (0.0, 0.49)
    )
    assert foam == pytest.approx(0.2, rel=0.1)
    assert rubber > 20.0 * foam


def test_what_is_no_homogeneous_test_is_refused():
    solid = OgdenMaterial((1000.0,), (2.0,), 0.3)
    with pytest.raises(InputError, match=r"strain 1.2 in compression leaves no height; check"):
        homogeneous_force("compression", [0.1, 1.2], solid)
    with pytest.raises(ValueError, match=r"mode 'torsion' is none of tension"):
        homogeneous_force("torsion", 0.1, solid)
    with pytest.raises(ValueError, match="isotropic solid"):
        homogeneous_force(
            "tension", 0.1, OgdenMaterial((1.0,), (2.0,), 0.3, Fibres(1.0, (0, 0, 1)))
        )
