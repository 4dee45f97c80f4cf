"""Changes of the model, simulated at one modulus fraction, at all others."""

import numpy as np
import pandas as pd
import pytest

import laboratory
from softsample.loop.effects.base import SOLID
from softsample.response.changes import (
    PRESSED,
    PRESSED_ELSEWHERE,
    elsewhere,
    for_all_fractions,
)
from softsample.response.curves import ResponseCurves
from softsample.response.elastic import Elastic, Tables

THERE = 0.6
ANOTHER = 0.85


@pytest.fixture(scope="module")
def curves():
    return laboratory.elastic("compression").curves


def carried(curves, change, name="poisson_0.02_less"):
    """Change at another modulus fraction than that at which it was simulated."""
    return for_all_fractions({name: change}, curves, THERE)[name].curve(ANOTHER)


def along(curves):
    return curves.displacement / curves.displacement[-1]


def test_a_change_that_is_a_part_of_the_force_stays_that_part(curves):
    part = -0.05 - 0.2 * along(curves) ** 2
    there, another = curves.curve(THERE), curves.curve(ANOTHER)
    np.testing.assert_allclose(
        carried(curves, part * there), part * another, atol=1e-9 * another.max()
    )
    assert np.abs(part * (another - there)).max() > 0.05 * np.abs(part * there).max()


def test_fibres_stay_beside_the_solid(curves):
    change = 0.1 * curves.curve(THERE)
    found = carried(curves, change, "fibres_z")
    np.testing.assert_allclose(found, change, atol=1e-9 * change.max())


def test_shear_of_a_compressed_sample_is_linear_in_the_fraction(curves):
    """From its parts of the force at two modulus fractions, as they were simulated."""
    other = elsewhere(THERE)
    parts = {PRESSED: (THERE, -0.03), PRESSED_ELSEWHERE: (other, -0.07)}
    changes = {name: part * curves.curve(r) for name, (r, part) in parts.items()}
    found = for_all_fractions(changes, curves, THERE)
    assert set(found) == {PRESSED}
    expected = -0.03 + (ANOTHER - THERE) / (other - THERE) * -0.04
    force = curves.curve(ANOTHER)
    np.testing.assert_allclose(
        found[PRESSED].curve(ANOTHER), expected * force, atol=1e-6 * force.max()
    )


def test_a_curve_bends_on_beyond_its_end(curves):
    """As a parabola does; straight on would be off by more than a thousandth."""
    travel = curves.displacement
    bent = ResponseCurves(np.array([0.5]), travel, (3.0 * travel + 400.0 * travel**2)[None])
    beyond = 1.1 * travel[-1]
    np.testing.assert_allclose(
        Elastic(bent).force_per_mu(0.5, np.array([beyond])),
        3.0 * beyond + 400.0 * beyond**2,
        rtol=1e-4,
    )


def test_the_grain_of_the_mesh_is_smoothed_away(curves):
    """A force that jumps by 2 % whenever a node meets the platen, as on a mesh of 1 mm."""
    smooth = -0.2 * along(curves) ** 2 * curves.curve(THERE)
    grain = 0.02 * curves.curve(THERE) * np.random.default_rng(4).choice([-1, 1], len(smooth))
    left = for_all_fractions({"x": smooth + grain}, curves, THERE)["x"].curve(THERE) - smooth
    assert np.linalg.norm(left) < 0.35 * np.linalg.norm(grain)


def test_two_responses_differ_at_every_fraction(curves):
    travel = np.linspace(0.0, 1.2 * curves.displacement[-1], 301)
    softer = ResponseCurves(
        curves.fractions,
        travel,
        np.stack([0.8 * np.interp(travel, curves.displacement, curves.curve(r)) for r in
                  curves.fractions]),
    )  # fmt: skip
    less = softer.minus(curves)
    np.testing.assert_allclose(
        less.curve(THERE), -0.2 * curves.curve(THERE), atol=2e-3 * curves.curve(THERE).max()
    )
    elastic = Elastic(curves, {"real_geometry": less}, contact=True)
    there = np.array([0.5, 1.0]) * curves.displacement[-1]
    for r in (THERE, ANOTHER):
        np.testing.assert_allclose(
            elastic.change_per_mu("real_geometry", r, there),
            -0.2 * curves.force_per_mu(r, there),
            rtol=5e-3,
        )


@pytest.mark.parametrize(("mode", "left"), [("compression", 0.75), ("tension", 1.0)])
def test_curves_in_compression_lose_their_roughness_and_nothing_else(mode, left):
    """With it, a fit has a false minimum wherever points of a curve are good by chance."""
    travel = np.linspace(0.0, 3.0, 61)
    sign = -1.0 if mode == "compression" else 1.0
    rough = 1.0 + 1e-3 * np.random.default_rng(5).standard_normal(61)
    smooth = {r: (1.0 + r) * 40.0 * travel**1.7 for r in (0.2, 0.5, 0.8)}

    def table(factor):
        return pd.concat([
            pd.DataFrame({"mu1_fraction": r, "displacement_mm": sign * travel,
                          "force_per_mu_mm2": sign * factor * curve})
            for r, curve in smooth.items()
        ])  # fmt: skip

    plain, made = (
        Elastic.of_tables(mode, Tables(table(factor), [], SOLID, table(2.0 * factor)))
        for factor in (np.ones(61), rough)
    )
    exact = 1e-6 * smooth[0.5]
    assert np.abs(plain.curves.curve(0.5) - exact).max() < 2e-4 * exact[-1]
    assert made.curves.curve(0.5)[0] == pytest.approx(0.0, abs=1e-9 * exact[-1])
    off = np.linalg.norm(made.curves.curve(0.5) - exact) / np.linalg.norm(exact * (rough - 1.0))
    assert off == pytest.approx(left, abs=0.25)
    assert (made.curves.grain[0] < 1e-2 * exact[-1] * 1e-3) == (mode == "compression")
    turned = made.perturbations["real_geometry"].curve(0.5) - made.curves.curve(0.5)
    assert np.abs(turned).max() < 1e-9 * exact[-1]
