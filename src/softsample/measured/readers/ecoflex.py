"""Silicone phantoms in compression: 19 materials, two specimens each, five repeats."""

import re
from pathlib import Path

import numpy as np

from softsample.errors import InputError
from softsample.measured.files import check_stress, lines_of, numbers
from softsample.measured.sample import Sample, cylinder, record

ABOUT = (
    "Silicone tissue phantoms of 19 materials, cylinders of 50 mm x 30 mm, compressed at 10 mm/min "
    "by two thirds of their height; two specimens of each material, five repeats of each. Instron "
    "5900 with a load cell of 1 or 10 kN."
)
UNSTATED = (
    "friction between silicone and platens",
    "time between repeats, and whether the zero of displacement was set before each",
)
TIME, TRAVEL, LOAD = "Time (s)", "Compression (mm)", "Load (N)"
STRESS = "Engineering Stress (kPa)"


def read(folder: Path) -> list[Sample]:
    """All records below a folder, in the order of their names."""
    return [read_file(path) for path in sorted((folder / "data").glob("*/*.csv"))]


def read_file(path: Path) -> Sample:
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
    diameter, height = (
        _stated_mm(path, lines[: starts[0]], name) for name in ("Diameter", "Height")
    )
    table = numbers(path, lines[starts[0] :], (TIME, TRAVEL, LOAD, STRESS))
    check_stress(
        path,
        table[STRESS],
        -1e3 * table[LOAD] / (0.25 * np.pi * diameter**2),
        "stress [kPa] and load [N] over area differ by {:.3g} %; "
        "is a unit another one, or the area?",
    )
    group, repeat = path.stem.rsplit("_", 1)
    return Sample(
        path.stem,
        group,
        "compression",
        cylinder(diameter, height),
        record(-table[TRAVEL], -table[LOAD], time_s=table[TIME]),
        specimen=f"{group}_{repeat[0]}",
    )


def _stated_mm(path: Path, header: list[str], name: str) -> float:
    found = re.search(rf"Cylinder {name}: *([\d.]+) *mm", "\n".join(header))
    if found is None:
        raise InputError(f"{path}: the header states no {name} in mm; not a file of this set")
    return float(found.group(1))
