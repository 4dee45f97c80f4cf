"""Human brain, averages of Budday et al. 2017: four regions, tension, compression, simple shear."""

from pathlib import Path

import numpy as np
import pandas as pd

from softsample.errors import InputError
from softsample.measured.files import finite, headed, sheets
from softsample.measured.sample import KPA, Sample, cuboid, outward, record

ABOUT = (
    "Human brain of four regions (cortex CX, corona radiata CR, basal ganglia BG, corpus callosum "
    "CC) in tension, compression and simple shear on cubes of 5 mm (Budday et al. 2017, "
    "doi 10.1016/j.actbio.2016.10.036): averages over loading, unloading and specimens. "
    "Wet tissue is stated to be no compressible foam, as the authors take it (`loop: absent`)."
)
UNSTATED = (
    "scatter",
    "whether the nominal stress allows for bonded ends",
    "the other direction of shear (the published one is a mirror image)",
    "time",
)
EDGE_MM = 5.0
REGIONS = ("CX", "CR", "BG", "CC")
HEADER = 4
"""Lines above the numbers: source, region, quantity, unit."""


def read(folder: Path) -> list[Sample]:
    """Four regions in three modes.

    Raises
    ------
    InputError
        If a block of the workbook is another one, or its units are.
    """
    path = folder / "CANNsBRAINdata.xlsx"
    sheet = next(iter(sheets(path).values()))
    return [sample for region in REGIONS for sample in _region(path, sheet, region)]


def _region(path: Path, sheet: pd.DataFrame, region: str) -> list[Sample]:
    """Tension, compression and shear of a region."""
    stretch, axial = _columns(path, sheet, f"{region}-comten")
    shear, tangential = _columns(path, sheet, f"{region}-shr")
    branches = {
        "tension": outward(stretch - 1.0, axial, 1.0),
        "compression": outward(stretch - 1.0, axial, -1.0),
        "shear": outward(shear, tangential, 1.0),
    }
    shape = cuboid(EDGE_MM, EDGE_MM, EDGE_MM)
    return [
        Sample(
            f"{region}_{mode}",
            region,
            mode,
            shape,
            record(EDGE_MM * strain, KPA * EDGE_MM**2 * stress),
            specimen=region,
        )
        for mode, (strain, stress) in branches.items()
    ]


def _columns(path: Path, sheet: pd.DataFrame, title: str) -> tuple[np.ndarray, np.ndarray]:
    """Strain and stress below a title; the stress must be in kPa."""
    head = sheet.iloc[:HEADER].map(lambda cell: str(cell).strip()).to_numpy()
    at = np.flatnonzero(head[1] == title)
    if len(at) != 2 or not head[3, at[1]].startswith("[kPa"):
        raise InputError(f"{path}: no two columns headed {title!r}, the second in kPa")
    block = headed(sheet.iloc[:, at], HEADER).dropna()
    numbers = finite(path, block, list(map(str, block))).to_numpy()
    return numbers[:, 0], numbers[:, 1]
