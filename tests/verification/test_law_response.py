"""Other laws, other Poisson's ratios where no closed form is the sample's: against the solver."""

import numpy as np
import pytest

from softsample.constitutive.ogden import OgdenMaterial
from softsample.fem.boundary import ContactSettings, mode_boundary
from softsample.fem.explicit import ExplicitModel, SolverSettings
from softsample.meshing.sample import ideal_hexes, indented_hexes
from softsample.response.changes import LESS, lower_ratio
from softsample.response.curves import ResponseCurves
from softsample.response.elastic import Elastic
from softsample.response.law_response import LawResponse
from softsample.response.perturbations import EXPONENTS
from softsample.shapes import IdealShape, Indenter

DISC = IdealShape("cylinder", 20e-3, 20e-3, 10e-3)
BALL = Indenter("sphere", 4e-3)
SIZE = DISC.height / 6
TESTS = {
    "torsion": (ideal_hexes(DISC, SIZE), "bonded", 5e-3),
    "indentation": (indented_hexes(DISC, SIZE, BALL), BALL, 1.5e-3),
}
MODEL = (-8.0, 16.0)


def forces(mode, exponents):
    """Displacement [m] and forces per modulus [m2] of single terms, by the solver."""
    mesh, ends, travel = TESTS[mode]
    model = ExplicitModel(mesh, SolverSettings())
    held = mode_boundary(mesh, mode, mesh.glued(0.0), ContactSettings(), ends)
    found = {}
    for alpha in exponents:
        solid = OgdenMaterial((1e3,), (alpha,), 0.49)
        run = model.run(solid, held, travel, loading_time=0.06)
        found[alpha] = 1e-3 * run.force
    return run.displacement, found


@pytest.mark.parametrize(("mode", "close"), [("torsion", 0.01), ("indentation", 0.02)])
def test_a_law_between_runs_is_that_of_the_solver(mode, close):
    """Measured with elements of 1.25 mm, in % of the peak, exponents -14, -4, 8 and 20: torsion
    0.7, 0.3, 0.5, 0.2; a ball 1.2, 0.6, 1.1, 0.5; a flat punch 1.0, 1.0, 2.5, 0.1."""
    asked = (-4.0, 20.0)
    travel, force = forces(mode, (*MODEL, *EXPONENTS, *asked))
    ends = np.stack([force[MODEL[1]], force[MODEL[0]]])
    curves = ResponseCurves(np.array([0.0, 1.0]), travel, ends)
    runs = {alpha: force[alpha] for alpha in EXPONENTS}
    laws = LawResponse(curves, DISC, mode, MODEL, 0.49, runs=runs)
    assert not laws.knows_foams
    for alpha in asked:
        model = curves.force_per_mu(1.0, travel)
        off = model + laws.ogden_change(1.0, travel, (alpha, MODEL[1])) - force[alpha]
        assert np.abs(off).max() < close * force[alpha].max(), alpha
        assert np.abs(model - force[alpha]).max() > 0.1 * force[alpha].max(), "another law"


CUBE = IdealShape("cuboid", 10e-3, 10e-3, 10e-3)


def test_the_normal_force_of_another_poissons_ratio_is_that_of_the_solver():
    """Within 0.3 % of the peak down to 0.35, where three tenths of it are gone."""
    mesh = ideal_hexes(CUBE, 2e-3)
    model = ExplicitModel(mesh, SolverSettings())
    held = mode_boundary(mesh, "shear", mesh.glued(0.0), ContactSettings(), "bonded")

    def normal(nu):
        run = model.run(OgdenMaterial((1e3,), (8.0,), nu), held, 3e-3, loading_time=0.06)
        return run.displacement, 1e-3 * run.force_vector[:, 2]

    travel, plain = normal(0.49)
    curves = ResponseCurves(np.array([0.5]), travel, plain[None])
    changes = {lower_ratio(less): normal(0.49 - less)[1] - plain for less in LESS}
    elastic = Elastic(curves, {name: curves.like(own[None]) for name, own in changes.items()})
    for nu in (0.43, 0.35):
        change = normal(nu)[1] - plain
        found = elastic.ratio_change_per_mu(0.5, travel, nu)
        assert np.abs(found - change).max() < 0.005 * np.abs(plain).max()
        assert np.abs(change).max() > 0.1 * np.abs(plain).max()
