"""How far prescribed displacements of the top replace contact in compression."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from softsample.arrays import Array

START = 0.01
"""Nominal strain from which on two curves are compared; forces below are next to nothing."""

TOLERANCES = (2, 5)
"""Relative differences [%] that count as agreement."""

PAPER_STRAIN = 0.15
"""Nominal strain up to which the paper takes prescribed displacements for acceptable."""


def prescribed_table(curves: Mapping[tuple[str, str], pd.DataFrame]) -> pd.DataFrame:
    """Strains of agreement and differences of the force, one row a sample and geometry.

    Parameters
    ----------
    curves
        By sample and geometry: `strain`, `contact_N`, `prescribed_N`.

    Returns
    -------
    DataFrame
        `sample`, `geometry`, `agrees_2_percent_strain`, `agrees_5_percent_strain`, and
        100 (prescribed / contact - 1) at the paper's strain (NaN beyond the end) and at
        the end, whose strain is `end_strain`.
    """
    rows = []
    for (sample, geometry), curve in curves.items():
        columns = (curve[name].to_numpy() for name in ("strain", "contact_N", "prescribed_N"))
        strain, contact, prescribed = columns
        ratio = 100.0 * (prescribed[1:] / contact[1:] - 1.0)
        rows.append(
            {
                "sample": sample,
                "geometry": geometry,
                **{
                    f"agrees_{t}_percent_strain": agreement(strain, contact, prescribed, t / 100.0)
                    for t in TOLERANCES
                },
                "paper_strain": PAPER_STRAIN,
                "at_paper_strain_percent": float(
                    np.interp(PAPER_STRAIN, strain[1:], ratio, right=np.nan)
                ),
                "end_strain": float(strain[-1]),
                "at_end_percent": float(ratio[-1]),
            }
        )
    return pd.DataFrame(rows)


def agreement(strain: Array, contact: Array, prescribed: Array, tolerance: float) -> float:
    """Nominal strain up to which the forces of both agree within `tolerance`, relative to contact.

    Parameters
    ----------
    strain : (n,) float64
        Nominal strain, ascending from zero.
    contact, prescribed : (n,) float64
        Forces [N] along the travel.
    tolerance : float
        Largest relative difference.

    Returns
    -------
    float
        Interpolated between points; 0 if they differ from the start, the last strain if they
        never do.
    """
    seen = strain >= START
    strain = strain[seen]
    excess = np.abs(prescribed[seen] / contact[seen] - 1.0) - tolerance
    apart = np.flatnonzero(excess > 0.0)
    if len(apart) == 0:
        return float(strain[-1])
    first = int(apart[0])
    if first == 0:
        return 0.0
    share = excess[first - 1] / (excess[first - 1] - excess[first])
    return float(strain[first - 1] + share * (strain[first] - strain[first - 1]))
