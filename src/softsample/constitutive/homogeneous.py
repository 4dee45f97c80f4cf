"""Homogeneous tests of any isotropic law: what ends without friction leave.

Every test has three principal stretches, some of which are given by the strain and the others
follow from faces without traction. The finite element tests with sliding ends are these.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize.elementwise import find_minimum

from softsample.arrays import Array
from softsample.constitutive.law import FibreLaw
from softsample.constitutive.material import Material, Term, isotropic_response
from softsample.errors import InputError

FREE = {
    "tension": (1.0, 1.0, 0.0),
    "compression": (1.0, 1.0, 0.0),
    "shear": (0.0, 1.0, 0.0),
    "pure_shear": (0.0, 1.0, 0.0),
    "confined_compression": (0.0, 0.0, 0.0),
}
"""One for the principal directions along which nothing holds the sample, the second (y) in each
but confined compression; in simple shear the first and third lie in the plane of shear."""

COMPRESSIVE = ("compression", "confined_compression")
"""Modes whose positive strain shortens the sample."""

CLOSE = 1e-11
"""Change of a logarithmic stretch, or interval that holds it, that ends Newton's iteration."""

STEP = 1e-4
"""Strain over which energies are differentiated."""

FLATTEST = (-5.0, 0.0, 5.0)
"""Logarithmic stretches between which a section is flattened by fibres."""


def homogeneous_force(mode: str, strain: ArrayLike, material: Material) -> Array:
    """Nominal stress along the platen's travel in a homogeneous test.

    Parameters
    ----------
    mode : str
        `tension`, `compression`: uniaxial, all sides free of traction. `pure_shear`: planar
        tension, the width (x) kept, the thickness (y) free. `confined_compression`: no lateral
        strain. `shear`: simple shear of x over z, the height kept, the faces that are neither
        sheared nor held (y) free of traction.
    strain : (n,) array_like
        Travel over height, dimensionless; positive as the test loads, either sign allowed.
    material : Material
        Isotropic; relaxation has no part in it.

    Returns
    -------
    (n,) float64
        Force along the travel per reference area [Pa], of the sign of the strain in a solid
        that resists.

    Raises
    ------
    InputError
        If the strain leaves no height.
    ValueError
        If the mode is none of these, or the material has fibres.

    Notes
    -----
    Verified in ``tests/verification/test_homogeneous.py`` against `stress`, felupe and the
    incompressible limits. Below J = 1/2 the energy ``K/2 (J - 1)^2`` softens; where this gives
    several lateral stretches with free faces, the one that J = 1/2 to 1 holds is taken.
    """
    log_stretch, stress = _principal_state(mode, strain, material)
    if mode == "shear":
        return np.asarray((stress[:, 0] - stress[:, 2]) / (2.0 * np.cosh(log_stretch[:, 0])))
    return np.asarray(_sign(mode) * stress[:, 2] * np.exp(-log_stretch[:, 2]))


def homogeneous_normal(strain: ArrayLike, material: Material) -> Array:
    """Normal traction on the sheared face in simple shear, along z, tension positive.

    The height is kept; the faces that are neither sheared nor held (y) are free of traction, as
    in the incompressible solid of the reference, which is the limit. The inclined faces (x) get
    the traction that homogeneous deformation asks for.

    Parameters
    ----------
    strain : (n,) array_like
        Travel over height, either sign.
    material : Material
        Isotropic.

    Returns
    -------
    (n,) float64
        Force per reference area [Pa], even in the strain; negative where the platen has to push.

    References
    ----------
    C. O. Horgan, J. G. Murphy, J. Elasticity 98 (2010) 205, doi:10.1007/s10659-009-9225-7.
    """
    log_stretch, stress = _principal_state("shear", strain, material)
    square = np.exp(2.0 * log_stretch[:, 0])
    return np.asarray((stress[:, 0] + square * stress[:, 2]) / (1.0 + square))


def fibre_force(mode: str, strain: ArrayLike, fibres: Term, modulus: float) -> Array:
    """What fibres add to the nominal stress along the travel of an incompressible solid.

    Its stretches are those of the test, whatever the law; but in a pull or a push fibres flatten
    the section, which the solid resists as a neo-Hookean one. Principal directions stay.

    Parameters
    ----------
    mode, strain
        As of `homogeneous_force`; confined compression changes the volume.
    fibres : Term
        Their direction is in the frame of the sample: z along the loading axis, x along the shear.
    modulus : float
        Shear modulus of the solid [Pa].

    Returns
    -------
    (n,) float64
        Force along the travel per reference area [Pa].

    Raises
    ------
    InputError, ValueError
        As `homogeneous_force`; ValueError, too, if the term is of no direction.
    """
    strain = np.atleast_1d(np.asarray(strain, dtype=np.float64))
    ahead, behind = (_fibre_energy(mode, strain + h, fibres, modulus) for h in (STEP, -STEP))
    return np.asarray((ahead - behind) / (2.0 * STEP))


def _fibre_energy(mode: str, strain: Array, fibres: Term, modulus: float) -> Array:
    """Energy per volume (n,) [Pa] that fibres add, least over the shapes of a free section."""
    rule, (x, y, z) = fibres.rule, fibres.direction
    if not isinstance(rule, FibreLaw):
        raise ValueError(f"{fibres.law!r} is no law of fibres")
    given, free = _given(mode, strain), np.array(FREE[mode])
    log_stretch = given + (_kept_volume(given, free)[:, None] * free if any(free) else 0.0)

    def energy(flat: Array, strain: Array, *logs: Array) -> Array:
        one, two, three = np.exp(2.0 * np.stack([logs[0] + flat, logs[1] - flat, logs[2]]))
        along = one * x**2 + two * y**2 + three * z**2
        if mode == "shear":  # of x over z, in which only y is principal
            along = x**2 + two * y**2 + 2.0 * strain * x * z + (1.0 + strain**2) * z**2
        first, isochoric = one + two + three, np.exp(-2.0 / 3.0 * sum(logs))
        added, *_ = rule.slopes(isochoric * first - 3.0, isochoric * along - 1.0, fibres.shape)
        flattened = first - np.exp(2.0 * np.stack(logs)).sum(axis=0)
        return np.asarray(fibres.modulus * added + 0.5 * modulus * flattened)

    of = strain, *log_stretch.T
    both_free = free.sum() == 2.0
    return energy(find_minimum(energy, FLATTEST, args=of).x if both_free else 0.0 * strain, *of)


def principal_stretches(mode: str, strain: float, material: Material) -> Array:
    """Principal stretches (3,) of a homogeneous test at a strain, along x, y and z.

    In simple shear they lie along the principal axes in the plane of shear and, second, along y.
    """
    log_stretch, _ = _principal_state(mode, strain, material)
    return np.asarray(np.exp(log_stretch[0]))


def _sign(mode: str) -> float:
    return -1.0 if mode in COMPRESSIVE else 1.0


def _principal_state(mode: str, strain: ArrayLike, material: Material) -> tuple[Array, Array]:
    """Logarithmic principal stretches (n, 3) and principal Kirchhoff stresses (n, 3) [Pa]."""
    if not material.isotropic:
        raise ValueError("homogeneous tests are those of an isotropic solid; leave the fibres out")
    given = _given(mode, np.atleast_1d(np.asarray(strain, dtype=np.float64)))
    free = np.array(FREE[mode])
    log_stretch = given + (_free_stretch(given, free, material)[:, None] * free if any(free) else 0)
    return log_stretch, _kirchhoff(log_stretch, material)


def _given(mode: str, strain: Array) -> Array:
    """Logarithmic principal stretches (n, 3) that the strain sets, zero where it sets none."""
    if mode not in FREE:
        raise ValueError(f"mode {mode!r} is none of {', '.join(FREE)}")
    none = np.zeros_like(strain)
    if mode == "shear":
        stretch = np.arcsinh(0.5 * strain)
        return np.stack([stretch, none, -stretch], axis=1)
    if not np.all(_sign(mode) * strain > -1.0):
        worst = strain[np.argmin(_sign(mode) * strain)]
        raise InputError(
            f"strain {worst:g} in {mode} leaves no height; check height_mm and displacement_mm"
        )
    return np.stack([none, none, np.log1p(_sign(mode) * strain)], axis=1)


def _kept_volume(given: Array, free: Array) -> Array:
    """Logarithmic stretch (n,) along the `free` directions that keeps the volume."""
    return np.asarray(-given.sum(axis=1) / free.sum())


def _kirchhoff(log_stretch: NDArray, material: Material) -> NDArray:
    """Principal Kirchhoff stresses (n, 3) [Pa] of logarithmic stretches, real or complex."""
    volume = log_stretch.sum(axis=1)
    isochoric = log_stretch - volume[:, None] / 3.0
    return isotropic_response(isochoric, np.expm1(volume), material)[1]


def _free_stretch(given: Array, free: Array, material: Material) -> Array:
    """Logarithmic stretch (n,) along the `free` directions that leaves them without traction.

    Newton's iteration from J = 1, within an interval whose ends have tractions of unlike signs.
    Slopes are exact to rounding: the traction is an analytic function, taken at a complex stretch
    (W. Squire, G. Trapp, SIAM Rev. 40 (1998) 110, doi:10.1137/S003614459631241X).
    """

    def traction(y: NDArray) -> NDArray:
        return _kirchhoff(given + y[:, None] * free, material)[:, 1]

    high = np.abs(given).max(axis=1)
    halved = np.clip((np.log(0.5) - given.sum(axis=1)) / free.sum(), -high, high)
    low = np.where(traction(halved) < 0.0, halved, -high)
    y, tiny = _kept_volume(given, free), 1e-30
    for _ in range(200):
        value = traction(y + 1j * tiny)
        low, high = np.where(value.real < 0.0, y, low), np.where(value.real < 0.0, high, y)
        newton = y - value.real * tiny / value.imag
        inside = (newton >= low) & (newton <= high)
        before, y = y, np.where(inside, newton, 0.5 * (low + high))
        if np.minimum(np.abs(y - before), high - low).max() < CLOSE:
            return y
    raise ArithmeticError(f"no lateral stretch leaves the sides free at {material}")
