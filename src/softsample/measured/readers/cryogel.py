"""Hydrogel cylinders under a texture analyser: down and up again at 0.01 mm/s, immersed."""

from pathlib import Path

import pandas as pd

from softsample.errors import InputError
from softsample.measured.files import headed, lines_of, numbers, sheets
from softsample.measured.sample import Sample, cylinder, record

ABOUT = (
    "Cryogels of carboxymethyl cellulose in six concentrations, immersed cylinders of 5 mm "
    "diameter, pressed and released once at 0.01 mm/s, read at 200 Hz."
)
UNSTATED = (
    "height and zero of displacement: the touch point is approximate (steps of 0.05 mm)",
    "friction on the platens, and whether water leaves the gel",
    "records beyond half of the height are left out, which finite elements do not reach",
)
GRAM_FORCE = 9.80665e-3
"""One gram-force [N]."""
LISTED = ("File", "Folder", "diameter_mm", "start_height_mm", "approximate_gel_touch_point")


def read(folder: Path) -> list[Sample]:
    """The gels that the listing names, from the lowest concentration on.

    Raises
    ------
    InputError
        If the listing or a trace is of another form.
    """
    found = []
    for _, row in _listing(folder / "samples/file_listing.xlsx").iterrows():
        place = str(row["Folder"]).replace("\\", "/")
        trace = read_trace(folder / "samples" / place / str(row["File"]))
        touch = float(row["approximate_gel_touch_point"])
        name = place.split("/")[0]
        shape = cylinder(float(row["diameter_mm"]), float(row["start_height_mm"]) - touch)
        found.append(
            Sample(
                name,
                name,
                "compression",
                shape,
                record(touch - trace["mm"], -GRAM_FORCE * trace["g"], time_s=trace["sec"]),
            )
        )
    return sorted(found, key=lambda sample: sample.name, reverse=True)


def read_trace(path: Path) -> pd.DataFrame:
    """Columns `g`, `mm`, `sec` of one run, as in the file.

    Raises
    ------
    InputError
        If the line of titles or of units is another one.
    """
    lines = lines_of(path)
    if len(lines) < 3 or lines[1].split() != ["Force", "Distance", "Time"]:
        raise InputError(f"{path}: the second line is not 'Force Distance Time'")
    rows = [line.rstrip("\t") for line in lines[2:] if line.strip()]
    return numbers(path, rows, ("g", "mm", "sec"), separator="\t")


def _listing(path: Path) -> pd.DataFrame:
    """Rows of the listing that name a file."""
    table = headed(next(iter(sheets(path).values())))
    absent = set(LISTED) - set(table)
    if absent:
        raise InputError(f"{path}: no column {', '.join(sorted(absent))}")
    return table.dropna(subset=list(LISTED))
