"""Ogden solids in the convention of Abaqus, where ``sum(mu)`` is the shear modulus."""

from collections.abc import Mapping, Sequence
from typing import Any

from softsample.constitutive.material import Material, Relaxation, Term


def OgdenMaterial(  # noqa: N802 - it makes a solid, as a class would
    mu: Sequence[float],
    alpha: Sequence[float],
    poisson_ratio: float = 0.49,
    fibres: Term | None = None,
    relaxation: Relaxation | None = None,
) -> Material:
    """Solid ``W = sum 2 mu_i/alpha_i^2 (sum_a lbar_a^alpha_i - 3) + K/2 (J - 1)^2``.

    Here ``lbar_a = J**(-1/3) lambda_a`` are the isochoric principal stretches. The initial shear
    modulus is ``sum(mu)`` (FEBio's moduli are twice these) and the bulk modulus follows from
    Poisson's ratio, ``K = 2 mu (1 + nu) / (3 (1 - 2 nu))``.

    Parameters
    ----------
    mu : sequence of float
        Moduli [Pa]; their sum is positive.
    alpha : sequence of float
        Exponents, dimensionless, one per modulus; zero is the limit.
    poisson_ratio : float
        Initial Poisson's ratio, from 0 to below 0.5.
    fibres : Term, optional
        One family of fibres in addition.
    relaxation : Relaxation, optional
        Stress relaxation; the moduli are then the instantaneous ones.

    Raises
    ------
    ValueError
        On lengths that disagree or a value out of range.

    References
    ----------
    R. W. Ogden, Proc. R. Soc. Lond. A 326 (1972) 565, doi:10.1098/rspa.1972.0026.
    """
    if len(mu) != len(alpha) or not len(mu):
        raise ValueError(f"one modulus per exponent is needed, got {mu} and {alpha}")
    terms = tuple(Term("ogden", m, (a,)) for m, a in zip(mu, alpha, strict=True))
    return Material((*terms, fibres) if fibres else terms, poisson_ratio, relaxation)


def Fibres(modulus: float, direction: tuple[float, float, float]) -> Term:  # noqa: N802
    """One family of fibres, ``W = k1 (I4bar - 1)^2``, in tension and compression alike.

    Parameters
    ----------
    modulus : float
        k1 [Pa], not negative; small stretch along the fibres meets 8 k1 more stiffness.
    direction : tuple of float
        a in the sample frame.

    Raises
    ------
    ValueError
        If the modulus is negative or the direction has no length.
    """
    return Term("fibre", 2.0 * modulus, (0.0, 0.0, 1.0), direction)


def of_fit(fit: Mapping[str, Any]) -> Material:
    """Two-term material of a calibration report (`mu1_pa`, `mu2_pa`, `alpha`, ...)."""
    return OgdenMaterial((fit["mu1_pa"], fit["mu2_pa"]), fit["alpha"], fit["poisson_ratio"])


def unit_modulus(
    mu1_fraction: float, alpha: Sequence[float], poisson_ratio: float, modulus: float
) -> Material:
    """Ogden solid of shear modulus `modulus` [Pa] of which `mu1_fraction` is in the first term."""
    mu = (mu1_fraction * modulus, (1.0 - mu1_fraction) * modulus)
    if mu1_fraction == 1.0:
        return OgdenMaterial(mu[:1], tuple(alpha[:1]), poisson_ratio)
    return OgdenMaterial(mu, tuple(alpha), poisson_ratio)
