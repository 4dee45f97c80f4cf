"""Blood clots in simple shear both ways: nine conditions of three clots, shear and normal force."""

from pathlib import Path

import numpy as np

from softsample.errors import InputError
from softsample.measured.files import lines_of, numbers
from softsample.measured.sample import Sample, cuboid, record

ABOUT = (
    "Blood clots of nine conditions (C10 to C40 and T60 to T120 in their names), three of each, in "
    "simple shear to half of their height either way, with shear and normal force."
)
UNSTATED = (
    "edge of the cubes (about 10 mm in the authors' papers), which scales the modulus only",
    "strain (taken as the amount of shear)",
    "how the clots were held",
    "sign of the normal force (taken as tension positive)",
    "time (the files are resampled over strain)",
)
EDGE_MM = 10.0
LARGEST_FORCE = 1.0
"""Beyond this [N] the column is not in N."""


def read(folder: Path) -> list[Sample]:
    """All clots; `C10_T60_x.csv` is clot x of condition C10_T60."""
    files = sorted((folder / "ExperimentalBloodClotData").glob("*.csv"))
    return [read_file(path) for path in files]


def read_file(path: Path) -> Sample:
    """One clot, both directions and both channels in the order of the file.

    Raises
    ------
    InputError
        If the columns are others, the forces too large for N, or the signs are not those of shear.
    """
    table = numbers(path, lines_of(path), ("Strain", "Fx", "Fz"))
    strain, shear, normal = (table[name].to_numpy() for name in table)
    check_shear(path, strain, shear)
    if max(np.abs(shear).max(), np.abs(normal).max()) > LARGEST_FORCE:
        raise InputError(f"{path}: a force is above {LARGEST_FORCE:g} N; is the file in mN?")
    return Sample(
        path.stem,
        path.stem.rsplit("_", 1)[0],
        "shear",
        cuboid(EDGE_MM, EDGE_MM, EDGE_MM),
        record(EDGE_MM * strain, shear, force_normal_N=normal),
    )


def check_shear(path: Path, strain: np.ndarray, force: np.ndarray) -> None:
    """Refuse a sweep that does not rise through zero, or a force that falls with the strain.

    Parameters
    ----------
    path
        Of the file, for the message.
    strain, force : (n,) float64
        Amount of shear, or nominal strain, and the force along it.

    Raises
    ------
    InputError
        If the order or the signs are others than those of the published files.
    """
    if not np.all(np.diff(strain) > 0.0) or strain[0] * strain[-1] >= 0.0:
        raise InputError(f"{path}: strain does not rise from below to above zero")
    if force[-1] <= force[0]:
        raise InputError(f"{path}: the force falls with the strain; its sign is not that of shear")
