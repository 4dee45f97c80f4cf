"""Limits of what goes without a word, and the units that would explain what lies beyond."""

import re
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from softsample.errors import InputError
from softsample.io import read_yaml
from softsample.plausibility import Limits, doubts

ROOT = Path(__file__).resolve().parents[2]
SECTION = read_yaml(ROOT / "config/config.yaml")["plausibility"]
LIMITS = Limits(**SECTION)


class Size(NamedTuple):
    """100 mm2 and 10 mm."""

    area: float = 1e-4
    height: float = 10e-3


def facts(way=2.0, force=0.5, seconds=10.0, rate=50.0, **columns):
    read = {"time_s": ("time_s", "s"), "displacement_mm": ("displacement_mm", "mm")}
    read |= {"force_N": ("Load [N]", "N")} | columns
    return {
        "travel_mm": -way,
        "ramp_start_mm": 0.0,
        "peak_force_N": -force,
        "force_offset_N": None,
        "ramp_speed_mm_s": way / seconds,
        "sampling_rate_hz": rate,
        "reading": {
            "columns": {
                name: {"title": t, "unit": u, "factor": 1.0, "unit_from": "title", "unit_line": 3}
                for name, (t, u) in read.items()
            }
        },
    }


CASES = {
    "sound": (facts(), None, None),
    "displacement in cm": (
        facts(way=0.2),
        "strain of 2 % at a height of 10 mm",
        "in cm, write 'displacement_cm' in place of 'displacement_mm' in line 3",
    ),
    "displacement in um": (facts(way=2000.0), "strain of 20000 %", "'displacement_um' in place"),
    "force in mN": (facts(force=500.0), "25000 kPa", "'Load .mN.' in place of 'Load .N.'"),
    "force in kN": (facts(force=5e-6), "0.00025 kPa", "'Load .kN.' in place of"),
    "time in ms": (facts(seconds=1e4, rate=0.05), "0.05 samples per s", "'time_ms' in place of"),
    "time in min": (facts(seconds=0.01, rate=3e3), "rate of 20 per s", "'time_min' in place of"),
    "nothing explains it": (facts(way=0.2, force=5e6), "strain of 2 %, stress over", None),
}


@pytest.mark.parametrize("name", CASES)
def test_what_may_be_in_another_unit_is_doubted_with_the_likeliest_cure(name):
    given, value, cure = CASES[name]
    found = [*doubts(given, Size(), LIMITS)]
    assert len(found) == (value is not None)
    for doubt in found:
        assert re.search(value, doubt)
        assert (cure is None) == (" in place of " not in doubt)
        assert cure is None or re.search(cure, doubt)


@pytest.mark.parametrize("name", [name for name in CASES if CASES[name][1]])
def test_what_is_right_is_accepted_by_the_setting_that_is_told(name):
    given = CASES[name][0]
    (doubt,) = doubts(given, Size(), LIMITS)
    accepted = yaml.safe_load(doubt.split("set `")[-1].split("`")[0])["plausibility"]
    assert [*doubts(given, Size(), Limits(**SECTION | accepted))] == []


def test_dimensions_in_centimetres_are_told_as_cells_of_the_table():
    small = Size(1e-6, 1e-3)
    (doubt,) = doubts(facts(), small, LIMITS, {"diameter_mm": "1.1", "height_mm": "1"})
    assert "cm, write 11 into column diameter_mm and 10 into column height_mm. If it is" in doubt
    cube = {"length_mm": "1", "width_mm": "1.0", "height_mm": "1"}
    (doubt,) = doubts(facts(), small, LIMITS, cube)
    assert "cm, write 10 into columns length_mm, width_mm and height_mm. If it is right" in doubt


STATED = {
    "displacement": ("displacement_mm", ("Travel (mm)", "mm")),
    "strain": ("strain", ("Strain", "1")),
    "stretch": ("stretch", ("Stretch", "1")),
    "angle": ("angle_rad", ("Angle (rad)", "rad")),
    "force": ("force_N", ("Load (N)", "N")),
    "stress": ("stress_Pa", ("Stress (Pa)", "Pa")),
    "torque": ("torque_Nmm", ("Torque (N mm)", "N mm")),
}


def stated(first, second, **of_facts):
    """Facts of a record whose file states these two quantities."""
    given = facts(**of_facts)
    columns = given["reading"]["columns"]
    told = {
        title: columns["force_N"] | dict(zip(("title", "unit"), of, strict=True))
        for title, of in (STATED[first], STATED[second])
    }
    return given | {"reading": {"columns": {"time_s": columns["time_s"]} | told}}


@pytest.mark.parametrize(
    ("first", "second", "way", "force", "offered"),
    [
        ("displacement", "force", 15.0, 5.0, True),  # 150 %, 33 kPa
        ("strain", "force", 20.0, 5.0, False),  # a strain is one at any size
        ("stretch", "stress", 20.0, 5.0, False),
        ("displacement", "stress", 15.0, 5.0, True),
        ("strain", "force", 2.0, 500.0, True),  # 20 %, 25 MPa: the section may be wrong
        ("strain", "stress", 2.0, 500.0, False),
        ("angle", "torque", 20.0, 5.0, False),
    ],
)
def test_dimensions_are_offered_only_where_they_change_what_is_doubted(
    first, second, way, force, offered
):
    given = stated(first, second, way=way, force=force)
    cells = {"length_mm": "10", "width_mm": "10", "height_mm": "10"}
    (doubt,) = doubts(given, Size(), LIMITS, cells)
    assert ("If the dimensions are in" in doubt) == offered
    assert ("a unit or a dimension wrong? " in doubt) == offered
    assert ("at a height of" in doubt) == offered


def test_no_sample_is_pressed_to_beyond_its_base():
    """An extension of the machine that was not set to zero at the first touch."""
    far = facts() | {"ramp_start_mm": -25.0}
    with pytest.raises(InputError, match=r"ends at 27 mm, .* its height, 10 mm; .*zero: .*start"):
        list(doubts(far, Size(), LIMITS, mode="compression"))
    assert list(doubts(far, Size(), LIMITS, mode="tension")) == []


def test_what_is_at_a_limit_with_the_digits_that_are_told_is_not_doubted():
    """A strip of 200 mm that is pulled by 200.013 mm."""
    assert [*doubts(facts(way=10.0007), Size(), LIMITS)] == []
    assert [*doubts(facts(way=10.1), Size(), LIMITS)]


def test_a_unit_of_the_settings_is_changed_there():
    given = facts(force=500.0)
    given["reading"]["columns"]["force_N"]["unit_from"] = "settings"
    (doubt,) = doubts(given, Size(), LIMITS, block="press")
    assert "set `formats: {press: {units: {force: mN}}}`" in doubt


def test_no_unit_explains_the_times_of_a_clock():
    given = facts(seconds=1e4, rate=0.05)
    given["reading"]["columns"]["time_s"]["unit_from"] = "cells"
    (doubt,) = doubts(given, Size(), LIMITS)
    assert "wrong? If it is right, set" in doubt


@pytest.mark.parametrize(("mode", "doubted"), [("indentation", 0), ("torsion", 0), ("shear", 1)])
def test_no_stress_is_doubted_where_no_sample_deforms_uniformly(mode, doubted):
    small = facts(way=0.002, force=1e-9)
    assert len([*doubts(small, Size(), LIMITS.of(mode))]) == doubted
    assert LIMITS.of(mode).strain[1] == LIMITS.strain[1]


def test_without_dimensions_only_what_is_large_for_any_sample_is_doubted():
    assert [*doubts(facts(), None, LIMITS)] == []
    (far,) = doubts(facts(way=120.0), None, LIMITS)
    assert "displacement of 120 mm; was it written in another unit" in far
    (strong,) = doubts(facts(force=200.0), None, LIMITS)
    assert "force of 200 N; was it written in mN or g" in strong
