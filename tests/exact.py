"""Records of homogeneous tests by formulas of their own: compressible Ogden, sides free."""

import numpy as np
from scipy.optimize import brentq

MU, ALPHA, NU = (600.0, 300.0), (-8.0, 16.0), 0.49  # Pa, 1, 1
MODULUS = sum(MU)
BULK = 2.0 * MODULUS * (1.0 + NU) / (3.0 * (1.0 - 2.0 * NU))


def principal_kirchhoff(stretches):
    """Principal Kirchhoff stresses (3,) [Pa] of principal stretches (3,)."""
    volume = np.prod(stretches)
    isochoric = np.asarray(stretches) * volume ** (-1.0 / 3.0)
    stress = np.full(3, BULK * (volume - 1.0) * volume)
    for mu, alpha in zip(MU, ALPHA, strict=True):
        power = isochoric**alpha
        stress += 2.0 * mu / alpha * (power - power.mean())
    return stress


def uniaxial_stress(stretch):
    """Nominal stress [Pa] of a stretch, sides free."""
    side = brentq(lambda s: principal_kirchhoff((s, s, stretch))[0], 0.5, 2.0, xtol=1e-14)
    return principal_kirchhoff((side, side, stretch))[2] / stretch


def uniaxial_record(area_mm2, height_mm, strain, cycles=1, seed=0):
    """Time [s], displacement [mm], force [N] of a rest and cycles to a strain, both signs alike."""
    corners = [0.0, 2.0] + [2.0 + 10.0 * (k + 1) for k in range(2 * cycles - 1)]
    heights = [0.0, 0.0] + [strain * ((k + 1) % 2) for k in range(2 * cycles - 1)]
    time = np.round(np.arange(0.0, corners[-1], 0.1), 2)
    stretch = 1.0 + np.interp(time, corners, heights)
    grid = np.linspace(min(0.0, strain), max(0.0, strain), 60) + 1.0
    stress = np.interp(stretch, grid, [uniaxial_stress(x) for x in grid])
    noise = np.random.default_rng(seed).normal(size=(2, len(time)))
    force = 1e-6 * area_mm2 * stress
    return time, height_mm * (stretch - 1.0) + 1e-3 * noise[0], force + 2e-4 * noise[1]


def linear_modulus(mode, material):
    """Slope [Pa] of a homogeneous test at no strain, from linear elasticity."""
    mu, bulk = material.shear_modulus, material.bulk_modulus
    nu = (3.0 * bulk - 2.0 * mu) / (6.0 * bulk + 2.0 * mu)
    return {
        "tension": 2.0 * mu * (1.0 + nu),
        "compression": 2.0 * mu * (1.0 + nu),
        "shear": mu,
        "pure_shear": 2.0 * mu / (1.0 - nu),
        "confined_compression": 2.0 * mu * (1.0 - nu) / (1.0 - 2.0 * nu),
    }[mode]


def incompressible_stress(mode, strain, terms):
    """Nominal stress of an incompressible Ogden solid, terms of a modulus and an exponent."""
    if mode == "shear":
        stretch = 0.5 * strain + np.sqrt(1.0 + 0.25 * strain**2)
        total = sum(2.0 * m / a * (stretch**a - stretch**-a) for m, a in terms)
        return total / (stretch + 1.0 / stretch)
    sign = 1.0 if mode == "tension" else -1.0
    stretch = 1.0 + sign * strain
    power = (2.0 * m / a * (stretch ** (a - 1.0) - stretch ** (-0.5 * a - 1.0)) for m, a in terms)
    return sign * sum(power)
