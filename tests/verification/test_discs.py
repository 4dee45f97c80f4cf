"""Bonded discs: apparent over Young's modulus against an axisymmetric Ritz solution."""

import numpy as np
import pytest

from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.sample import ideal_hexes
from softsample.shapes import IdealShape

HEIGHT, STRAIN, MU, ACROSS = 4e-3, 2e-3, 1000.0, 8
"""Height [m], strain, shear modulus [Pa], elements along the height."""


@pytest.mark.parametrize(
    ("radius_over_height", "poisson_ratio", "ritz", "apart"),
    [
        (1.0, 0.49, 1.5075, 0.005),
        (1.0, 0.499, 1.5455, 0.005),
        (2.5, 0.49, 3.3753, 0.015),
        (2.5, 0.499, 3.9706, 0.015),
    ],
)  # fmt: skip
def test_a_bonded_disc_is_as_stiff_as_ritz_says(radius_over_height, poisson_ratio, ritz, apart):
    """12 x 12 functions, an upper bound. Measured here: 0.3, 0.4, 0.6 and 0.8 % above it with 8
    elements along the height, 0.05 % at most with 12."""
    radius = radius_over_height * HEIGHT
    shape = IdealShape("cylinder", 2.0 * radius, 2.0 * radius, HEIGHT)
    mesh = ideal_hexes(shape, HEIGHT / ACROSS)
    boundary = mode_boundary(mesh, "tension", mesh.glued(0.0), ContactSettings())
    material = OgdenMaterial((MU,), (2.0,), poisson_ratio)
    model = ExplicitModel(mesh, SolverSettings(curve_points=4))
    run = model.run(material, boundary, STRAIN * HEIGHT, loading_time=0.2)
    apparent = run.force[-1] / (np.pi * radius**2 * STRAIN)
    assert apparent / (2.0 * MU * (1.0 + poisson_ratio)) == pytest.approx(ritz, rel=apart)
