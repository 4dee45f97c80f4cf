"""Right ventricular myocardium of sheep: eleven hearts, six shear and three axial modes each."""

from pathlib import Path

import numpy as np

from softsample.errors import InputError
from softsample.measured.files import lines_of, numbers
from softsample.measured.readers.clots import check_shear
from softsample.measured.sample import Sample, cuboid, outward, record

ABOUT = (
    "Right ventricular myocardium of sheep, eleven hearts, in six modes of simple shear and three "
    "of tension and compression (every third mode), with shear and normal force, as in Kakaletsis "
    "et al. 2021, doi 10.1016/j.actbio.2020.12.006. Each heart has three stated sizes, each of "
    "three modes; the round displacements in millimetres that follow from strain times the third "
    "edge make that the height, and the product of the first two the area."
)
UNSTATED = (
    "along which directions of the material a mode loads and shears (taken in the usual order, of "
    "fibre, sheet and normal: fs, fn, ff, sf, sn, ss, nf, ns, nn)",
    "whether the three sizes are three cubes (taken as three specimens)",
    "which of the first two edges lies along the shear (taken as the first)",
    "forces are read, since the files of stress divide by the second times the third edge",
    "how the faces are held (taken as bonded), time, order of the modes and preconditioning",
)
MODES = 9
AXIAL = 3
"""Every third mode is tension and compression."""

FIBRE, SHEET, NORMAL = "1", "2", "3"
SHEARED = {FIBRE: (SHEET, NORMAL), SHEET: (FIBRE, NORMAL), NORMAL: (FIBRE, SHEET)}
"""Directions of the material along the shear of the first two modes, by that along the load."""


def read(folder: Path) -> list[Sample]:
    """Twelve samples a heart; an axial mode makes one in tension and one in compression.

    Raises
    ------
    InputError
        If a file is of another form, or its signs are others.
    """
    hearts = (folder / "ExperimentalMyocardiumData").glob("TSL*")
    return [
        sample
        for heart in sorted(hearts, key=lambda path: int(path.name[3:]))
        for mode in range(1, MODES + 1)
        for sample in read_mode(heart, mode)
    ]


def read_mode(heart: Path, mode: int) -> list[Sample]:
    """Samples of one file of a heart.

    Raises
    ------
    InputError
        If the file is of another form, or its signs are others.
    """
    path, cube = heart / f"ForceStrain_M{mode}.csv", (mode - 1) // AXIAL
    edges = sizes(heart / "WDH_Params.csv")[cube]
    channels = ("Fz",) if mode % AXIAL == 0 else ("Fx", "Fz")
    table = numbers(path, lines_of(path), ("Strain", *channels))
    check_shear(path, table["Strain"].to_numpy(), table[channels[0]].to_numpy())
    name, group = f"{heart.name}_M{mode}", heart.name
    shape, specimen = cuboid(*edges), f"{heart.name}_{cube + 1}"
    loaded = (FIBRE, SHEET, NORMAL)[cube]
    travel, axial = edges[2] * table["Strain"].to_numpy(), table["Fz"].to_numpy()
    if "Fx" in table:
        found = record(travel, table["Fx"], force_normal_N=axial)
        along = {"material_z": loaded, "material_x": SHEARED[loaded][(mode - 1) % AXIAL]}
        return [Sample(name, group, "shear", shape, found, specimen, **along)]
    travel, axial = travel[travel != 0.0], axial[travel != 0.0]
    ways = {"tension": outward(travel, axial, 1.0), "compression": outward(travel, axial, -1.0)}
    return [
        Sample(f"{name}_{way}", group, way, shape, record(*curve), specimen, material_z=loaded)
        for way, curve in ways.items()
    ]


def sizes(path: Path) -> np.ndarray:
    """Edges [mm] of the three cubes (3, 3): along the shear, across it, height.

    Raises
    ------
    InputError
        If the file does not hold nine lengths of some millimetres.
    """
    try:
        edges = np.array(",".join(lines_of(path)).split(","), dtype=float).reshape(3, 3)
    except ValueError as error:
        raise InputError(f"{path}: not nine numbers ({error}); fetch it again") from error
    if not np.all((edges > 1.0) & (edges < 50.0)):
        raise InputError(f"{path}: an edge is not between 1 and 50 mm; is the file in m?")
    return edges
