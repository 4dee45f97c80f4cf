"""A sample's curves for free exponents: runs of unit modulus on a grid of mixtures and exponents.

Real exponents take the solver's path by eigenvalues.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.ogden import unit_modulus
from softsample.errors import InputError
from softsample.fem.boundary import Boundary
from softsample.fem.explicit import ExplicitModel
from softsample.fem.family import FamilySettings, family_fractions

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ExponentSettings:
    """Range of the free exponents and the grid in it; mirrors config `exponents:`.

    Parameters
    ----------
    alpha1, alpha2 : (low, high)
        Bounds of the exponents.
    nodes : int
        Chebyshev-Lobatto points of each exponent.
    mixtures : int
        Number of mixtures mu1 / mu.
    """

    alpha1: tuple[float, float] = (-18.0, -2.0)
    alpha2: tuple[float, float] = (4.0, 26.0)
    nodes: int = 5
    mixtures: int = 5


def exponent_grid(
    settings: ExponentSettings, family: FamilySettings, alpha: Sequence[float]
) -> dict[str, Array]:
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
    mixtures = FamilySettings(family.mu1_fraction_min, family.mu1_fraction_max, settings.mixtures)
    return {
        "mu1_fraction": family_fractions(mixtures),
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
    progress: Callable[[str, float], None] | None = None,
) -> dict[str, Array]:
    """Force per modulus against displacement at every point of a grid of `exponent_grid`.

    Returns
    -------
    dict of (n_runs * n_points,) float64
        The columns of the grid, `displacement` [m] along the travel, `force` per modulus [m2].
    """
    modulus = model.settings.reference_modulus_pa
    points = list(product(*grid.values()))
    rows = []
    for done, (fraction, *exponents) in enumerate(points):
        alpha = [float(exponent) for exponent in exponents]
        if progress:
            progress(f"mu1/mu {fraction:.2f}, exponents {alpha}", done / len(points))
        run = model.run(
            unit_modulus(fraction, alpha, poisson_ratio, modulus),
            boundary,
            travel,
            loading_time=loading_time,
        )
        place = np.broadcast_to((fraction, *alpha), (len(run.force), 3))
        rows.append(np.column_stack([place, run.displacement, run.force / modulus]))
    names = (*grid, "displacement", "force")
    return dict(zip(names, np.concatenate(rows).T, strict=True))
