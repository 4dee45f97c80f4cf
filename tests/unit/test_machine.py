"""Test records of machines: the same test comes out of every file, and nothing is guessed."""

from datetime import timedelta
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest

import machines
from softsample.errors import InputError
from softsample.formats.columns import Column
from softsample.formats.machine import described, read
from softsample.io import read_table, read_yaml
from softsample.records import RecordSettings, aligned_record
from softsample.validation import overlaid

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = read_yaml(ROOT / "workflow/schemas/record.schema.yaml")
TEST = machines.compression()


def settings(**changes):
    return RecordSettings(**overlaid(read_yaml(ROOT / "config/config.yaml")["records"], changes))


def imported(path, mode="compression", **changes):
    """Table and facts of a file, as the workflow takes them."""
    given = settings(**changes)
    raw = read(path, given.columns, given.units, given.sheet)
    return aligned_record(raw.table, raw.reading, mode, given, SCHEMA, path.name)


@pytest.mark.parametrize("name", machines.MACHINES)
def test_the_same_test_comes_out_of_every_machine(tmp_path, name):
    path = machines.write(tmp_path / "Prüfung 1.csv", machines.MACHINES[name](*TEST))
    table, facts = imported(path)
    for column, values in zip(("time_s", "displacement_mm", "force_N"), TEST, strict=True):
        np.testing.assert_allclose(table[column], values, rtol=1e-6, atol=2e-6)
    assert facts["phases"][0]["kind"] == "baseline"
    assert facts["peak_force_N"] == pytest.approx(TEST[2].min(), abs=2e-6)


@pytest.mark.parametrize(
    ("name", "unit", "factor", "comma"),
    [
        ("CellScale UniVert", "N", 1.0, False),
        ("Instron Bluehill", "kN", 1e3, False),
        ("German Bluehill", "lbf", 4.4482216152605, True),
        ("TA/Bose WinTest", "N", 1.0, False),
        ("table", "g", 9.80665e-3, False),
    ],
)
def test_machine_unit_and_decimal_mark_are_told(tmp_path, name, unit, factor, comma):
    path = machines.write(tmp_path / "r.csv", machines.MACHINES[name](*TEST))
    reading = read(path).reading
    assert reading["kind"] in (name, "table")
    assert reading["columns"]["force_N"]["unit"] == unit
    assert reading["columns"]["force_N"]["factor"] == pytest.approx(factor)
    assert reading["decimal_comma"] is comma
    told = "; ".join(described(reading))
    assert f"in {unit}" in told
    assert ("decimal commas" in told) is comma


@pytest.mark.parametrize(("sample", "mode"), [("C1", "compression"), ("S1", "shear")])
def test_our_own_table_is_taken_as_it_stands(sample, mode):
    path = ROOT / f"resources/cohort/records/{sample}.csv"
    table, _ = imported(path, mode)
    columns = ["time_s", "displacement_mm", "force_N"]
    pd.testing.assert_frame_equal(table[columns].reset_index(drop=True), read_table(path))
    assert table.index[0] == 1 + path.read_text().split("time_s")[0].count("\n") + 1


def test_what_is_passed_over_is_told(tmp_path):
    univert = read(machines.write(tmp_path / "u.csv", machines.univert(*TEST)))
    assert univert.reading["ignored"] == ["SetName", "Cycle", "Size_mm"]
    wintest = read(machines.write(tmp_path / "w.csv", machines.wintest(*TEST)))
    notes = "; ".join(wintest.reading["notes"])
    assert "NUL characters left out: 12" in notes
    assert "repetitions of the titles: 1" in notes
    twice = machines.univert(*TEST).splitlines()
    twice.insert(30, twice[29])
    repeated = read(machines.write(tmp_path / "r.csv", "\n".join(twice)))
    assert len(repeated.table) == len(TEST[0])
    assert "repeat another one: 1" in "; ".join(repeated.reading["notes"])


def test_lines_are_those_of_the_file(tmp_path):
    path = machines.write(tmp_path / "b.csv", machines.bluehill(*TEST))
    assert read(path).table.index[0] == 6


def plain(titles="a,b,c", test=TEST):
    rows = [",".join(f"{x:.5f}" for x in cells) for cells in zip(*test, strict=True)]
    return "\n".join([titles, *rows, ""])


def test_a_table_without_words_is_read_by_its_mapping(tmp_path):
    path = machines.write(tmp_path / "p.csv", plain())
    names = {"time": "a", "displacement": "b", "force": "c"}
    units = {"time": "s", "displacement": "mm", "force": "mN"}
    small = machines.write(tmp_path / "m.csv", plain(test=(*TEST[:2], 1e3 * TEST[2])))
    table, _ = imported(small, columns=names, units=units)
    np.testing.assert_allclose(table["force_N"], TEST[2], atol=1e-7)
    with pytest.raises(InputError, match=r"column 'a': no unit is named; .*units: \{time: s\}"):
        read(path, names)
    with pytest.raises(InputError, match=r"line 1: no column .* hold displacement .strain or"):
        read(path)


REFUSED = {
    "no force": (
        "Time (s),Disp (mm),Temp (C)",
        "no column is known to hold force .*'Temp \\(C\\)'",
    ),
    "two forces": ("Time (s),Disp (mm),Load (N),Force (N)", "2 columns may hold force"),
    "forces of two specimens": (
        "Disp (mm),Load 1 (N),Load 2 (N)",
        r"2 columns may hold force \('Load 1 \(N\)', 'Load 2 \(N\)'\); name the right one .*"
        r"\{columns: \{force: Load 1 \(N\)\}\}`, or in a block of `formats` for each row",
    ),
    "forces of two channels": ("Disp (mm),Ch1 Force (N),Ch2 Force (N)", "2 columns may hold force"),
    "a number beside none": ("Disp (mm),Load (N),Load 2 (N)", "2 columns may hold force"),
    "travel of two specimens": ("Disp 1 (mm),Disp 2 (mm),Load (N)", "2 columns may hold displ"),
    "no unit": ("Time (s),Disp (mm),Load", "column 'Load': no unit is named"),
    "strange unit": ("Time (s),Disp (mm),Load (V)", "'V' is no known unit of force"),
    "same title twice": (
        "time_s,displacement_mm,force_N,force_N",
        "2 columns may hold force .*; delete the columns of other tests, or give each its own",
    ),
    "brackets without a unit": (
        "Time (sec.),Disp (mm),Load (N)",
        "'sec.' is no known unit of time .*; write one of these, convert the column or, if it",
    ),
    "another case": ("Time (s),Disp (mm),Load (MN)", "'MN' is no .*; if it is mN, write that in"),
    "minutes as metres": ("Time (m),Disp (mm),Load (N)", "'m' is no known .*; write one of these"),
    "unit of another quantity": (
        "Time (s),Disp (mm),Load (kPa)",
        "'kPa' is no known unit of force .*; it is one of stress, so name the column as that",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_title_leaves_open_is_refused(tmp_path, name):
    titles, message = REFUSED[name]
    path = machines.write(tmp_path / "r.csv", plain(titles))
    with pytest.raises(InputError, match=message):
        read(path)


@pytest.mark.parametrize("title", ["Load 1 (N)", "Load 2 (N)", "Ch2 Force (N)", "Load cell 3 (N)"])
def test_a_number_alone_leaves_nothing_open(tmp_path, title):
    path = machines.write(tmp_path / "r.csv", plain(f"Time (s),Disp (mm),{title}"))
    np.testing.assert_allclose(read(path).table["force_N"], TEST[2], atol=1e-5)


def test_each_of_several_specimens_is_had_by_its_title(tmp_path):
    path = machines.write(tmp_path / "r.csv", plain("Load 1 (N),Disp (mm),Load 2 (N)"))
    for title, number in (("Load 1 (N)", 0), ("Load 2 (N)", 2)):
        found = read(path, {"force": title}).table["force_N"]
        np.testing.assert_allclose(found, TEST[number], atol=1e-5)


@pytest.mark.parametrize(
    ("titles", "cure"),
    [
        ("Time (s),Eng. strain,Load (N)", "{columns: {strain: Eng. strain}}"),
        ("Time (s),Disp (mm),Eng. stress (kPa)", "{columns: {stress: Eng. stress (kPa)}}"),
        ("Time (s),Way,Load (N)", "{columns: {displacement: Way}, units: {displacement: mm}}"),
        ("Time (s),Final twist [mrad],Torque (Nmm)", "{columns: {angle: 'Final twist [mrad]'}}"),
    ],
)
def test_a_column_is_proposed_as_what_it_holds(tmp_path, titles, cure):
    path = machines.write(tmp_path / "r.csv", plain(titles))
    mode = "torsion" if "Torque" in titles else "tension"
    with pytest.raises(InputError) as refused:
        read(path, mode=mode)
    assert f"`records: {cure}`" in str(refused.value)


def test_columns_in_another_language_are_proposed_by_the_units_below(tmp_path):
    text = plain("czas,przesunięcie,siła\n(s),(mm),(mN)")
    path = machines.write(tmp_path / "r.csv", text)
    with pytest.raises(
        InputError, match="'przesunięcie' and 'siła' may be these, name these in "
    ) as refused:
        read(path)
    cure = "`records: {columns: {displacement: przesunięcie, force: siła}}`"
    assert str(refused.value).endswith(cure)
    raw = read(path, {"time": "czas", "displacement": "przesunięcie", "force": "siła"})
    np.testing.assert_allclose(raw.table["force_N"], 1e-3 * TEST[2], atol=1e-8)
    path = machines.write(tmp_path / "r.csv", plain("x,y,z"))
    with pytest.raises(InputError) as refused:
        read(path)
    told = str(refused.value)
    assert "displacement (strain or stretch may stand for it), nor force (stress may" in told
    assert "such as `records: {columns: {displacement: its title, force: its title}}`" in told


@pytest.mark.parametrize(
    "titles",
    [
        "Time (s),True strain (%),True stress (kPa)",
        "Time (s),Hencky_strain,Load (N)",
        "Disp (mm),Temp (C),Cauchy (kPa)",
        "Zeit (s),Weg (mm),Wahre Spannung (kPa)",
    ],
)
def test_true_stress_and_strain_are_not_taken_for_nominal_ones(tmp_path, titles):
    with pytest.raises(InputError, match="nominal stress and strain are needed, and ") as refused:
        read(machines.write(tmp_path / "r.csv", plain(titles)))
    assert "`" not in str(refused.value)
    assert "nominal stress = true stress / stretch" in str(refused.value)


def test_a_nominal_column_is_proposed_beside_a_true_one(tmp_path):
    titles = "Time (s),True strain,Eng. strain,Load (N)"
    with pytest.raises(InputError, match=r"\{columns: \{strain: Eng. strain\}\}"):
        read(machines.write(tmp_path / "r.csv", plain(titles, (*TEST, TEST[2]))))


def test_brackets_may_hold_no_unit_where_the_line_below_tells_it(tmp_path):
    titles = "Time (sec.),Position (LVDT),Load (Cell 1)"
    path = machines.write(tmp_path / "r.csv", plain(titles))
    given = {"time": "s", "displacement": "mm", "force": "N"}
    with pytest.raises(InputError, match=r"'sec\.' is no known unit"):  # it might be one
        read(path, units=given)
    wrong = machines.write(tmp_path / "w.csv", plain("Time,Disp,Load\ns,mm,V"))
    with pytest.raises(InputError, match="'V' is no known unit of force"):
        read(wrong, units=given)
    below = machines.write(tmp_path / "b.csv", plain(f"{titles}\ns,mm,N"))
    np.testing.assert_allclose(read(below).table["force_N"], TEST[2], atol=1e-5)
    with pytest.raises(InputError, match="'kg/s' is no known unit of force"):
        read(below, units={"force": "kg/s"})
    pressed = machines.write(tmp_path / "p.csv", plain("Time (s),Disp (mm),Load (kPa)"))
    with pytest.raises(InputError, match="'kPa' is no known unit of force"):
        read(pressed, units={"force": "N"})


def test_units_that_contradict_each_other_are_refused(tmp_path):
    path = machines.write(tmp_path / "r.csv", plain("Time (s),Disp (mm),Load (N)"))
    with pytest.raises(InputError, match="N and mN contradict each other"):
        read(path, units={"force": "mN"})
    assert read(path, units={"force": "Newton"}).table["force_N"].iloc[-1] == TEST[2][-1]


CONTENTS = {
    "workbook": (b"PK\3\4 whatever", "damaged or not of its kind .*export it again"),
    "binary": (bytes(range(1, 200)), "not a text file"),
    "empty": (b"\n", "the file is empty; export the test again"),
    "no titles": (b"0.0 1.0 2.0\n", "no line of titles"),
    "titles alone": (b"Time (s),Disp (mm),Load (N)\n", "no numbers below the titles"),
    "thousands": (
        b'Time (s);Disp (mm);Load (N)\n0.0;"1,0";2\n',
        r"numbers with a comma \(1,0\) and with a point \(0.0\)",
    ),
    "whole thousands": (
        b"Time (s)\tDisp (mm)\tLoad (mN)\n0\t0\t998\n1\t1\t1,002\n",
        "1,002 may be a decimal or have a thousands separator, as 998 has no comma",
    ),
    "whole thousands with points": (
        b"Time (s)\tDisp (mm)\tLoad (mN)\n0\t0\t998\n1\t1\t1.002\n",
        "1.002 may be a decimal or have a thousands separator, as 998 has no point",
    ),
    "thousands in one column": (
        b"Time (s)\tDisp (um)\tLoad (N)\n0.5\t0\t0.0\n1\t980\t0.3\n2\t1.000\t0.4\n3\t1.020\t0.5\n",
        "1.000 may be a decimal or have a thousands separator, as 0 has no point",
    ),
    "thousands with commas and without decimals": (
        b"Time (s)\tDisp (mm)\tLoad (mN)\n0\t0\t998.5\n1\t1\t1,002\n",
        r"numbers with a comma \(1,002\) and with a point \(998.5\)",
    ),
    "decimal commas under spare titles": (
        b"Disp (mm),Load (N),Temp,Note\n0,00,1,05\n1,50,2,10\n",
        "00 begins with 0, as decimals do; if these are decimal commas, export with semicolons",
    ),
    "units in cells of the titles": (
        b"Time,s,Extension,mm,Load,N\n0,0,1,2,3,4\n1,1,2,3,4,5\n",
        r"line 1: units stand in cells of their own \(Time, s, Extension.*write units in brackets",
    ),
    "another table": (
        b'"","Disp (mm)","Load (N)"\n"1",3,0.9\n"Raw"\n"Disp (mm)","Load (N)"\n0,0\n',
        "line 3: '\"Raw\"' stands among .* begins in line 4, delete the one that is not the test",
    ),
    "another table of other columns": (
        b"Disp (mm),Load (N)\n0,0\n1,1\nTemp (C),Humidity (%)\n20,50\n",
        "if another table begins in line 4, delete the one that is not the test",
    ),
    "other units in another block": (
        b"Time,Disp,Load\ns,mm,N\n0,0,0\n1,1,1\nTime,Disp,Load\ns,mm,mN\n2,2,2000\n",
        "line 6: 's,mm,mN' stands among the numbers; units stand once, in the line below the titl",
    ),
    "units in all cells": (
        b"Time,Disp,Load\n0 s,0 mm,0 N\n1 s,1 mm,1 N\n",
        "line 3: '1 s,1 mm,1 N' stands among .*; export numbers alone, with units in the titles",
    ),
    "thousands with spaces": (
        b"Time (ms);Disp (mm);Load (N)\n999;1;1\n1 000;1;1\n1 001;1;1\n",
        "line 3: '1 000;1;1' stands among the numbers; export without thousands separators",
    ),
    "another mark between numbers": (
        b"Time (s)\tDisp (mm)\tLoad (N)\n0;0;0\n1;1;1\n",
        "line 3: '1;1;1' stands among .*; export titles and numbers with the same mark between",
    ),
    "titles in a comment": (
        b"# made on Monday, 3 May\n# time_s,displacement_mm,force_N\n0.0,1.0,2.0\n",
        "no line of titles .*; if '# time_s,displacement_mm,force_N' are its titles, delete the #",
    ),
    "numbers alone": (b"0.0,1.0,2.0\n1.0,2.0,3.0\n", "no line of titles .*export the test with"),
    "commas between commas": (
        b"Time (s),Disp (mm),Load (N)\n0,00,1,00,2,00\n",
        "line 2: 6 cells below 3 titles; if these are decimal commas",
    ),
    "names of rows without a title": (
        b"Time (s),Disp (mm),Load (N)\n1,0.0,1.0,2.0\n",
        "4 cells below 3 titles; .*, else give each column a title",
    ),
    "no numbers at first": (
        b"Time (s),Disp (mm),Load (N)\nNaN,NaN,NaN\n0,0,1\n1,1,1\n",
        "line 2: 'NaN,NaN,NaN' stands among the numbers; delete the line",
    ),
    "no number at the end": (
        b"Time (s),Disp (mm),Load (N)\n0,0,1\n1,1,1\nNaN,,2\nStatus:,PASS\n",
        "line 4: 'NaN,,2' stands among the numbers; delete the line",
    ),
    "a wrong time at the end": (
        b"Time (s),Disp (mm),Load (N)\n0,0,1\n1,1,1\nlate,1,2\n",
        "line 4: 'late,1,2' stands among the numbers; delete the line",
    ),
    "metadata before more numbers": (
        b"Time (s),Disp (mm),Load (N)\n0,0,1\nStatus:,PASS\n\nEnd\n1,1,1\nDate:, 11/14/25\n",
        "line 3: 'Status:,PASS' stands among the numbers; delete the line",
    ),
    "a word among the numbers": (
        b"Time (s),Disp (mm),Load (N)\n0,0,1\npaused at 10:05:00\n1,1,1\n",
        "line 3: 'paused at 10:05:00' stands among the numbers; delete the line",
    ),
}


@pytest.mark.parametrize("name", CONTENTS)
def test_other_content_is_refused_with_its_place(tmp_path, name):
    content, message = CONTENTS[name]
    with pytest.raises(InputError, match=message):
        read(machines.write(tmp_path / "r.csv", content))


GROUPED = {
    "points": lambda x: f"{x:,.2f}",
    "commas": lambda x: f"{x:_.2f}".replace(".", ",").replace("_", "."),
    "narrow spaces": lambda x: f"{x:_.2f}".replace(".", ",").replace("_", "\u202f"),
    "apostrophes": lambda x: f"{x:_.2f}".replace("_", "'"),
    "a minus sign": lambda x: f"{x:,.2f}".replace("-", "\u2212"),
    "a dash": lambda x: f"{x:,.2f}".replace("-", "\u2013"),
}


@pytest.mark.parametrize("name", GROUPED)
def test_thousands_separators_that_can_be_nothing_else_are_left_out(tmp_path, name):
    rows = (";".join(map(GROUPED[name], 1e3 * np.array(row))) for row in zip(*TEST, strict=True))
    text = "\n".join(["Time (ms);Disp (um);Load (mN)", *rows])
    raw = read(machines.write(tmp_path / "r.csv", text.encode()))
    for column, values in zip(("time_s", "displacement_mm", "force_N"), TEST, strict=True):
        np.testing.assert_allclose(raw.table[column], values, atol=1e-5)
    assert np.abs(raw.table["time_s"]).max() > 1.0


BLANKS = {
    "fixed width": ("      Time      Disp      Load\n         s        mm         N", "{:10.3f}"),
    "titles with units": ("Time (s)   Disp (mm)   Load (N)", "{:10.3f}"),
    "one blank": ("Time (s) Disp (mm) Load (N)", "{:.3f}"),
    "our own": ("time_s displacement_mm force_N", "{:.3f}"),
    "decimal commas": ("Zeit_s Weg_mm Kraft_N", "{:.3f}"),
}


@pytest.mark.parametrize("name", BLANKS)
def test_blanks_may_stand_between_cells(tmp_path, name):
    titles, form = BLANKS[name]
    rows = "\n".join(" ".join(map(form.format, row)) for row in zip(*TEST, strict=True))
    rows = rows.replace(".", ",") if name == "decimal commas" else rows
    text = f"Operator made up\n\n{titles}\n{rows}\n\nEnd\n"
    raw = read(machines.write(tmp_path / "r.txt", text))
    for column, values in zip(("time_s", "displacement_mm", "force_N"), TEST, strict=True):
        np.testing.assert_allclose(raw.table[column], values, atol=6e-4)
    assert "cells are separated by blanks" in raw.reading["notes"]


def test_no_number_goes_into_the_place_of_an_empty_one(tmp_path):
    rows = [f"{t:8.3f} {d:8.3f} {f:8.3f}   37.0" for t, d, f in zip(*TEST, strict=True)]
    rows[50] = f"{rows[50][:8]}         {rows[50][17:]}"
    text = "\n".join(["Time_s Disp_mm Load_N Temp_C", *rows, ""])
    with pytest.raises(InputError, match="line 52: '.* stands among the numbers"):
        read(machines.write(tmp_path / "r.txt", text))


def test_a_blank_between_thousands_is_none_between_cells(tmp_path):
    test = zip(*abs(np.array(TEST)), strict=True)
    rows = [f"{1000 * t:.0f},1 {100 * d:03.0f},{1000 * f:.0f}" for t, d, f in test]
    text = "\n".join(["Time (ms),Disp (um),Load (mN)", *rows, ""])
    raw = read(machines.write(tmp_path / "r.txt", text))
    assert raw.table["displacement_mm"].iloc[0] == "1 000"


def test_a_title_in_quotes_may_go_over_lines(tmp_path):
    titles = 'Sample 5" wide\nTime (s),"Disp\n(mm)","Load\n\n(N)"'
    raw = read(machines.write(tmp_path / "r.csv", plain(titles)))
    np.testing.assert_allclose(raw.table["force_N"], TEST[2], atol=1e-5)
    assert raw.table.index[0] == 6


def test_the_line_with_numbers_below_is_told_before_others(tmp_path):
    lines = ["Date:,01/02/2024", "", "Time, s\tPosition (z), mm\tFz, gf", *["0\t1\t2"] * 3]
    with pytest.raises(InputError) as refused:
        read(machines.write(tmp_path / "r.csv", "\n".join(lines)))
    assert "line 3: no column" in str(refused.value)
    cure = "`records: {columns: {displacement: 'Position (z), mm', force: 'Fz, gf'}}`"
    assert str(refused.value).endswith(cure)


def test_a_test_in_lines_across_is_not_told_cell_by_cell(tmp_path):
    lines = [["Time (s)", *TEST[0]], ["Travel (mm)", *TEST[1]], ["Load (N)", *TEST[2]]]
    text = "\n".join(",".join(map(str, line)) for line in lines)
    with pytest.raises(InputError, match="no column is known to hold .* and [0-9]+ more") as told:
        read(machines.write(tmp_path / "r.csv", text))
    assert len(str(told.value)) < 1000


def test_in_torsion_an_angle_is_asked_for(tmp_path):
    rheometer = "Time\tTorque\tDisplacement\ns\tmNm\trad\n0\t1\t2\n"
    with pytest.raises(InputError, match=r"columns: \{angle: Displacement\}"):
        read(machines.write(tmp_path / "r.csv", rheometer), mode="torsion")
    other = rheometer.replace("rad", "K")
    with pytest.raises(InputError, match=r"columns: \{angle: its title\}"):
        read(machines.write(tmp_path / "o.csv", other), mode="torsion")


FOOTER = (
    *("Date:, 11/14/25", "Time:, 10:05:00", "Direction:, COMPRESSION", "Specimen Type:, Round"),
    *("Specimen Diameter (mm):, 21.996", "", "Notes", "-----", "Status:, PASS", ""),
)


@pytest.mark.parametrize("titles", ["Time (s),Extension (mm),Load (N)", "Extension (mm),Load (N)"])
@pytest.mark.parametrize("kind", ["csv", "xlsx"])
def test_metadata_below_the_numbers_are_left_out(tmp_path, titles, kind):
    columns = TEST[-len(titles.split(",")) :]
    lines = [f"{','.join(f'{x:.6f}' for x in row)}" for row in zip(*columns, strict=True)]
    whole = [titles, *lines]
    if kind == "csv":
        bare, path = (
            machines.write(tmp_path / f"{n}.csv", "\n".join(text))
            for n, text in enumerate(([*whole, ""], [*whole, *FOOTER]))
        )
    else:
        bare, path = (
            workbook(tmp_path / f"{n}.xlsx", {"A": [line.split(",") for line in text]})
            for n, text in enumerate((whole, [*whole, *FOOTER]))
        )
    raw = read(path)
    pd.testing.assert_frame_equal(raw.table, read(bare).table)
    told = f"metadata below the numbers, from line {len(whole) + 1} on: 'Date:"
    assert [line for line in raw.reading["notes"] if line.startswith(told)]


def test_a_marker_in_the_first_cell_is_no_comment(tmp_path):
    """Such as that of an overload, or of a spreadsheet's missing number."""
    lines = ["Load (N),Disp (mm),Time (s)", "0,0,0", "# paused", "#OVL,1,1", "# 9,9,9", "2,2,2"]
    raw = read(machines.write(tmp_path / "r.csv", "\n".join(lines)))
    assert raw.table["force_N"].tolist() == [0.0, "#OVL", 2.0]
    assert "lines left out that begin with #: 2" in raw.reading["notes"]


def test_whole_numbers_may_stand_beside_decimals(tmp_path):
    text = "Time (s),Disp (mm),Load (N)\n0,0,0\n1,1.234,0.5\n2,2,1.25\n3,1.234,1.5\n"
    raw = read(machines.write(tmp_path / "r.csv", text))
    assert raw.table["displacement_mm"].tolist() == [0.0, 1.234, 2.0, 1.234]


@pytest.mark.parametrize(
    ("title", "factor"),
    [
        ("Load (N) x10^-3", "10^-3"),
        ("Load x10 (N)", "x10"),
        ("Load (N) * 1000", "* 1000"),
        ("Load (N)/1000", "/1000"),
        ("Load in 1/100 N", "1/100"),
        ("Load 0.01 N", "0.01"),
        ("Load 0,1 N", "0,1"),
    ],
)
def test_a_factor_in_a_title_is_refused(tmp_path, title, factor):
    path = machines.write(tmp_path / "r.csv", f"Time (s);Disp (mm);{title}\n0;0;0\n1;1;1\n")
    with pytest.raises(InputError) as refused:
        read(path, {"force": title}, {"force": "N"})
    assert f"a factor in a title ({factor}) is not read; convert" in str(refused.value)


@pytest.mark.parametrize(
    "title", ["Load cell 100 N", "Load at 0.1 mm/s [N]", "Load (10 x 20 mm) [N]", "Fx10 (N)"]
)
def test_a_number_in_a_title_is_no_factor(tmp_path, title):
    path = machines.write(tmp_path / "r.csv", f"Time (s);Disp (mm);{title}\n0;0;0\n1;1;1\n")
    assert read(path, {"force": title}).table["force_N"].tolist() == [0.0, 1.0]


def test_titles_that_a_program_made_its_variables_hold_their_units(tmp_path):
    path = machines.write(tmp_path / "r.csv", plain("Time_s_,Displacement_mm_,Force_mN_"))
    np.testing.assert_allclose(read(path).table["force_N"], 1e-3 * TEST[2], atol=1e-7)


def test_no_stress_along_the_platen_is_that_of_an_axial_test(tmp_path):
    """A rheometer that presses a sample writes its shear stress too."""
    text = "Time (s),Gap (mm),Normal Force (N),Shear Stress (Pa)\n0,0,0,0\n1,1,1,5\n"
    path = machines.write(tmp_path / "r.csv", text)
    assert read(path, mode="shear").table["stress_Pa"].tolist() == [0.0, 5.0]
    with pytest.raises(InputError, match="if 'Normal Force .*columns: {force: Normal Force"):
        read(path, mode="compression")


def test_text_that_is_not_utf8_is_told(tmp_path):
    text = "Zeit (s),Weg (µm),Kraft (N)\n0,0,0\n1,1,1\n".encode("cp1252")
    assert any(
        "not UTF-8" in note
        for note in read(machines.write(tmp_path / "r.csv", text)).reading["notes"]
    )
    text = "时间(s),位移(mm),力(N)\n0,0,0\n1,1,1\n".encode("gb18030")
    with pytest.raises(InputError, match="no column is known .* save the file as UTF-8"):
        read(machines.write(tmp_path / "r.csv", text))


def test_wrong_cells_keep_their_line_and_their_text(tmp_path):
    lines = machines.univert(*TEST).splitlines()
    lines[40] = lines[40].rsplit(",", 1)[0] + ",n/a"
    lines[50] = lines[50].rsplit(",", 1)[0] + ","
    path = machines.write(tmp_path / "r.csv", "\n".join(lines))
    with pytest.raises(InputError, match=r"line 41, column 'force_N': 'n/a' .*\(2 such cells\)"):
        imported(path)


def of_day(seconds, form="{:02d}:{:02d}:{:06.3f}"):
    """Times as a clock shows them."""
    minutes, rest = divmod(seconds, 60.0)
    hours, minutes = divmod(int(minutes), 60)
    return form.format(hours % 24, minutes, rest)


@pytest.mark.parametrize("begin", [0.0, 36300.0, 86398.0])
@pytest.mark.parametrize(
    ("title", "date", "mark"),
    [
        ("Time (hh:mm:ss)", "", "."),
        ("Zeit", "", ","),
        ("Timestamp", "2024-03-01 ", "."),
        ("Time", "2024-03-01T", "."),
        ("Time (s)", "1.3.2024 ", "."),
    ],
)
def test_times_of_a_clock_are_read_as_seconds(tmp_path, begin, title, date, mark):
    rows = [
        date + f"{of_day(begin + t)};{d:.4f};{f:.5f}".replace(".", mark)
        for t, d, f in zip(*TEST, strict=True)
    ]
    text = "\n".join([f"{title};Extension (mm);Load (N)", *rows, ""])
    raw = read(machines.write(tmp_path / "r.csv", text))
    np.testing.assert_allclose(raw.table["time_s"], begin + TEST[0], rtol=0, atol=1e-6)
    np.testing.assert_allclose(raw.table["force_N"], TEST[2], atol=1e-7)
    assert "times of a clock are read as seconds, and go on after midnight" in raw.reading["notes"]
    assert raw.reading["columns"]["time_s"]["unit"] == "s"


@pytest.mark.parametrize(
    ("times", "seconds"),
    [
        (("11:59:59 AM", "12:00:00 PM", "12:00:01 p.m."), 43199.0),
        (("11:59:59 PM", "12:00:00 AM", "12:00:01 am"), 86399.0),
        (("2024-03-01T00:00:05+01:00", "2024-03-01T00:00:06+01:00", "2024-03-01T00:00:07Z"), 5.0),
        (("00:00:05:000", "00:00:06:000", "00:00:07:000"), 5.0),
        (("01:59.0", "02:00.0", "02:01.0"), 119.0),
    ],
)
def test_clocks_have_halves_of_the_day_zones_and_milliseconds(tmp_path, times, seconds):
    rows = [f"{time};0;{n}" for n, time in enumerate(times)]
    text = "\n".join(["Date/Time;Extension (mm);Load (N)", *rows, ""])
    table = read(machines.write(tmp_path / "r.csv", text)).table
    np.testing.assert_allclose(table["time_s"], seconds + np.arange(3.0))


@pytest.mark.parametrize(
    ("times", "hours"),
    [
        (("2024-02-28 23:00:00", "2024-03-01 09:00:00", "2024-03-01T23:00:00Z"), (34, 48)),
        (("2/28/2024 11:00:00 PM", "3/1/2024 9:00:00 AM", "3/1/2024 11:00:00 PM"), (34, 48)),
        (("28.02.2024 23:00:00", "01.03.2024 09:00:00", "01.03.2024 23:00:00"), (34, 48)),
        (("1.3.2024 23:00:00", "1.3.2024 01:00:00", "1.3.2024 14:00:00"), (2, 15)),
        (("23:00:00", "01:00:00", "14:00:00"), (2, 15)),
    ],
)
def test_days_are_those_of_the_dates_and_long_pauses_stay_long(tmp_path, times, hours):
    text = "Timestamp;Extension (mm);Load (N)\n" + "".join(f"{time};0;0\n" for time in times)
    time = read(machines.write(tmp_path / "r.csv", text)).table["time_s"].to_numpy()
    np.testing.assert_allclose(np.subtract(time[1:], time[0]) / 3600.0, hours)


def test_a_line_that_is_no_time_of_a_clock_is_told(tmp_path):
    lines = [
        f"{of_day(t, '{:02d}:{:02d}:{:02.0f}')};{d:.4f};{f:.5f}"
        for t, d, f in zip(*TEST, strict=True)
    ]
    titles = "Time;Extension (mm);Load (N)"
    path = machines.write(tmp_path / "r.csv", "\n".join([titles, *(f"{x[3:]}" for x in lines)]))
    with pytest.raises(InputError, match="line 2: .*; write times in seconds, or as hh:mm:ss"):
        read(path)


@pytest.mark.parametrize("named", ["Specimen 2\n", ""])
def test_blocks_without_time_may_be_of_several_specimens(tmp_path, named):
    once = plain("Time (s),Extension (mm),Load (N)")
    timeless = "\n".join(line.partition(",")[2] for line in once.splitlines()) + "\n"
    path = machines.write(tmp_path / "r.csv", f"Specimen 1\n{timeless}{named}{timeless}")
    first = named.strip() or "Extension (mm),Load (N)"
    (doubt,) = read(path).reading["doubts"]
    assert f"line {len(TEST[0]) + 3}: {first!r} begins another block, which is read as" in doubt
    assert doubt in imported(path)[1]["warnings"]
    assert read(machines.write(path, timeless)).reading["doubts"] == []
    timed = machines.wintest(*TEST)
    assert read(machines.write(path, timed)).reading["doubts"] == []


@pytest.mark.parametrize("letters", [2, 5])
def test_a_line_in_which_the_file_ends_is_left_out_and_doubted(tmp_path, letters):
    path = machines.write(tmp_path / "r.csv", machines.univert(*TEST)[: -1 - letters])
    raw = read(path)
    table, facts = imported(path)
    assert len(raw.table) == len(table) == len(TEST[2]) - 1
    (doubt,) = raw.reading["doubts"]
    assert f"line {len(TEST[2]) + 1}: the file ends within its last number, -0." in doubt
    assert doubt in facts["warnings"]


WHOLE = {
    "an end": lambda text: text[:-3] + "\n",
    "no end": lambda text: text[:-1],
    "quotes": lambda text: text[:-8] + '"-0.9"',
    "a cell behind it": lambda text: text[:-3] + ",",
    "other decimals": lambda text: text[:-3].replace(second := text.split("\n")[1], f"{second}0"),
    "few lines": lambda text: "\n".join([*text.splitlines()[:8], text.splitlines()[8][:-3]]),
}
"""What is done to a text with a last cell of fewer decimals whose last line is whole."""


@pytest.mark.parametrize("name", WHOLE)
def test_a_last_line_that_is_whole_is_read(tmp_path, name):
    text = WHOLE[name](machines.univert(*TEST))
    raw = read(machines.write(tmp_path / "r.csv", text))
    assert raw.reading["doubts"] == []
    assert raw.table.index[-1] == len(text.splitlines())


def test_the_sign_of_a_machine_is_told_not_guessed(tmp_path):
    time, travel, force = TEST
    path = machines.write(tmp_path / "r.csv", machines.univert(time, -travel, -force))
    with pytest.raises(InputError) as refused:
        imported(path)
    cure = "`records: {positive: {displacement: loading, force: loading}}`"  # of both at once
    assert str(refused.value).count(cure) == 2
    both = {"displacement": "compression", "force": "compression"}
    table, facts = imported(path, positive=both)
    np.testing.assert_allclose(table["force_N"], force)
    np.testing.assert_allclose(table["displacement_mm"], travel)
    assert facts["positive"] == {"displacement_mm": "compression", "force_N": "compression"}
    either = {"displacement": "loading", "force": "loading"}
    np.testing.assert_allclose(imported(path, positive=either)[0]["force_N"], force)
    np.testing.assert_allclose(imported(path, "tension", positive=either)[0]["force_N"], -force)


def test_zero_is_that_of_the_file_or_of_the_rest(tmp_path):
    time, travel, force = TEST
    path = machines.write(tmp_path / "r.csv", machines.univert(time, travel + 0.25, force + 0.125))
    table, facts = imported(path)
    np.testing.assert_allclose(table["displacement_mm"], travel + 0.25)
    assert facts["subtracted"] == {"displacement_mm": 0.0, "force_N": 0.0}
    table, facts = imported(path, zero={"displacement": "rest", "force": "rest"})
    np.testing.assert_allclose(table["displacement_mm"], travel, atol=1e-3)
    np.testing.assert_allclose(table["force_N"], force, atol=1e-3)
    assert facts["subtracted"]["force_N"] == pytest.approx(0.125, abs=1e-3)
    moving = machines.univert(*machines.compression(rest=0.0))
    path = machines.write(tmp_path / "m.csv", moving)
    with pytest.raises(InputError, match="no rest before the ramp to take the zero from"):
        imported(path, zero={"force": "rest"})
    moved = machines.compression(rest=0.0)[1]
    table, _ = imported(path, zero={"displacement": "start"})
    np.testing.assert_allclose(table["displacement_mm"], moved - moved[0], atol=1e-9)


def test_other_columns_of_our_own_table_are_kept_for_the_schema(tmp_path):
    rows = plain("time_s,displacement_mm,force_N").splitlines()
    normal = "\n".join([f"{rows[0]},force_normal_N", *(f"{row},0.5" for row in rows[1:])])
    table, _ = imported(machines.write(tmp_path / "n.csv", normal))
    assert (table["force_normal_N"] == 0.5).all()
    misspelt = machines.write(tmp_path / "m.csv", normal.replace("normal_N", "nornal_N"))
    with pytest.raises(InputError, match="'force_nornal_N': unknown name; did you mean"):
        imported(misspelt)


def test_a_column_without_a_title_is_passed_over(tmp_path):
    for titles in ("time_s,displacement_mm,force_N", "Time (s),Disp (mm),Load (N)"):
        rows = (f"{n},{line}" for n, line in enumerate(plain().splitlines()[1:]))
        table, facts = imported(
            machines.write(tmp_path / "r.csv", "\n".join([f",{titles}", *rows]))
        )
        np.testing.assert_allclose(table["force_N"], TEST[2], atol=1e-5)
        assert facts["reading"]["ignored"] == []


def test_a_column_that_was_named_stays_beside_one_of_our_titles(tmp_path):
    """A file of our titles with a filtered force as well; the filtered one is asked for."""
    time, travel, force = TEST
    path = tmp_path / "r.csv"
    columns = {"time_s": time, "displacement_mm": travel, "force_N": 0.5 * force}
    pd.DataFrame({**columns, "force_filtered_N": force}).to_csv(path, index=False)
    table, facts = imported(path, columns={"force": "force_filtered_N"})
    np.testing.assert_allclose(table["force_N"], force, atol=2e-6)
    assert facts["reading"]["ignored"] == ["force_N"]
    plain = pd.DataFrame(columns)
    plain.to_csv(path, index=False)
    np.testing.assert_allclose(imported(path)[0]["force_N"], 0.5 * force, atol=2e-6)


def test_a_column_may_be_named_without_its_unit(tmp_path):
    time, travel, force = TEST
    table = pd.DataFrame({"t (s)": time, "z (mm)": travel, "Fz (mN)": 1e3 * force})
    path = tmp_path / "r.csv"
    table.to_csv(path, index=False)
    names = {"time": "t", "displacement": "z", "force": "Fz"}
    np.testing.assert_allclose(imported(path, columns=names)[0]["force_N"], force, atol=2e-6)
    table.assign(Fz=0.5 * table["Fz (mN)"]).to_csv(path, index=False)
    whole = imported(path, columns=names, units={"force": "mN"})[0]
    np.testing.assert_allclose(whole["force_N"], 0.5 * force, atol=2e-6)


def workbook(path, sheets):
    """A workbook (.xlsx) of sheets by name, each of rows of cells."""
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def rows(titles=("Time (s)", "Extension (mm)", "Load (N)"), test=TEST):
    return [titles, *zip(*(column.tolist() for column in test), strict=True)]


def test_the_first_sheet_with_titles_is_read(tmp_path):
    notes = [["Operator", "made up"], [None], ["Dimension", 20.5, "mm"]]
    below = [["Time", "Extension", "Load"], ["s", "mm", "mN"], *rows()[1:]]
    path = workbook(tmp_path / "r.xlsx", {"Notes": notes, "Data": [[None], *below], "B": rows()})
    table, facts = imported(path, units={"time": "s"})
    np.testing.assert_allclose(table["force_N"], 1e-3 * TEST[2], rtol=1e-12)
    np.testing.assert_allclose(table["time_s"], TEST[0], rtol=1e-12)
    assert table.index[0] == 4  # the row of the sheet
    chosen, _ = imported(path, sheet="B")
    np.testing.assert_allclose(chosen["force_N"], TEST[2], rtol=1e-12)
    assert facts["reading"]["columns"]["force_N"]["unit"] == "mN"
    with pytest.raises(InputError, match="r.xlsx: no sheet 'C'; there are Notes, Data, B"):
        read(path, sheet="C")
    with pytest.raises(InputError, match=r"\(sheet Notes\), line 1: no column is known to hold"):
        read(path, sheet="Notes")


def test_another_sheet_that_may_be_the_test_is_doubted(tmp_path):
    untimed = [row[1:] for row in rows()]
    sheets = {"Summary": untimed, "First": rows(), "Notes": [["made up"]], "Second": rows()}
    path = workbook(tmp_path / "r.xlsx", sheets)
    first = read(path).reading
    assert first["sheet"] == "First"
    assert first["notes"] == ["sheet First is read"]
    (doubt,) = first["doubts"]
    assert "sheet First is read, and others can be: Second; name the right one" in doubt
    assert doubt.endswith("such as `records: {sheet: Second}`")
    second = read(path, sheet="Second").reading
    assert not second["doubts"]
    assert (second["sheet"], second["notes"]) == ("Second", ["sheet Second is read"])
    text = machines.write(tmp_path / "r.csv", plain("time_s,displacement_mm,force_N"))
    assert "sheet" not in read(text).reading


def test_a_hidden_sheet_is_read_only_if_it_is_named(tmp_path):
    other = rows(test=(TEST[0], TEST[1], 3.0 * TEST[2]))
    path = workbook(tmp_path / "r.xlsx", {"Old": other, "Data": rows()})
    book = openpyxl.load_workbook(path)
    book["Old"].sheet_state = "hidden"
    book.save(path)
    np.testing.assert_allclose(imported(path)[0]["force_N"], TEST[2], rtol=1e-12)
    np.testing.assert_allclose(imported(path, sheet="Old")[0]["force_N"], 3.0 * TEST[2])


def test_wrong_cells_of_a_sheet_keep_their_row(tmp_path):
    cells = [list(row) for row in rows()]
    cells[30][2] = "n/a"
    path = workbook(tmp_path / "r.xlsx", {"A": cells})
    with pytest.raises(InputError, match=r"r.xlsx, line 31, column 'force_N': 'n/a' is not"):
        imported(path)


def test_a_workbook_is_told_by_its_content(tmp_path):
    """Machines name text .xls, and workbooks are renamed."""
    text = machines.write(tmp_path / "r.xls", machines.univert(*TEST))
    np.testing.assert_allclose(imported(text)[0]["force_N"], TEST[2], atol=2e-6)
    book = workbook(tmp_path / "r.xlsx", {"A": rows()}).rename(tmp_path / "b.csv")
    np.testing.assert_allclose(imported(book)[0]["force_N"], TEST[2], atol=2e-6)


def test_elapsed_times_of_a_workbook_go_on_after_a_day(tmp_path):
    since = [timedelta(hours=23, minutes=59, seconds=50.0 + t) for t in TEST[0].tolist()]
    test = [rows()[0], *([t, *more] for t, (_, *more) in zip(since, rows()[1:], strict=True))]
    record, _ = imported(workbook(tmp_path / "r.xlsx", {"A": test}))
    np.testing.assert_allclose(record["time_s"] - record["time_s"].iloc[0], TEST[0], atol=1e-6)


def test_a_text_may_begin_as_an_archive_does(tmp_path):
    first = pd.DataFrame({"PK": TEST[0], **dict(zip(rows()[0], TEST, strict=True))})
    path = machines.write(tmp_path / "r.csv", first.to_csv(index=False))
    np.testing.assert_allclose(imported(path)[0]["force_N"], TEST[2])


@pytest.mark.parametrize(
    ("title", "is_positive"),
    [("Compressive force", True), ("Druckkraft", True), ("Decompression", False),
     ("Uncompressed height", False), ("Depth", True), ("Load", False)],
)  # fmt: skip
def test_titles_that_say_that_compression_is_positive(title, is_positive):
    assert Column("force", 0, title, "N").compressive == is_positive


def old_workbook(path, monkeypatch, content, kinds=()):
    """Nothing writes .xls any more, so the library is asked for what it would give.

    `kinds` are those of the cells of each row but the first, numbers (2) if there are none.
    """

    class Sheet:
        name, nrows, visibility = "Data", len(content), 0

        def row_values(self, number):
            return list(content[number])

        def row_types(self, number):
            return list(kinds if kinds and number else [1 + (number > 0)] * len(content[number]))

    class Book:
        datemode = 0

        def sheets(self):
            return [Sheet()]

    monkeypatch.setattr("xlrd.open_workbook", lambda *_, **__: Book())
    return machines.write(path, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(99))


def test_an_old_workbook_is_read(tmp_path, monkeypatch):
    path = old_workbook(tmp_path / "r.xls", monkeypatch, rows())
    np.testing.assert_allclose(imported(path)[0]["force_N"], TEST[2], rtol=1e-12)


def test_dates_and_errors_of_an_old_workbook_are_no_numbers(tmp_path, monkeypatch):
    titles, *numbers = rows()
    days = [[titles[0].split(" ")[0], *titles[1:]], *([t / 86400.0, *more] for t, *more in numbers)]
    path = old_workbook(tmp_path / "d.xls", monkeypatch, days, [3, 2, 2])
    np.testing.assert_allclose(imported(path)[0]["time_s"], TEST[0], atol=1e-3)
    path = old_workbook(tmp_path / "e.xls", monkeypatch, [titles, [0.0, 0.0, 42]], [2, 2, 5])
    with pytest.raises(InputError, match="'#N/A' is not a number"):
        imported(path)


@pytest.mark.parametrize("first", [b"PK\3\4", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"])
def test_a_damaged_workbook_is_refused(tmp_path, first):
    path = machines.write(tmp_path / "r.xlsx", first + bytes(600))
    with pytest.raises(InputError, match="r.xlsx: damaged or not of its kind"):
        read(path)


def test_a_workbook_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    path = workbook(tmp_path / "r.xlsx", {"A": rows()})
    monkeypatch.setattr("softsample.formats.workbook.LARGEST_BYTES", 1000)
    with pytest.raises(InputError, match="r.xlsx: unpacks to more than 0 MiB; export as CSV"):
        read(path)


class Size:
    """Of a sample with dimensions."""

    area, height = 2e-4, 20e-3


MATERIAL = {
    "percent": ("Strain (%)", "Stress (kPa)", 100.0, 1e-3),
    "plain": ("Strain", "Stress [Pa]", 1.0, 1.0),
    "engineering": ("Engineering strain %", "Nominal stress (MPa)", 100.0, 1e-6),
    "a small p": ("Engineering strain %", "Nominal stress (Mpa)", 100.0, 1e-6),
    "sheared": ("Shear strain [-]", "Shear stress (psi)", 1.0, 1 / 6894.757293168361),
    "ours": ("strain", "stress_Pa", 1.0, 1.0),
}


@pytest.mark.parametrize("name", MATERIAL)
def test_stress_and_strain_are_read(tmp_path, name):
    strain, stress, times, per = MATERIAL[name]
    time, travel, force = TEST
    cells = times * travel / 20.0, per * force / 2e-4
    frame = pd.DataFrame({"Time (s)": time, strain: cells[0], stress: cells[1]})
    frame.to_csv(tmp_path / "r.csv", index=False)
    raw, given = read(tmp_path / "r.csv"), settings()
    test = (raw.table, raw.reading, "compression", given, SCHEMA, "r.csv")
    table, _ = aligned_record(*test, Size())
    np.testing.assert_allclose(table["displacement_mm"], travel, atol=1e-9)
    np.testing.assert_allclose(table["force_N"], force, atol=1e-9)
    with pytest.raises(InputError, match="need dimensions"):
        aligned_record(*test)


def test_stretch_is_read_and_force_goes_before_stress(tmp_path):
    time, travel, force = TEST
    titles = ("Time (s)", "lambda", "Stress (kPa)", "Load (N)")
    frame = pd.DataFrame(dict(zip(titles, (time, 1 + travel / 20, 9 * force, force), strict=True)))
    frame.to_csv(tmp_path / "r.csv", index=False)
    raw = read(tmp_path / "r.csv")
    assert list(raw.table) == ["time_s", "stretch", "force_N"]
    assert raw.reading["ignored"] == ["Stress (kPa)"]
    named = read(tmp_path / "r.csv", {"stress": "Stress (kPa)"})
    assert list(named.table) == ["time_s", "stretch", "stress_Pa"]
    np.testing.assert_allclose(named.table["stress_Pa"], 9e3 * force)


OWN_SIZE = {
    "both": ("Strain (%),Stress (kPa)", {"height_mm": 25.0, "area_mm2": 80.0}),
    "below 0 in compression": ("Strain (%),Compressive stress (kPa)", {"height_mm": 25.0}),
    "a strain without a unit": ("Strain,Stress (MPa)", {"area_mm2": 0.08}),
    "two strains": ("Strain 1 (%),Strain 2 (%)", {}),
    "another unit": ("Strain (%),Stress (N)", {"height_mm": 25.0}),
}


@pytest.mark.parametrize("name", OWN_SIZE)
def test_the_dimensions_that_a_file_was_made_with_are_found(tmp_path, name):
    titles, own = OWN_SIZE[name]
    time, travel, force = TEST
    test = (time, travel + 3.0, force, travel / 25.0 * 100.0, 1e3 * force / 80.0)
    rows = "\n".join(",".join(f"{x:.6f}" for x in row) for row in zip(*test, strict=True))
    path = machines.write(tmp_path / "r.csv", f"Time (s),Disp (mm),Load (N),{titles}\n{rows}\n")
    found = read(path, mode="compression").reading["own_size"]
    assert {name: found.get(name) for name in own} == pytest.approx(own, rel=1e-3)


def test_a_strain_of_another_shape_tells_no_height(tmp_path):
    time, travel, force = TEST
    rows = "\n".join(
        ",".join(f"{x:.6f}" for x in row)
        for row in zip(time, travel, force, np.log(1.0 + travel / 20.0), strict=True)
    )
    titles = "Time (s),Disp (mm),Load (N),Strain (mm/mm)"
    path = machines.write(tmp_path / "r.csv", f"{titles}\n{rows}\n")
    assert read(path).reading["own_size"] == {}


def test_a_file_without_time_is_read_and_told(tmp_path):
    lines = [f"{d:.4f};{f:.5f}" for d, f in zip(*TEST[1:], strict=True)]
    lines[40:40] = lines[39:40]  # the same twice is a sample like others
    path = machines.write(tmp_path / "r.csv", "\n".join(["Disp (mm);Load (N)", *lines]))
    raw = read(path)
    assert list(raw.table) == ["displacement_mm", "force_N"]
    assert len(raw.table) == len(lines)
    assert any("no time" in line for line in described(raw.reading))
    with pytest.raises(InputError, match="no column is called 't' .*correct `columns`"):
        read(path, {"time": "t"})


def test_titles_with_time_go_before_metadata_that_looks_like_titles(tmp_path):
    text = "Load (N),Extension (mm)\nlimit,limit\n" + plain("Time (s),Extension (mm),Load (N)")
    assert read(machines.write(tmp_path / "r.csv", text)).table.index[0] == 4


def test_channels_that_are_named_are_read_too(tmp_path):
    time, travel, force = TEST
    titles = ("Time (s)", "Disp (mm)", "Force (N)", "Fz (mN)", "Mz [N m]")
    frame = pd.DataFrame(
        dict(zip(titles, (time, travel, force, 200 * force, 0.01 * force), strict=True))
    )
    frame.to_csv(tmp_path / "r.csv", index=False)
    assert read(tmp_path / "r.csv").reading["ignored"] == ["Fz (mN)", "Mz [N m]"]
    names = {"force_normal": "Fz (mN)", "torque": "Mz [N m]"}
    table, _ = imported(tmp_path / "r.csv", columns=names)
    np.testing.assert_allclose(table["force_normal_N"], 0.2 * force, atol=1e-9)
    np.testing.assert_allclose(table["torque_Nmm"], 10.0 * force, atol=1e-9)
    with pytest.raises(InputError, match="no column is called 'Fx'"):
        read(tmp_path / "r.csv", {"force_normal": "Fx"})


def test_our_own_results_can_be_read_again(tmp_path):
    first, _ = imported(ROOT / "resources/cohort/records/C1.csv")
    first.to_csv(tmp_path / "r.csv", index=False)
    again, facts = imported(tmp_path / "r.csv")
    pd.testing.assert_frame_equal(again.reset_index(drop=True), first.reset_index(drop=True))
    assert facts["reading"]["ignored"] == ["phase", "cycle", "calibrated"]
