"""One blood clot in pure shear: a strip, wide, low and thin, pulled upward."""

from pathlib import Path

import numpy as np

from softsample.errors import InputError
from softsample.measured.files import lines_of
from softsample.measured.sample import Sample, cuboid, record

ABOUT = "One blood clot, a strip of 40 mm x 10 mm x 3 mm, stretched by half of its height."
UNSTATED = (
    "which edge is pulled (taken as 40 mm wide, 10 mm high, 3 mm thick)",
    "how the strip was held",
    "time",
)
LEAST_FORCE = 1.0
"""A largest number below this is not a force in mN."""


def read(folder: Path) -> list[Sample]:
    """The one record; displacement [mm] and force [mN], no header.

    Raises
    ------
    InputError
        If the file does not hold two columns, or the force is not in mN.
    """
    path = folder / "example_data.txt"
    try:
        travel, force = np.loadtxt(lines_of(path), ndmin=2, unpack=True)
    except ValueError as error:
        raise InputError(f"{path}: not two columns of numbers ({error})") from error
    if not force.max() > LEAST_FORCE:
        raise InputError(f"{path}: the largest force is {force.max():g} mN; is the file in N?")
    shape = cuboid(40.0, 3.0, 10.0)
    return [Sample("clot", "clot", "pure_shear", shape, record(travel, 1e-3 * force))]
