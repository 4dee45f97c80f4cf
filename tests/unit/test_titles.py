"""Every synonym of the one table of titles and units, through the reader of files."""

import numpy as np
import pytest

import machines
from softsample.formats.machine import read
from softsample.formats.titles import COLUMNS, NAMES, UNITS

OURS = {"time": "Time (s)", "displacement": "Extension (mm)", "force": "Load (N)"}
TURNED = {"time": "Time (s)", "displacement": "Angle (rad)", "force": "Torque (Nmm)"}
STANDS_FOR = {
    "strain": "displacement", "stretch": "displacement", "angle": "displacement",
    "stress": "force", "torque": "force",
}  # fmt: skip
VALUES = np.array([0.5, 1.5, 2.5])


def reading(tmp_path, quantity, title, below=""):
    """Values of a quantity from a file with this title in place of ours."""
    ours = TURNED if quantity in ("angle", "torque") else OURS
    titles = {**ours, STANDS_FOR.get(quantity, quantity): title}
    lines = [";".join(titles.values())]
    lines += [";".join(below if name == title else "" for name in titles.values())] * bool(below)
    lines += [";".join([f"{value}"] * 3) for value in VALUES]
    mode = "torsion" if ours is TURNED else ""
    found = read(machines.write(tmp_path / "r.csv", "\n".join(lines)), mode=mode)
    return found.table[COLUMNS[quantity]].to_numpy(float)


@pytest.mark.parametrize(
    ("quantity", "name"),
    [(quantity, name) for quantity in NAMES for name in sorted(NAMES[quantity])],
)
def test_each_name_is_read(tmp_path, quantity, name):
    unit = next(iter(UNITS[quantity]))
    for title in (f"{name.capitalize()} ({unit})", f"{name.upper()} [{unit}]"):
        np.testing.assert_allclose(reading(tmp_path, quantity, title), VALUES)


@pytest.mark.parametrize(
    ("quantity", "unit"), [(quantity, unit) for quantity in NAMES for unit in UNITS[quantity]]
)
def test_each_unit_is_read_behind_the_title_and_below_it(tmp_path, quantity, unit):
    name, expected = quantity.capitalize(), UNITS[quantity][unit] * VALUES
    np.testing.assert_allclose(reading(tmp_path, quantity, f"{name} ({unit})"), expected)
    if unit != "1":  # below a title it is a number
        np.testing.assert_allclose(reading(tmp_path, quantity, name, unit), expected)


AS_WRITTEN = {
    "Shear displacement (mm)": ("displacement", 1.0),
    "Grip separation [mm]": ("displacement", 1.0),
    "Traverse pos. (mm)": ("displacement", 1.0),
    "Crosshead Position, in": ("displacement", 25.4),
    "Weg in mm": ("displacement", 1.0),
    "Position(1:Axial) (mm)": ("displacement", 1.0),
    "Tensile strain (Displacement) (%)": ("strain", 0.01),
    "Force (max) (N)": ("force", None),
    "Traversenweg µm": ("displacement", 1e-3),
    "Actuator displacement (inches)": ("displacement", 25.4),
    "Shear force (gf)": ("force", 9.80665e-3),
    "Standardkraft [N]": ("force", 1.0),
    "Load {kN}": ("force", 1e3),
    "Load <mN>": ("force", 1e-3),
    "Force（N）": ("force", 1.0),
    "Kraft in mN": ("force", 1e-3),
    "Load cell (kgf)": ("force", 9.80665),
    "Load Cell 1: Force (lbf)": ("force", 4.4482216152605),
    "Force/N": ("force", 1.0),
    "Zeit in s": ("time", 1.0),
    "Prüfzeit (min)": ("time", 60.0),
    "Elapsed time_ms": ("time", 1e-3),
    "Elapsed (h)": ("time", 3600.0),
    "Running Time (s)": ("time", 1.0),
}
"""Titles of files, the quantity, and the size of its unit; None for what is not understood."""


@pytest.mark.parametrize("title", AS_WRITTEN)
def test_titles_as_machines_write_them(tmp_path, title):
    quantity, size = AS_WRITTEN[title]
    if size is None:
        with pytest.raises(ValueError, match="name it in the settings"):
            reading(tmp_path, quantity, title)
    else:
        np.testing.assert_allclose(reading(tmp_path, quantity, title), size * VALUES)


@pytest.mark.parametrize("title", ["Load displacement (mm)", "Normal force (N)", "Temperature (C)"])
def test_other_titles_are_not_taken_for_a_force(tmp_path, title):
    with pytest.raises(ValueError, match="no column is known to hold force"):
        reading(tmp_path, "force", title)
