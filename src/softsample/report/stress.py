"""Nominal stress against nominal strain, averaged over the samples of a loading mode."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd

from softsample.arrays import Array


def nominal_curve(
    displacement: Array, force: Array, cuboid: Mapping[str, float]
) -> tuple[Array, Array]:
    """Nominal strain and stress of a test, referred to the idealised shape.

    Parameters
    ----------
    displacement, force : (n,) float64
        Travel of the platen [m] and its force [N] along the travel.
    cuboid : mapping
        `ideal_area_mm2`, `height_mm`.

    Returns
    -------
    strain, stress : (n,) float64
        Travel over height, dimensionless, ascending; force over area [Pa].
    """
    order = np.argsort(displacement, kind="stable")
    height, area = 1e-3 * cuboid["height_mm"], 1e-6 * cuboid["ideal_area_mm2"]
    return displacement[order] / height, force[order] / area


def mean_curve(curves: Sequence[tuple[Array, Array]], points: int = 101) -> pd.DataFrame:
    """Mean and standard deviation of several curves, up to the smallest largest strain.

    Parameters
    ----------
    curves
        Strain (ascending) and stress [Pa] of each sample.
    points
        Number of strains, evenly spaced from zero.

    Returns
    -------
    DataFrame
        `strain`, `mean_stress_pa`, `sd_stress_pa` (n - 1 in the denominator; NaN for a single
        curve), `count`.
    """
    strain = np.linspace(0.0, min(s[-1] for s, _ in curves), points)
    stress = np.array([np.interp(strain, s, p) for s, p in curves])
    single = len(curves) == 1
    return pd.DataFrame(
        {
            "strain": strain,
            "mean_stress_pa": stress.mean(axis=0),
            "sd_stress_pa": np.full(points, np.nan) if single else stress.std(axis=0, ddof=1),
            "count": len(curves),
        }
    )


def stress_strain_table(curves: Iterable[tuple[str, Array, Array]]) -> pd.DataFrame:
    """Mean curves of all modes in one long table.

    Parameters
    ----------
    curves
        Mode, strain and stress [Pa] of each sample, positive along the travel, so that
        compression compares with tension.
    """
    by_mode: dict[str, list[tuple[Array, Array]]] = {}
    for mode, strain, stress in curves:
        by_mode.setdefault(mode, []).append((strain, stress))
    tables = [mean_curve(members).assign(mode=mode) for mode, members in by_mode.items()]
    columns = ["mode", "strain", "mean_stress_pa", "sd_stress_pa", "count"]
    return pd.concat(tables, ignore_index=True)[columns]
