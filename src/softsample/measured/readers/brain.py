"""Human brain, averages of Budday et al. 2017: four regions, tension, compression, simple shear."""

from pathlib import Path

import numpy as np

from softsample.errors import InputError
from softsample.measured.files import workbook_rows
from softsample.measured.measurement import Measurement, Shape, cuboid, untimed

UNSTATED = (
    "the curves are averages over loading and unloading and over specimens: scatter is not known",
    "the nominal stress is force over area of a 5 mm cube: whether glued ends were allowed for is "
    "not said, so glued (finite elements) and homogeneous are both run",
    "time: effects of time are no candidates",
)
EDGE_MM = 5.0
BLOCKS = {"CX": "AB CD", "CR": "FG HI", "BG": "KL MN", "CC": "PQ RS"}
"""Columns of each region: stretch and stress, amount of shear and shear stress."""
KPA = 1e3


def read(folder: Path) -> list[Measurement]:
    """Four regions in three modes.

    Raises
    ------
    InputError
        If a block of the workbook is another one, or its units are.
    """
    path = folder / "CANNsBRAINdata.xlsx"
    rows = workbook_rows(path)
    shape = cuboid(EDGE_MM, EDGE_MM, EDGE_MM)
    found = []
    for region, letters in BLOCKS.items():
        axial, shear = (_columns(path, rows, region, *pair) for pair in letters.split())
        stretch = axial[0] - 1.0
        for mode, (strain, stress) in {
            "tension": _branch(stretch, axial[1], 1.0),
            "compression": _branch(stretch, axial[1], -1.0),
            "shear": _branch(*shear, 1.0),
        }.items():
            found.append(_measurement(region, mode, shape, strain, stress))
    return found


def _measurement(
    region: str, mode: str, shape: Shape, strain: np.ndarray, stress: np.ndarray
) -> Measurement:
    record = untimed(shape.height * strain, KPA * shape.area * stress)
    return Measurement(f"{region}_{mode}", region, region, mode, shape, record, timed=False)


def _branch(strain: np.ndarray, stress: np.ndarray, sign: float) -> tuple[np.ndarray, np.ndarray]:
    """What lies on one side of zero, from zero outward."""
    chosen = np.flatnonzero(sign * strain >= 0.0)
    order = chosen[np.argsort(sign * strain[chosen])]
    return strain[order], stress[order]


def _columns(
    path: Path, rows: list[dict[str, str]], region: str, first: str, second: str
) -> tuple[np.ndarray, np.ndarray]:
    """Two columns of numbers below their four lines of header."""
    name, unit = rows[1].get(first, ""), rows[3].get(second, "")
    if not name.startswith(region) or not unit.startswith("[kPa"):
        raise InputError(
            f"{path}: columns {first}, {second} are headed {name!r}, {unit!r}, not region {region} "
            "in kPa"
        )
    pairs = [(row[first], row[second]) for row in rows[4:] if first in row and second in row]
    numbers = np.array(pairs, dtype=float)
    return numbers[:, 0], numbers[:, 1]
