"""Contact with the moving platen in compression: real sample and cuboid."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

STRAIN_STEP = 0.025
"""Nominal strain between the rows of the table."""


def contact_share(contact: pd.DataFrame, cuboid: Mapping[str, float]) -> pd.DataFrame:
    """Contact area of one run, referred to the idealised shape.

    Parameters
    ----------
    contact
        `displacement_mm` and `contact_area_m2` along the run at the calibrated moduli.
    cuboid
        `ideal_area_mm2`, `height_mm`.

    Returns
    -------
    DataFrame
        `strain`: travel over the ideal height; `share_percent`: contact area over the ideal area.
    """
    area = 1e6 * contact["contact_area_m2"] / cuboid["ideal_area_mm2"]
    strain = contact["displacement_mm"].abs() / cuboid["height_mm"]
    return pd.DataFrame({"strain": strain, "share_percent": 100.0 * area})


def contact_table(shares: Mapping[tuple[str, str], pd.DataFrame]) -> pd.DataFrame:
    """Mean contact area over samples on even strains, up to the smallest largest one.

    Parameters
    ----------
    shares
        `contact_share` by sample and geometry.

    Returns
    -------
    DataFrame
        `strain`, and for each geometry `{geometry}_percent` with `{geometry}_sd_percent` (n - 1;
        empty for a single sample), percent of the ideal area.
    """
    first = max(curve["strain"].iloc[0] for curve in shares.values())
    last = min(curve["strain"].iloc[-1] for curve in shares.values())
    steps = np.arange(np.ceil(first / STRAIN_STEP), np.floor(last / STRAIN_STEP + 1e-9) + 1.0)
    at = STRAIN_STEP * steps
    table = pd.DataFrame({"strain": at})
    for geometry in dict.fromkeys(geometry for _, geometry in shares):
        curves = [curve for (_, name), curve in shares.items() if name == geometry]
        values = np.array([np.interp(at, c["strain"], c["share_percent"]) for c in curves])
        spread = values.std(axis=0, ddof=1) if len(values) > 1 else np.nan
        table[f"{geometry}_percent"] = values.mean(axis=0)
        table[f"{geometry}_sd_percent"] = spread
    return table
