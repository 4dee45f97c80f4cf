"""Mycelium plugs in two cycles of compression across the sheet, at two speeds."""

import re
from pathlib import Path

import numpy as np
import pandas as pd

from softsample.errors import InputError
from softsample.measured.files import check_stress, finite, headed, sheets
from softsample.measured.sample import Sample, cylinder, record

ABOUT = (
    "Plugs of mycelium (fungi steak) of 8 mm diameter between sandblasted parallel plates, "
    "compressed across the sheet to half of their height and released, twice, at 0.025 /s "
    "(slowest) and 0.0025 /s (slowestslow), ten plugs each (Vervenne et al. 2025, "
    "doi 10.1016/j.actbio.2025.07.002)."
)
UNSTATED = (
    "height of the plugs (taken as the first gap, at which the plates already touch)",
    "time between the four segments (taken as none)",
    "slip on the plates (ends are taken as bonded)",
    "forces are read, since the column of normal stress is twice the force over the area",
)
DIAMETER_MM = 8.0
SEGMENTS = tuple(f"Axial - {k}" for k in (1, 2, 3, 4))
"""Sheets: loading, release, loading, release."""
TIME, STRESS, FORCE, GAP = "Step time s", "Normal stress Pa", "Axial force N", "Gap µm"
AREA = 0.25e-6 * np.pi * DIAMETER_MM**2
"""Of the plugs [m2]."""


def read(folder: Path) -> list[Sample]:
    """All plugs, speed by speed."""
    return sorted(
        (read_file(path) for path in folder.glob("double-compression-*.xls")),
        key=lambda sample: (sample.group, int(sample.name.rsplit("_", 1)[1])),
    )


def read_file(path: Path) -> Sample:
    """One plug; `double-compression-slowest-outplane-3.xls` is `slowest_3`.

    Raises
    ------
    InputError
        If name, sheets, units, size or signs are not those of the description.
    """
    named = re.fullmatch(r"double-compression-(\w+)-outplane-(\d+)", path.stem)
    book = sheets(path)
    if named is None or not set(SEGMENTS) <= set(book):
        raise InputError(f"{path}: not a double compression with the sheets {', '.join(SEGMENTS)}")
    table = _joined([_segment(path, book[name]) for name in SEGMENTS])
    _check(path, table)
    group, number = named.groups()
    gap = 1e-3 * table[GAP]
    return Sample(
        f"{group}_{number}",
        group,
        "compression",
        cylinder(DIAMETER_MM, float(gap[0])),
        record(gap - gap[0], -table[FORCE], time_s=table[TIME]),
        cycle="first",
    )


def _segment(path: Path, sheet: pd.DataFrame) -> pd.DataFrame:
    """Columns of a sheet below its title, their names and their units."""
    return finite(path, headed(sheet.iloc[1:], rows=2), (TIME, STRESS, FORCE, GAP))


def _joined(segments: list[pd.DataFrame]) -> pd.DataFrame:
    """Segments one after the other, on one clock."""
    ends = np.cumsum([0.0, *(segment[TIME].iloc[-1] for segment in segments[:-1])])
    shifted = (s.assign(**{TIME: s[TIME] + end}) for s, end in zip(segments, ends, strict=True))
    return pd.concat(shifted, ignore_index=True)


def _check(path: Path, table: pd.DataFrame) -> None:
    """Stress and force agree if units and area are what we take them for; the plates press.

    The rheometer's normal stress is the first normal stress difference of a cone, ``2 F / A``.
    """
    check_stress(
        path,
        table[STRESS],
        2.0 * table[FORCE] / AREA,
        "stress [Pa] and twice the force [N] over area differ by {:.3g} %; is a unit another one, "
        "or the diameter?",
    )
    if not table[FORCE].iloc[int(table[GAP].argmin())] > 0.0:
        raise InputError(f"{path}: the force is not positive at the smallest gap")
