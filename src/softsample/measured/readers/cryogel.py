"""Hydrogel cylinders under a texture analyser: down and up again at 0.01 mm/s, immersed."""

from pathlib import Path

import numpy as np
import pandas as pd

from softsample.errors import InputError
from softsample.measured.files import lines_of, numbers, workbook_rows
from softsample.measured.measurement import GRAM_FORCE, Measurement, cylinder
from softsample.records import MM, Record

UNSTATED = (
    "the touch point is approximate (0.05 mm steps): where contact begins is fitted",
    "friction on the platens, and whether water leaves the gel as it is pressed",
    "sampleGel.tab: diameter 4 mm, but neither start height nor touch point; read by no model",
)
LISTED = ("File", "Folder", "diameter_mm", "start_height_mm", "approximate_gel_touch_point")

FREE = 0.6
"""Part of the way to the bench on which the chuck surely touches nothing."""


def read(folder: Path) -> list[Measurement]:
    """The gels that the listing names, from the lowest concentration on."""
    found = []
    for row in _listing(folder / "samples/file_listing.xlsx"):
        place = str(row["Folder"]).replace("\\", "/")
        table = read_trace(folder / "samples" / place / str(row["File"]))
        touch = float(row["approximate_gel_touch_point"])
        shape = cylinder(float(row["diameter_mm"]), float(row["start_height_mm"]) - touch)
        record = Record(
            table["sec"].to_numpy(),
            -MM * (table["mm"].to_numpy() - touch),
            -GRAM_FORCE * table["g"].to_numpy(),
        )
        group = place.split("/")[0]
        found.append(Measurement(group, group, group, "compression", shape, record))
    return sorted(found, key=lambda test: test.name, reverse=True)


def read_trace(path: Path) -> pd.DataFrame:
    """Columns `g`, `mm`, `sec` of one run, as in the file.

    Raises
    ------
    InputError
        If the line of units is another one.
    """
    lines = lines_of(path)
    if len(lines) < 3 or lines[1].split() != ["Force", "Distance", "Time"]:
        raise InputError(f"{path}: the second line is not 'Force Distance Time'")
    rows = [line.rstrip("\t") for line in lines[2:] if line.strip()]
    return numbers(path, rows, ("g", "mm", "sec"), separator="\t")


def stiffness(trace: pd.DataFrame, force_g: float) -> float:
    """Slope of a run on its way down [N/m] beyond a force [g]: of the bench, where no gel lies."""
    down = _way_down(trace)
    pressed = down[down["g"] > force_g]
    slope, _ = np.polyfit(MM * pressed["mm"], GRAM_FORCE * pressed["g"], 1)
    return float(slope)


def _way_down(trace: pd.DataFrame) -> pd.DataFrame:
    return trace.iloc[: int(trace["mm"].to_numpy().argmax()) + 1]


def evidence(folder: Path) -> dict[str, float]:
    """What the runs without a gel say of the machine; the loop never sees it.

    Returns
    -------
    dict
        `bench_mm_per_N`: compliance of frame and cell, from the chuck on the bare bench;
        `free_mN`, `free_mN_per_s`: mean and trend of the force on the chuck in free travel
        before it meets the bench (compression positive); `no_gel_mN`: mean in the run
        without gel.
    """
    bench = read_trace(folder / "frame_stiffness.tab")
    free = _way_down(bench)
    free = free[free["mm"] < FREE * bench["mm"].max()]
    trend, _ = np.polyfit(free["sec"], free["g"], 1)
    no_gel = read_trace(folder / "controlNoGel.tab")
    mN = 1e3 * GRAM_FORCE
    return {
        "bench_mm_per_N": 1e3 / stiffness(bench, 50.0),
        "free_mN": mN * float(free["g"].mean()),
        "free_mN_per_s": mN * float(trend),
        "no_gel_mN": mN * float(no_gel["g"].mean()),
    }


def _listing(path: Path) -> list[dict[str, str]]:
    """Rows of the listing by the names of its columns."""
    first, *rows = workbook_rows(path)
    absent = set(LISTED) - set(first.values())
    if absent:
        raise InputError(f"{path}: no column {', '.join(sorted(absent))}")
    named = ({first[at]: cell for at, cell in row.items() if at in first} for row in rows)
    return [row for row in named if set(LISTED) <= set(row)]
