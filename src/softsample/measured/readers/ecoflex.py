"""Silicone phantoms in compression: 19 materials, two specimens each, five repeats."""

import re
from pathlib import Path

import numpy as np

from softsample.errors import InputError
from softsample.measured.files import lines_of, numbers
from softsample.measured.measurement import Measurement, Shape, cylinder
from softsample.records import MM, Record

UNSTATED = (
    "friction between silicone and platens: the model sticks, slip is an effect of the library",
    "time between repeats, and whether the zero of travel was set before each",
)
TIME, TRAVEL, LOAD = "Time (s)", "Compression (mm)", "Load (N)"
STRESS = "Engineering Stress (kPa)"
DISAGREEMENT = 0.01
"""Largest difference of the derived stress from load over area, as a part of its peak."""


def read(folder: Path) -> list[Measurement]:
    """All records below a folder, in the order of their names."""
    return [read_file(path) for path in sorted((folder / "data").glob("*/*.csv"))]


def read_file(path: Path) -> Measurement:
    """One record; `EF10_0T_A1.csv` is repeat 1 of specimen A of material EF10_0T.

    Raises
    ------
    InputError
        If size, units or signs are not those of the description.
    """
    lines = lines_of(path)
    starts = [k for k, line in enumerate(lines) if line.startswith(TIME)]
    if not starts:
        raise InputError(f"{path}: no line that starts with {TIME!r}; not a file of this set")
    shape = _shape(path, lines[: starts[0]])
    table = numbers(path, lines[starts[0] :], (TIME, TRAVEL, LOAD, STRESS))
    load = table[LOAD].to_numpy()
    _check_stress(path, load, table[STRESS].to_numpy(), shape)
    record = Record(table[TIME].to_numpy(), -MM * table[TRAVEL].to_numpy(), -load)
    group, specimen = path.stem.rsplit("_", 1)
    return Measurement(path.stem, group, specimen[0], "compression", shape, record)


def load_cells(folder: Path) -> dict[str, str]:
    """Capacity of each record's load cell as its header has it, `1kN` or `10kN`."""
    return {
        path.stem: _stated(path, lines_of(path), r"Load cell: *(\w+)")
        for path in sorted((folder / "data").glob("*/*.csv"))
    }


def _shape(path: Path, header: list[str]) -> Shape:
    diameter, height = (
        float(_stated(path, header, rf"Cylinder {name}: *([\d.]+) *mm"))
        for name in ("Diameter", "Height")
    )
    return cylinder(diameter, height)


def _stated(path: Path, header: list[str], pattern: str) -> str:
    found = re.search(pattern, "\n".join(header))
    if found is None:
        raise InputError(f"{path}: the header does not say {pattern!r}; not a file of this set")
    return found.group(1)


def _check_stress(path: Path, load: np.ndarray, stress: np.ndarray, shape: Shape) -> None:
    """The files hold load and stress: they agree if units and area are what we take them for."""
    apart = np.abs(1e3 * stress + load / shape.area).max() / np.abs(load / shape.area).max()
    if not apart < DISAGREEMENT:
        raise InputError(
            f"{path}: stress [kPa] and load [N] over area differ by {100 * apart:.3g} %; "
            "is a unit another one, or the area?"
        )
