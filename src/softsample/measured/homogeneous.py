"""Forces of an incompressible Ogden body under homogeneous deformation, in closed form."""

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.ogden import nominal_stress
from softsample.measured.measurement import Shape

Array = NDArray[np.float64]

WIDE = 3.0
"""A strip this many times wider than high keeps its width when it is pulled: pure shear."""


def force_per_mu(
    shape: Shape, mode: str, mixture: float, alpha: tuple[float, float], travel: Array
) -> Array:
    """Force along the travel per shear modulus (n,) [m2] at travels [m] along the loading.

    Without friction in compression, without holding the sides in tension (but for a wide strip),
    with faces that stay plane and parallel in shear.
    """
    strain = travel / shape.height
    if mode == "tension" and shape.length > WIDE * shape.height:
        return shape.area * _pure_shear_stress(1.0 + strain, mixture, alpha)
    return shape.area * nominal_stress(mode, strain, mixture, *alpha)


def _pure_shear_stress(stretch: Array, mixture: float, alpha: tuple[float, float]) -> Array:
    """Nominal stress per shear modulus (n,) of a strip whose width stays."""
    terms = zip((mixture, 1.0 - mixture), alpha, strict=True)
    return np.asarray(
        sum(2.0 * m / a * (stretch ** (a - 1.0) - stretch ** (-a - 1.0)) for m, a in terms)
    )


def normal_per_mu(shape: Shape, mixture: float, alpha: tuple[float, float], travel: Array) -> Array:
    """Normal force of simple shear per shear modulus (n,) [m2], tension positive.

    The faces that are neither sheared nor held are free of traction, which sets the pressure.

    References
    ----------
    C. O. Horgan, J. G. Murphy, J. Elasticity 98 (2010) 205, doi:10.1007/s10659-009-9225-7.
    """
    shear = travel / shape.height
    x = 0.5 * shear + np.sqrt(1.0 + 0.25 * shear**2)
    terms = zip((mixture, 1.0 - mixture), alpha, strict=True)
    total = sum(2.0 * m / a * ((x**a - 1.0) + x**2 * (x**-a - 1.0)) for m, a in terms)
    return np.asarray(shape.area * total / (1.0 + x**2))
