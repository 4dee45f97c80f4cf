"""Blood clots in simple shear both ways: nine conditions of three clots, shear and normal force."""

from pathlib import Path

import numpy as np

from softsample.errors import InputError
from softsample.measured.files import lines_of, numbers
from softsample.measured.measurement import Measurement, cuboid, untimed

UNSTATED = (
    "edge of the cubes (about 10 mm in the authors' papers): another one scales the modulus only",
    "which strain: taken as the amount of shear, travel over height",
    "how the clots were held: glued faces (finite elements) or homogeneous shear, both are run",
    "sign of the normal force: taken as tension positive; it is an even function of the strain",
    "time: the files are resampled, so effects of time are no candidates",
    "the zeros of both channels: the two ways are averaged (odd part of the shear force, even part "
    "of the normal force), which takes an offset out",
)
EDGE_MM = 10.0
LARGEST_FORCE = 1.0
"""Beyond this [N] the column is not in N."""


def read(folder: Path) -> list[Measurement]:
    """All clots; `C10_T60_x.csv` is clot x of condition C10_T60."""
    files = sorted((folder / "ExperimentalBloodClotData").glob("*.csv"))
    return [read_file(path) for path in files]


def read_file(path: Path) -> Measurement:
    """One clot: odd part of the shear force and even part of the normal force, from zero on.

    Raises
    ------
    InputError
        If the columns are others, the forces too large for N, or the signs are not those of shear.
    """
    table = numbers(path, lines_of(path), ("Strain", "Fx", "Fz"))
    strain, shear, normal = (table[name].to_numpy() for name in ("Strain", "Fx", "Fz"))
    if max(np.abs(shear).max(), np.abs(normal).max()) > LARGEST_FORCE:
        raise InputError(f"{path}: a force is above {LARGEST_FORCE:g} N; is the file in mN?")
    if not np.all(np.diff(strain) > 0.0) or strain[0] * strain[-1] >= 0.0:
        raise InputError(f"{path}: strain does not rise from below to above zero")
    grid = np.linspace(0.0, min(-strain[0], strain[-1]), len(strain) // 2 + 1)
    odd = 0.5 * (np.interp(grid, strain, shear) - np.interp(-grid, strain, shear))
    even = 0.5 * (np.interp(grid, strain, normal) + np.interp(-grid, strain, normal))
    if odd[-1] <= 0.0:
        raise InputError(f"{path}: Fx falls with the strain; its sign is not that of shear")
    group, specimen = path.stem.rsplit("_", 1)
    shape = cuboid(EDGE_MM, EDGE_MM, EDGE_MM)
    record = untimed(shape.height * grid, odd, even - even[0])
    return Measurement(path.stem, group, specimen, "shear", shape, record, timed=False)
