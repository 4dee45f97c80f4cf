"""Bonded discs: apparent over Young's modulus against an axisymmetric Ritz solution."""

import pytest

import modes


@pytest.mark.parametrize(("radius_over_height", "poisson_ratio"), modes.RITZ)
def test_a_bonded_disc_is_as_stiff_as_ritz_says(radius_over_height, poisson_ratio):
    """Measured: 0.3, 0.4, 0.6 and 0.8 % above it with 8 elements along the height, 0.05 % at most
    with 12."""
    apart = 0.005 if radius_over_height == 1.0 else 0.015
    ritz = modes.RITZ[radius_over_height, poisson_ratio]
    assert modes.disc(radius_over_height, poisson_ratio) == pytest.approx(ritz, rel=apart)
