"""Energy and stress of a material in plain spectral form, which the solver is tested against."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softsample.arrays import Array
from softsample.constitutive.law import FibreLaw
from softsample.constitutive.material import Material, Term, isotropic_response


def energy(gradient: ArrayLike, material: Material) -> Array:
    """Strain energy per reference volume [Pa] of deformation gradients (..., 3, 3).

    Raises
    ------
    ValueError
        If any determinant is not positive.
    """
    stretch, direction, J = isochoric_stretches(gradient)
    density = isotropic_response(np.log(stretch), J - 1.0, material)[0]
    for term in material.terms:
        if term.is_fibre:
            x, along, _ = _along(stretch, direction, term)
            density = density + term.modulus * _fibre(term)(x, along - 1.0, term.shape)[0]
    return np.asarray(density)


def stress(gradient: ArrayLike, material: Material) -> Array:
    """First Piola-Kirchhoff stress ``P = dW/dF``.

    ``P = F^-T M`` with the Mandel stress M, which is coaxial with C but for fibres.

    Parameters
    ----------
    gradient : (..., 3, 3) array_like
        Deformation gradients F, dimensionless, det F > 0.
    material : Material
        Relaxation has no part in it.

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
    Verified in ``tests/verification/test_elastic_laws.py`` by differences of the energy, against
    closed forms and felupe.
    """
    F = np.asarray(gradient, dtype=np.float64)
    stretch, direction, J = isochoric_stretches(F)
    mandel = isotropic_response(np.log(stretch), J - 1.0, material)[1]
    M = (direction * mandel[..., None, :]) @ np.swapaxes(direction, -1, -2)
    for term in material.terms:
        if term.is_fibre:
            M = M + _fibre_mandel(stretch, direction, term)
    return np.asarray(np.swapaxes(np.linalg.inv(F), -1, -2) @ M)


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


def _fibre(term: Term) -> Any:
    law = term.rule
    assert isinstance(law, FibreLaw)
    return law.slopes


def _along(stretch: Array, direction: Array, term: Term) -> tuple[Array, Array, Array]:
    """I1 - 3 (...), I4 (...) and Cbar a a (..., 3, 3) of a term's direction a."""
    squared = stretch**2
    a = np.array(term.direction)
    b = (direction * squared[..., None, :]) @ np.swapaxes(direction, -1, -2) @ a
    return squared.sum(axis=-1) - 3.0, b @ a, b[..., :, None] * a


def _fibre_mandel(stretch: Array, direction: Array, term: Term) -> Array:
    """Mandel stress (..., 3, 3) [Pa] of fibres: 2 dev(W1 Cbar + W4 Cbar a a)."""
    x, along, pulled = _along(stretch, direction, term)
    _, by_first, by_fourth = _fibre(term)(x, along - 1.0, term.shape)
    squared = (direction * (stretch**2)[..., None, :]) @ np.swapaxes(direction, -1, -2)
    M = np.expand_dims(by_first, (-1, -2)) * squared + np.expand_dims(by_fourth, (-1, -2)) * pulled
    mean = np.trace(M, axis1=-2, axis2=-1)[..., None, None] / 3.0
    return np.asarray(2.0 * term.modulus * (M - mean * np.eye(3)))
