"""Compressible Ogden solid in the convention of Abaqus, where ``sum(mu)`` is the shear modulus."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fibres:
    """One family of fibres, ``W = k1 (I4bar - 1)^2`` with ``I4bar = a . Cbar a``.

    Parameters
    ----------
    modulus : float
        k1 [Pa], not negative; small stretch along the fibres meets 8 k1 more stiffness.
    direction : tuple of float
        a in the sample frame; normalised here.

    Raises
    ------
    ValueError
        If the modulus is negative or the direction has no length.
    """

    modulus: float
    direction: tuple[float, float, float]

    def __post_init__(self) -> None:
        length = float(np.linalg.norm(self.direction))
        if not (self.modulus >= 0.0 and length > 0.0):
            raise ValueError(
                f"fibres need a modulus >= 0 and a direction, got {self.modulus} Pa "
                f"along {self.direction}"
            )
        unit = tuple(float(a) / length for a in self.direction)
        object.__setattr__(self, "direction", unit)


@dataclass(frozen=True)
class Relaxation:
    """Prony series of the isochoric stress, ``G(t) = 1 - sum g (1 - exp(-t/tau))``.

    Parameters
    ----------
    g : tuple of float
        Relaxing parts, positive, sum below one.
    tau_s : tuple of float
        Relaxation times [s], positive.

    Raises
    ------
    ValueError
        On lengths that disagree or a value out of range.

    References
    ----------
    J. C. Simo, Comput. Methods Appl. Mech. Engng 60 (1987) 153,
    doi:10.1016/0045-7825(87)90107-1.
    """

    g: tuple[float, ...]
    tau_s: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.g) != len(self.tau_s) or min(self.g + self.tau_s, default=1.0) <= 0.0:
            raise ValueError(f"one time > 0 per part > 0 is needed, got {self.g}, {self.tau_s} s")
        if sum(self.g) >= 1.0:
            raise ValueError(f"relaxing parts must sum to less than one, got {self.g}")


@dataclass(frozen=True)
class OgdenMaterial:
    """Parameters of ``W = sum 2 mu_i/alpha_i^2 (sum_a lbar_a^alpha_i - 3) + K/2 (J - 1)^2``.

    Here ``lbar_a = J**(-1/3) lambda_a`` are the isochoric principal stretches. The initial shear
    modulus is ``sum(mu)`` (FEBio's moduli are twice these) and the bulk modulus follows from
    Poisson's ratio, ``K = 2 mu (1 + nu) / (3 (1 - 2 nu))``.

    Parameters
    ----------
    mu : tuple of float
        Moduli [Pa]; their sum is positive.
    alpha : tuple of float
        Exponents, dimensionless, none zero, one per modulus.
    poisson_ratio : float
        Initial Poisson's ratio, from 0 to below 0.5.
    fibres : Fibres, optional
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

    mu: tuple[float, ...]
    alpha: tuple[float, ...]
    poisson_ratio: float = 0.49
    fibres: Fibres | None = None
    relaxation: Relaxation | None = None

    def __post_init__(self) -> None:
        if len(self.mu) != len(self.alpha) or not self.mu:
            raise ValueError(f"one modulus per exponent is needed, got {self.mu} and {self.alpha}")
        if not np.all(np.isfinite(self.mu)) or self.shear_modulus <= 0.0:
            raise ValueError(f"moduli must be finite with a positive sum, got {self.mu} Pa")
        if not np.all(np.isfinite(self.alpha)) or 0.0 in self.alpha:
            raise ValueError(f"exponents must be finite and not zero, got {self.alpha}")
        if not 0.0 <= self.poisson_ratio < 0.5:
            raise ValueError(f"Poisson's ratio must lie in [0, 0.5), got {self.poisson_ratio}")

    @classmethod
    def of_fit(cls, fit: Mapping[str, Any]) -> Self:
        """Two-term material of a calibration report (`mu1_pa`, `mu2_pa`, `alpha`, ...)."""
        return cls((fit["mu1_pa"], fit["mu2_pa"]), tuple(fit["alpha"]), fit["poisson_ratio"])

    @property
    def shear_modulus(self) -> float:
        """Initial shear modulus [Pa]."""
        return float(sum(self.mu))

    @property
    def mu1_fraction(self) -> float:
        """Part of the shear modulus that is in the first term."""
        return self.mu[0] / self.shear_modulus

    @property
    def bulk_modulus(self) -> float:
        """Initial bulk modulus [Pa]."""
        return self.shear_modulus / compressibility(self.poisson_ratio)

    @property
    def even(self) -> bool:
        """Whether every exponent is an even integer, so that no eigenvalues are needed."""
        return all(float(a).is_integer() and int(a) % 2 == 0 for a in self.alpha)


def compressibility(poisson_ratio: float) -> float:
    """Shear modulus over bulk modulus."""
    return 1.5 * (1.0 - 2.0 * poisson_ratio) / (1.0 + poisson_ratio)


def unit_modulus(
    mu1_fraction: float, alpha: Sequence[float], poisson_ratio: float, modulus: float
) -> OgdenMaterial:
    """Ogden solid of shear modulus `modulus` [Pa] of which `mu1_fraction` is in the first term."""
    mu = (mu1_fraction * modulus, (1.0 - mu1_fraction) * modulus)
    if mu1_fraction == 1.0:
        return OgdenMaterial(mu[:1], tuple(alpha[:1]), poisson_ratio)
    return OgdenMaterial(mu, tuple(alpha), poisson_ratio)


def isochoric_stretches(gradient: ArrayLike) -> tuple[Array, Array, Array]:
    """Isochoric principal stretches of deformation gradients.

    Parameters
    ----------
    gradient : (..., 3, 3) array_like
        Deformation gradients F, det F > 0.

    Returns
    -------
    stretch : (..., 3) float64
        ``J**(-1/3) lambda_a``, ascending.
    direction : (..., 3, 3) float64
        Principal directions of ``C = F^T F`` in columns.
    jacobian : (...) float64
        ``J = det F``.

    Raises
    ------
    ValueError
        If any determinant is not positive.
    """
    F = np.asarray(gradient, dtype=np.float64)
    J = np.linalg.det(F)
    if not np.all(J > 0.0):
        raise ValueError(f"deformation gradients must have det F > 0, smallest is {np.min(J):g}")
    squared, direction = np.linalg.eigh(np.swapaxes(F, -1, -2) @ F)
    return J[..., None] ** (-1.0 / 3.0) * np.sqrt(squared), direction, J


def ogden_energy(gradient: ArrayLike, material: OgdenMaterial) -> Array:
    """Strain energy per reference volume [Pa] of deformation gradients (..., 3, 3)."""
    stretch, _, J = isochoric_stretches(gradient)
    energy = 0.5 * material.bulk_modulus * (J - 1.0) ** 2
    for mu, alpha in zip(material.mu, material.alpha, strict=True):
        energy = energy + 2.0 * mu / alpha**2 * (np.sum(stretch**alpha, axis=-1) - 3.0)
    return np.asarray(energy)


def ogden_stress(gradient: ArrayLike, material: OgdenMaterial) -> Array:
    """First Piola-Kirchhoff stress ``P = dW/dF`` of an Ogden solid.

    ``P = F^-T M`` with the Mandel stress ``M = sum_i 2 mu_i/alpha_i dev(Cbar^(alpha_i/2))
    + K (J - 1) J I``. This is the plain spectral form; the solver's kernels are tested against it.

    Parameters
    ----------
    gradient : (..., 3, 3) array_like
        Deformation gradients F, dimensionless, det F > 0.
    material : OgdenMaterial
        Moduli [Pa], exponents and Poisson's ratio.

    Returns
    -------
    (..., 3, 3) float64
        Nominal force per reference area [Pa], first index the force direction, tension positive.

    Raises
    ------
    ValueError
        If any determinant is not positive.

    Notes
    -----
    Verified in ``tests/verification/test_ogden.py`` against closed forms and by differences.

    References
    ----------
    R. W. Ogden, Proc. R. Soc. Lond. A 326 (1972) 565, doi:10.1098/rspa.1972.0026.
    """
    F = np.asarray(gradient, dtype=np.float64)
    stretch, direction, J = isochoric_stretches(F)
    mandel = principal_stress(stretch, J - 1.0, material)
    M = (direction * mandel[..., None, :]) @ np.swapaxes(direction, -1, -2)
    return np.asarray(np.swapaxes(np.linalg.inv(F), -1, -2) @ M)


def principal_stress(isochoric: Array, dilatation: Array, material: OgdenMaterial) -> Array:
    """Principal Kirchhoff stresses (..., 3) [Pa], which are those of the Mandel stress.

    Parameters
    ----------
    isochoric : (..., 3) float64
        Principal stretches times ``J**(-1/3)``.
    dilatation : (...) float64
        J - 1.
    material : OgdenMaterial
        Moduli [Pa], exponents and Poisson's ratio.
    """
    pressure = material.bulk_modulus * dilatation * (1.0 + dilatation)
    stress = pressure[..., None] * np.ones(3)
    for mu, alpha in zip(material.mu, material.alpha, strict=True):
        power = isochoric**alpha
        stress = stress + 2.0 * mu / alpha * (power - np.mean(power, axis=-1, keepdims=True))
    return np.asarray(stress)


def nominal_stress(
    mode: str, strain: Array, mu1_fraction: float, alpha1: float, alpha2: float
) -> Array:
    """Nominal stress per shear modulus of an incompressible two-term solid in a homogeneous test.

    Parameters
    ----------
    mode : str
        `tension` and `compression` are uniaxial, `shear` is simple shear.
    strain : (n,) float64
        Travel over height, >= 0 in every mode, below 1 in compression.
    mu1_fraction : float
        Part of the first term in the shear modulus.
    alpha1, alpha2 : float
        Exponents.

    Returns
    -------
    (n,) float64
        Along the travel, >= 0 as the solid resists, dimensionless.
    """
    terms = ((mu1_fraction, alpha1), (1.0 - mu1_fraction, alpha2))
    if mode == "shear":
        stretch = 0.5 * strain + np.sqrt(1.0 + 0.25 * strain**2)
        total = sum(2.0 * m / a * (stretch**a - stretch**-a) for m, a in terms)
        return np.asarray(total / (stretch + 1.0 / stretch))
    sign = 1.0 if mode == "tension" else -1.0
    stretch = 1.0 + sign * strain
    return np.asarray(
        sign
        * sum(2.0 * m / a * (stretch ** (a - 1.0) - stretch ** (-0.5 * a - 1.0)) for m, a in terms)
    )
