"""A material: a sum of elastic laws with their moduli, bulk modulus and relaxation."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.law import FibreLaw, InvariantLaw, Law, SpectralLaw
from softsample.constitutive.laws import LAWS

UPRIGHT = (0.0, 0.0, 1.0)
"""Direction along the height."""


@dataclass(frozen=True)
class Relaxation:
    """Prony series of the isochoric stress, ``G(t) = 1 - sum g (1 - exp(-t/tau))``.

    A foam's stress, which has no isochoric part of its own, relaxes as a whole.

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
class Term:
    """One law with its numbers.

    Parameters
    ----------
    law : str
        Name in `softsample.constitutive.laws.LAWS`.
    modulus : float
        Its part of the initial shear modulus [Pa]; of fibres k1 [Pa], >= 0, which is no part.
    shape : tuple of float
        Shape parameters in the order of the law's.
    direction : tuple of float
        Of fibres, in the sample frame; normalised here. No other law heeds it.

    Raises
    ------
    ValueError
        On an unknown law or a number out of range.
    """

    law: str
    modulus: float
    shape: tuple[float, ...] = ()
    direction: tuple[float, float, float] = UPRIGHT

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ValueError(f"no elastic law {self.law!r}; there are {', '.join(LAWS)}")
        object.__setattr__(self, "shape", tuple(map(float, self.shape)))
        self.rule.check(self.shape)
        if self.is_fibre:
            object.__setattr__(self, "direction", self._unit_direction())

    def _unit_direction(self) -> tuple[float, ...]:
        length = float(np.linalg.norm(self.direction))
        if not (self.modulus >= 0.0 and length > 0.0):
            raise ValueError(
                f"fibres need a modulus >= 0 and a direction, got {self.modulus} Pa "
                f"along {self.direction}"
            )
        return tuple(float(a) / length for a in self.direction)

    @property
    def rule(self) -> Law:
        """The law itself."""
        return LAWS[self.law]

    @property
    def is_fibre(self) -> bool:
        """Whether it is of a direction, and no part of the initial shear modulus."""
        return isinstance(self.rule, FibreLaw)

    @property
    def own_poisson_ratio(self) -> float | None:
        """Poisson's ratio of a law that is of the volume as well."""
        return self.rule.poisson_ratio(self.shape)


@dataclass(frozen=True)
class Material:
    """A sum of laws; all but foams and fibres share the volumetric energy ``K/2 (J - 1)^2``.

    The initial shear modulus is the sum of the moduli of the terms that are no fibres.

    Parameters
    ----------
    terms : tuple of Term
        The laws; moduli finite, the shear modulus positive.
    poisson_ratio : float
        Initial Poisson's ratio, from 0 to below 0.5, of the terms that have none of their own.
    relaxation : Relaxation, optional
        Stress relaxation; the moduli are then the instantaneous ones.

    Raises
    ------
    ValueError
        On a value out of range.
    """

    terms: tuple[Term, ...]
    poisson_ratio: float = 0.49
    relaxation: Relaxation | None = None

    def __post_init__(self) -> None:
        moduli = tuple(term.modulus for term in self.terms)
        if not np.all(np.isfinite(moduli)) or self.shear_modulus <= 0.0:
            raise ValueError(f"moduli must be finite with a positive sum, got {moduli} Pa")
        if not 0.0 <= self.poisson_ratio < 0.5:
            raise ValueError(f"Poisson's ratio must lie in [0, 0.5), got {self.poisson_ratio}")

    @property
    def shear_modulus(self) -> float:
        """Initial shear modulus [Pa]."""
        return float(sum(term.modulus for term in self.terms if not term.is_fibre))

    @property
    def bulk_modulus(self) -> float:
        """Initial bulk modulus [Pa]."""
        return self.volumetric_modulus + float(
            sum(
                term.modulus / compressibility(term.own_poisson_ratio)
                for term in self.terms
                if term.own_poisson_ratio is not None
            )
        )

    @property
    def volumetric_modulus(self) -> float:
        """K [Pa] of ``K/2 (J - 1)^2``: the bulk modulus without what foams have of it."""
        # ASSUME: one volumetric term, D2 = 0: the paper gives a Poisson's ratio alone.
        shared = sum(
            term.modulus
            for term in self.terms
            if not term.is_fibre and term.own_poisson_ratio is None
        )
        return float(shared) / compressibility(self.poisson_ratio)

    @property
    def isotropic(self) -> bool:
        """Whether there are no fibres."""
        return not any(term.is_fibre for term in self.terms)

    def of_law(self, law: str) -> tuple[Term, ...]:
        """The terms of a law."""
        return tuple(term for term in self.terms if term.law == law)

    @property
    def mu(self) -> tuple[float, ...]:
        """Moduli [Pa] of the Ogden terms."""
        return tuple(term.modulus for term in self.of_law("ogden"))

    @property
    def alpha(self) -> tuple[float, ...]:
        """Exponents of the Ogden terms."""
        return tuple(term.shape[0] for term in self.of_law("ogden"))

    @property
    def mu1_fraction(self) -> float:
        """Part of the shear modulus that is in the first Ogden term, 0 if there is none."""
        return self.mu[0] / self.shear_modulus if self.mu else 0.0

    def plus(self, *terms: Term) -> Self:
        """The material with more terms; its shear modulus is the sum."""
        return type(self)((*self.terms, *terms), self.poisson_ratio, self.relaxation)


def compressibility(poisson_ratio: float) -> float:
    """Shear modulus over bulk modulus."""
    return 1.5 * (1.0 - 2.0 * poisson_ratio) / (1.0 + poisson_ratio)


def isotropic_response(
    log_stretch: NDArray[Any], dilatation: NDArray[Any], material: Material
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Strain energy and principal Kirchhoff stresses of all terms that are no fibres.

    Parameters
    ----------
    log_stretch : (..., 3) float64 or complex128
        Logarithms of the isochoric principal stretches, sum zero.
    dilatation : (...) float64 or complex128
        J - 1.
    material : Material
        Fibres have no part in it.

    Returns
    -------
    energy : (...)
        Per reference volume [Pa].
    stress : (..., 3)
        Principal Kirchhoff stresses [Pa], which are those of the Mandel stress.
    """
    pressure = material.volumetric_modulus * dilatation
    total = 0.5 * pressure * dilatation
    kirchhoff = (pressure * (1.0 + dilatation))[..., None] * np.ones(3)
    for term in material.terms:
        if not term.is_fibre:
            density, stresses = _unit_response(log_stretch, 1.0 + dilatation, term)
            total = total + term.modulus * density
            kirchhoff = kirchhoff + term.modulus * stresses
    return total, kirchhoff


def _unit_response(
    log_stretch: NDArray[Any], jacobian: NDArray[Any], term: Term
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Energy (...) and principal Kirchhoff stresses (..., 3) of an isotropic term per modulus."""
    law = term.rule
    if isinstance(law, SpectralLaw):
        x, y, z = np.moveaxis(log_stretch, -1, 0)
        density, *stresses = law.principal(x, y, z, jacobian, term.shape)
        return density, np.stack(stresses, axis=-1)
    assert isinstance(law, InvariantLaw)
    first, second = np.expm1(2.0 * log_stretch), np.expm1(-2.0 * log_stretch)
    density, by_first, by_second = law.slopes(first.sum(axis=-1), second.sum(axis=-1), term.shape)
    parts = np.expand_dims(by_first, -1) * first - np.expand_dims(by_second, -1) * second
    return density, 2.0 * (parts - parts.mean(axis=-1, keepdims=True))
