"""The Ogden solid against closed forms, differences and symmetries."""

import numpy as np
import pytest

from softsample.constitutive.laws import LAWS
from softsample.constitutive.ogden import OgdenMaterial, unit_modulus
from spectral import energy as ogden_energy
from spectral import isochoric_stretches
from spectral import stress as ogden_stress

pytestmark = pytest.mark.nojit

MU, ALPHA = np.array([900.0, 150.0]), np.array([-8.0, 16.0])
SOLID = OgdenMaterial(tuple(MU), tuple(ALPHA), 0.49)
ROUNDING = 1e-11  # relative; sums of powers up to 16 lose two or three digits


def cauchy(F, solid=SOLID):
    F = np.asarray(F, dtype=float)
    return ogden_stress(F, solid) @ F.T / np.linalg.det(F)


def gradients(seed=5, count=40, size=0.25):
    """Random deformation gradients, general shear and volume change included."""
    return np.eye(3) + size * np.random.default_rng(seed).uniform(-1, 1, (count, 3, 3))


def rotation(seed=1):
    Q, R = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.linalg.det(Q)


@pytest.mark.parametrize("stretch", [0.7, 0.95, 1.05, 1.3])
def test_uniaxial_stress_is_the_incompressible_closed_form(stretch):
    """At J = 1 the stress difference is that of the incompressible solid, whatever K."""
    s = cauchy(np.diag([stretch, stretch**-0.5, stretch**-0.5]))
    exact = np.sum(2.0 * MU / ALPHA * (stretch**ALPHA - stretch ** (-ALPHA / 2.0)))
    assert s[0, 0] - s[1, 1] == pytest.approx(exact, rel=ROUNDING)
    assert s[1, 1] == pytest.approx(s[2, 2], rel=ROUNDING)


@pytest.mark.parametrize("stretch", [0.8, 0.97, 1.04, 1.2])
def test_equibiaxial_stress_is_the_incompressible_closed_form(stretch):
    s = cauchy(np.diag([stretch, stretch, stretch**-2.0]))
    exact = np.sum(2.0 * MU / ALPHA * (stretch**ALPHA - stretch ** (-2.0 * ALPHA)))
    assert s[0, 0] - s[2, 2] == pytest.approx(exact, rel=ROUNDING)


@pytest.mark.parametrize("shear", [-0.4, 0.01, 0.3, 0.6])
def test_simple_shear_is_its_closed_form(shear):
    """Principal stretches l, 1/l, 1 and principal direction (l, 1) of the left stretch."""
    F = np.eye(3)
    F[0, 1] = shear
    s = cauchy(F)
    stretch = 0.5 * (shear + np.sqrt(4.0 + shear**2))
    exact = np.sum(2.0 * MU / ALPHA * (stretch**ALPHA - stretch**-ALPHA))
    exact *= stretch / (1.0 + stretch**2)
    assert s[0, 1] == pytest.approx(exact, rel=ROUNDING)
    assert ogden_stress(F, SOLID)[0, 1] == pytest.approx(exact, rel=ROUNDING)  # nominal = true
    # universal relation of every isotropic elastic solid
    assert s[0, 0] - s[1, 1] == pytest.approx(shear * s[0, 1], rel=1e-9)
    assert np.trace(s) == pytest.approx(0.0, abs=1e-9 * MU.sum())


@pytest.mark.parametrize("ratio", [0.8, 0.99, 1.01, 1.2])
def test_volume_change_gives_pressure_only(ratio):
    s = cauchy(ratio ** (1 / 3) * rotation())
    np.testing.assert_allclose(
        s, SOLID.bulk_modulus * (ratio - 1.0) * np.eye(3), atol=1e-9 * SOLID.bulk_modulus
    )


@pytest.mark.parametrize("alpha", [(-8.0, 16.0), (2.0, -4.0), (1.7, -3.3)])
def test_stress_is_the_derivative_of_the_energy(alpha):
    solid = OgdenMaterial((700.0, -90.0), alpha, 0.45)
    reach = 1e-6
    for F in gradients(count=10):
        slopes = np.empty((3, 3))
        for i in range(3):
            for j in range(3):
                step = np.zeros((3, 3))
                step[i, j] = reach
                ahead, behind = ogden_energy(F + step, solid), ogden_energy(F - step, solid)
                slopes[i, j] = (ahead - behind) / (2.0 * reach)
        P = ogden_stress(F, solid)
        np.testing.assert_allclose(slopes, P, atol=1e-7 * np.abs(P).max())


def test_initial_slopes_are_mu_two_mu_and_three_mu():
    """The convention, without its formula: sum(mu) is the shear modulus of small strain."""
    small = 1e-6
    F = np.eye(3)
    F[0, 1] = small
    assert cauchy(F)[0, 1] / small == pytest.approx(MU.sum(), rel=1e-4)
    s = cauchy(np.diag([1.0 + small, 1.0 / (1.0 + small), 1.0]))
    assert s[0, 0] - s[2, 2] == pytest.approx(2.0 * MU.sum() * small, rel=1e-4)
    s = cauchy(np.diag([1.0 + small, *2 * [(1.0 + small) ** -0.5]]))
    assert s[0, 0] - s[1, 1] == pytest.approx(3.0 * MU.sum() * small, rel=1e-4)


@pytest.mark.parametrize("nu", [0.1, 0.3, 0.49])
def test_lateral_contraction_of_small_strain_is_poissons_ratio(nu):
    """Bulk modulus, without its formula: contracting by nu leaves the sides free of stress."""
    solid, small = OgdenMaterial((500.0,), (4.0,), nu), 1e-6
    s = cauchy(np.diag([1.0 + small, 1.0 - nu * small, 1.0 - nu * small]), solid)
    assert s[0, 0] == pytest.approx(2.0 * (1.0 + nu) * 500.0 * small, rel=1e-3)
    assert abs(s[1, 1]) < 1e-3 * s[0, 0]


def test_stress_turns_with_the_body_and_knows_no_material_direction():
    F, Q = gradients(), rotation()
    P = ogden_stress(F, SOLID)
    scale = np.abs(P).max()
    np.testing.assert_allclose(ogden_stress(Q @ F, SOLID), Q @ P, atol=1e-11 * scale)
    np.testing.assert_allclose(ogden_stress(F @ Q, SOLID), P @ Q, atol=1e-11 * scale)


def test_undeformed_solid_is_free_of_energy_and_stress():
    assert ogden_energy(np.eye(3), SOLID) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(ogden_stress(np.eye(3), SOLID), 0.0, atol=1e-12)
    assert np.all(ogden_energy(gradients(), SOLID) > 0.0)


def test_unit_modulus_splits_one_modulus():
    solid = unit_modulus(0.3, (-8.0, 16.0), 0.49, 1000.0)
    assert solid.mu == pytest.approx((300.0, 700.0))
    assert solid.shear_modulus == pytest.approx(1000.0)
    one = unit_modulus(1.0, (-8.0, 16.0), 0.49, 1000.0)
    assert (one.mu, one.alpha) == ((1000.0,), (-8.0,))


@pytest.mark.parametrize(
    ("alpha", "even"), [(-8.0, True), (2.0, True), (3.0, False), (2.5, False), (0.0, False)]
)
def test_only_even_exponents_do_without_eigenvalues(alpha, even):
    assert LAWS["ogden"].even_power((alpha,)) is even


@pytest.mark.parametrize(
    ("mu", "alpha", "nu", "message"),
    [
        ((1.0, 2.0), (2.0,), 0.49, "one modulus per exponent"),
        ((), (), 0.49, "one modulus per exponent"),
        ((np.nan,), (2.0,), 0.49, "finite with a positive sum"),
        ((5.0, -6.0), (2.0, 4.0), 0.49, "finite with a positive sum"),
        ((1.0,), (np.inf,), 0.49, "alpha must be finite"),
        ((1.0,), (2.0,), 0.5, r"Poisson's ratio must lie in \[0, 0.5\), got 0.5"),
        ((1.0,), (2.0,), np.nan, "Poisson's ratio"),
    ],
)
def test_impossible_parameters_are_refused(mu, alpha, nu, message):
    with pytest.raises(ValueError, match=message):
        OgdenMaterial(mu, alpha, nu)


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan])
def test_deformation_without_volume_is_refused(bad):
    with pytest.raises(ValueError, match="det F > 0"):
        isochoric_stretches(np.diag([1.0, 1.0, bad]))
