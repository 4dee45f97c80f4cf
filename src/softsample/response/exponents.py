"""A sample's curves for free exponents: runs of unit modulus on a grid of fractions and exponents.

Real exponents take the solver's path by eigenvalues.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd

from softsample.arrays import Array
from softsample.constitutive.ogden import unit_modulus
from softsample.errors import InputError
from softsample.fem.boundary import Boundary
from softsample.fem.explicit import ExplicitModel
from softsample.protocol import travel_sign
from softsample.response.unit import Progress, ResponseSettings, modulus_fractions, unit_runs


@dataclass(frozen=True)
class ExponentSettings:
    """Range of the free exponents and the grid in it; mirrors config `exponents:`.

    Parameters
    ----------
    alpha1, alpha2 : (low, high)
        Bounds of the exponents.
    nodes : int
        Chebyshev-Lobatto points of each exponent.
    fractions : int
        Number of fractions mu1 / mu.
    """

    alpha1: tuple[float, float] = (-18.0, -2.0)
    alpha2: tuple[float, float] = (4.0, 26.0)
    nodes: int = 5
    fractions: int = 6


def exponent_grid(settings: ExponentSettings, alpha: Sequence[float]) -> dict[str, Array]:
    """Nodes of `mu1_fraction`, `alpha1` and `alpha2`, ascending.

    Raises
    ------
    InputError
        If an exponent of the study, `alpha`, at which the finer mesh is known, lies outside.
    """
    ranges = {"alpha1": settings.alpha1, "alpha2": settings.alpha2}
    for k, ((name, (low, high)), exponent) in enumerate(zip(ranges.items(), alpha, strict=True)):
        if not low <= exponent <= high:
            raise InputError(
                f"material.alpha.{k}: {exponent:g} is outside exponents.{name}, {low:g} to "
                f"{high:g}; free exponents set out from those of the study, so widen the range"
            )
    unit = -np.cos(np.pi * np.arange(settings.nodes) / (settings.nodes - 1))
    return {
        "mu1_fraction": modulus_fractions(ResponseSettings(settings.fractions)),
        **{
            name: 0.5 * (low + high) + 0.5 * (high - low) * unit
            for name, (low, high) in ranges.items()
        },
    }


def simulate_exponents(
    model: ExplicitModel,
    boundary: Boundary,
    travel: float,
    grid: Mapping[str, Array],
    poisson_ratio: float,
    loading_time: float,
    progress: Progress | None = None,
) -> dict[str, Array]:
    """Force per modulus against displacement at every point of a grid of `exponent_grid`.

    Returns
    -------
    dict of (n_runs * n_points,) float64
        The columns of the grid, `displacement` [m] along the travel, `force` per modulus [m2].
    """
    modulus = model.settings.reference_modulus_pa
    points = list(product(*grid.values()))
    solids = [
        unit_modulus(fraction, list(map(float, alpha)), poisson_ratio, modulus)
        for fraction, *alpha in points
    ]
    runs = unit_runs(model, boundary, travel, solids, loading_time, progress)
    rows = []
    for place, (run, _) in zip(points, runs, strict=True):
        columns = [np.broadcast_to(place, (len(run.force), 3)), run.displacement]
        rows.append(np.column_stack([*columns, run.force / modulus]))
    names = (*grid, "displacement", "force")
    return dict(zip(names, np.concatenate(rows).T, strict=True))


def curves_table(curves: Mapping[str, Array], mode: str) -> pd.DataFrame:
    """`simulate_exponents` in the signs of a mode.

    Columns `mu1_fraction`, `alpha1`, `alpha2`, `displacement_mm`, `force_per_mu_mm2`.
    """
    sign = travel_sign(mode)
    return pd.DataFrame(
        {
            **{name: curves[name] for name in ("mu1_fraction", "alpha1", "alpha2")},
            "displacement_mm": sign * 1e3 * curves["displacement"],
            "force_per_mu_mm2": sign * 1e6 * curves["force"],
        }
    )
