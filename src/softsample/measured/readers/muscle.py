"""Porcine muscle, ramp and hold along and across the fibres: three speeds, three magnitudes."""

from pathlib import Path

import pandas as pd

from softsample.errors import InputError
from softsample.measured.files import finite, headed, sheets
from softsample.measured.sample import KPA, Sample, cuboid, record

ABOUT = (
    "Porcine skeletal muscle compressed along and across the fibres and held for 300 s, at 0.5, 1 "
    "and 5 % per s to 30 %, and at 1 % per s to 10, 20 and 30 %; averages, digitised by the "
    "authors of doi 10.1016/j.jmbbm.2023.106021 from earlier publications."
)
UNSTATED = (
    "size of the specimens (forces are those of a cube of 10 mm)",
    "scatter",
    "kind of stress in some sheets (taken as Cauchy stress; force per first area is that over the "
    "stretch)",
    "friction (ends are taken as sliding, as a homogeneous stress is stated)",
)
EDGE_MM = 10.0
DIRECTIONS = {"F": "along", "XF": "across"}
"""Group by the first part of a sheet's name."""
TIMES, STRESSES, STRETCH = ("t-s", "t", "x"), ("Cauchy-kPa", "y"), "str"
"""Titles of a column, the one that counts first."""


def read_rate(folder: Path) -> list[Sample]:
    """Curves at three speeds: `along_005` is at 0.5 % per s along the fibres."""
    return _read(folder / "muscle_rate_vals.xls")


def read_magnitude(folder: Path) -> list[Sample]:
    """Curves to three magnitudes: `across_20` goes to 20 % across the fibres."""
    return _read(folder / "muscle_mag_vals.xls")


def _read(path: Path) -> list[Sample]:
    return [_sample(path, name, sheet) for name, sheet in sheets(path).items()]


def _sample(path: Path, name: str, sheet: pd.DataFrame) -> Sample:
    """One curve; refuses columns, signs and stretches that are not those of compression."""
    fibres, _, which = name.partition("_")
    table = headed(sheet)
    titles = [next((t for t in known if t in table), known[-1]) for known in (TIMES, STRESSES)]
    time, cauchy, stretch = finite(path, table, [*titles, STRETCH]).to_numpy().T
    if fibres not in DIRECTIONS or stretch.max() > 1.0 or not stretch.min() > 0.5:
        raise InputError(f"{path}, sheet {name!r}: not a compression along or across the fibres")
    if not cauchy[stretch.argmin()] < 0.0:
        raise InputError(f"{path}, sheet {name!r}: the stress is not negative in compression")
    group = DIRECTIONS[fibres]
    force = KPA * EDGE_MM**2 * cauchy / stretch
    return Sample(
        f"{group}_{which}",
        group,
        "compression",
        cuboid(EDGE_MM, EDGE_MM, EDGE_MM),
        record(EDGE_MM * (stretch - 1.0), force, time_s=time),
    )
