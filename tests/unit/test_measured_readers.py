"""Readers of others' files: units, signs, refusals, on made-up files; real ones if present."""

import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from softsample.errors import InputError
from softsample.io import read_table
from softsample.measured.catalogue import check_files, check_folder
from softsample.measured.files import workbook_rows
from softsample.measured.readers import (
    READERS,
    brain,
    clot_pure_shear,
    clot_shear,
    cryogel,
    ecoflex,
)

ROOT = Path(__file__).resolve().parents[2]
CATALOGUE = read_table(ROOT / "config/measured.tsv")
MEASURED = Path(os.environ.get("SOFTSAMPLE_MEASURED_ROOT", ROOT / "resources/measured"))


def written(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def phantom(folder, stress_factor=1.0, load="Load (N)"):
    """Two rows of a silicone phantom of 50 x 30 mm: 19.635 N are 10 kPa."""
    kpa = -10.0 * stress_factor
    return written(
        folder / "data/EF99_0T/EF99_0T_A3.csv",
        "EF99_0T_A_sample_3\nCompression test;\nCylinder Diameter: 50mm;\nCylinder Height: 30mm;\n"
        "Speed (mm/min): 10;\nMachine: INSTRON 5900;\nLoad cell: 1kN;\n"
        f"Time (s),Compression (mm),{load},Engineering Strain [-],Engineering Stress (kPa)\n"
        f"0.0,0.0,0.0,0,0\n6.0,3.0,19.635,-0.1,{kpa}\n",
    )


def test_phantom_is_pushed_and_pushes_back(tmp_path):
    phantom(tmp_path)
    (test,) = ecoflex.read(tmp_path)
    assert (test.name, test.group, test.specimen, test.mode) == (
        "EF99_0T_A3", "EF99_0T", "A", "compression",
    )  # fmt: skip
    assert test.shape.height == pytest.approx(0.03)
    assert test.shape.area == pytest.approx(np.pi * 0.025**2)
    assert test.record.displacement[-1] == pytest.approx(-3e-3)  # m
    assert test.record.force[-1] == pytest.approx(-19.635)  # N
    assert test.strain[-1] == pytest.approx(-0.1)
    assert test.table["displacement_mm"].iloc[-1] == pytest.approx(-3.0)
    assert ecoflex.load_cells(tmp_path) == {"EF99_0T_A3": "1kN"}


def test_phantom_in_another_unit_is_refused(tmp_path):
    with pytest.raises(InputError, match="differ by .* is a unit another one"):
        ecoflex.read_file(phantom(tmp_path, stress_factor=1e-3))
    with pytest.raises(InputError, match=r"no column 'Load \(N\)'"):
        ecoflex.read_file(phantom(tmp_path, load="Load (kN)"))


def workbook(path, rows):
    """A workbook as small as can be, texts shared as spreadsheets do."""
    texts = [cell for row in rows for cell in row.values() if isinstance(cell, str)]
    space = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
    cells = "".join(
        f'<row r="{k}">'
        + "".join(
            f'<c r="{letter}{k}" t="s"><v>{texts.index(cell)}</v></c>'
            if isinstance(cell, str)
            else f'<c r="{letter}{k}"><v>{cell}</v></c>'
            for letter, cell in row.items()
        )
        + "</row>"
        for k, row in enumerate(rows, start=1)
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        shared = "".join(f"<si><t>{text}</t></si>" for text in texts)
        archive.writestr("xl/sharedStrings.xml", f"<sst {space}>{shared}</sst>")
        sheet = f"<worksheet {space}><sheetData>{cells}</sheetData></worksheet>"
        archive.writestr("xl/worksheets/sheet1.xml", sheet)
    return path


def test_workbook_gives_its_cells_as_text(tmp_path):
    rows = [{"A": "name", "C": 2.5}, {"B": "name"}]
    found = workbook_rows(workbook(tmp_path / "w.xlsx", rows))
    assert found == [{"A": "name", "C": "2.5"}, {"B": "name"}]
    with pytest.raises(InputError, match="not a readable workbook"):
        workbook_rows(written(tmp_path / "no.xlsx", "text"))


TRACE = "g\tg\tg\t\nForce\tDistance\tTime\t\n{unit}\tmm\tsec\t\n\n"


def gel(folder, unit="g"):
    """A gel of 5 mm that is touched at 0.5 mm, 2.5 mm below the start: 2 mm high."""
    listing = [
        dict(zip("ABCDE", cryogel.LISTED, strict=True)),
        {"A": "one.tab", "B": "Z_9p\\syringe_1", "C": 5, "D": 2.5, "E": 0.5},
        {"C": 7},  # a row that names no file
    ]
    workbook(folder / "samples/file_listing.xlsx", listing)
    return written(
        folder / "samples/Z_9p/syringe_1/one.tab",
        TRACE.format(unit=unit) + "0.0\t0.0\t0\t\n10.0\t1.1\t110\t\n0.5\t0.5\t170\t\n",
    )


def test_gel_starts_above_its_touch_point_and_gram_is_force(tmp_path):
    gel(tmp_path)
    (test,) = cryogel.read(tmp_path)
    assert test.group == "Z_9p"
    assert test.shape.height == pytest.approx(2e-3)
    np.testing.assert_allclose(test.record.displacement, [0.5e-3, -0.6e-3, 0.0], atol=1e-12)
    np.testing.assert_allclose(test.strain, [0.25, -0.3, 0.0], atol=1e-12)
    assert test.record.force[1] == pytest.approx(-0.0980665)  # 10 g
    with pytest.raises(InputError, match="no column 'g'"):
        cryogel.read_trace(gel(tmp_path, unit="N"))


def test_stiffness_of_the_bench_is_the_slope_on_the_way_down(tmp_path):
    """1000 g for each mm from 1 mm on, and a way up that does not count."""
    down = "".join(f"{max(0.0, 1e3 * (d - 1.0))}\t{d}\t{d}\t\n" for d in np.arange(0.0, 2.0, 0.05))
    path = written(tmp_path / "bench.tab", TRACE.format(unit="g") + down + "7\t1.5\t9\t\n")
    slope = cryogel.stiffness(cryogel.read_trace(path), 50.0)
    assert slope == pytest.approx(9806.65, rel=1e-6)  # N/m


def clot(folder, sign=1.0, factor=1.0):
    """Shear force 0.1 N per strain, normal force 0.2 N per strain squared, both with an offset."""
    strain = np.linspace(-0.45, 0.55, 101)
    lines = [
        f"{s},{factor * (sign * 0.1 * s + 0.003)},{factor * (0.2 * s**2 + 0.002)}" for s in strain
    ]
    path = folder / "ExperimentalBloodClotData/C1_T2_y.csv"
    return written(path, "Strain,Fx,Fz\n" + "\n".join(lines) + "\n")


def test_clot_loses_offsets_by_its_two_ways(tmp_path):
    clot(tmp_path)
    (test,) = clot_shear.read(tmp_path)
    assert (test.group, test.specimen, test.mode, test.timed) == ("C1_T2", "y", "shear", False)
    assert test.strain[-1] == pytest.approx(0.45)  # the shorter way
    assert test.record.displacement[-1] == pytest.approx(4.5e-3)
    np.testing.assert_allclose(test.record.force, 0.1 * test.strain, atol=1e-12)
    np.testing.assert_allclose(test.record.force_normal, 0.2 * test.strain**2, atol=2e-5)
    assert test.table["force_normal_N"].iloc[-1] == pytest.approx(0.2 * 0.45**2, abs=2e-5)


def test_clot_in_millinewtons_or_turned_round_is_refused(tmp_path):
    with pytest.raises(InputError, match="is the file in mN"):
        clot_shear.read_file(clot(tmp_path, factor=1e3))
    with pytest.raises(InputError, match="sign is not that of shear"):
        clot_shear.read_file(clot(tmp_path, sign=-1.0))


def test_strip_is_pulled_in_millinewtons(tmp_path):
    written(tmp_path / "example_data.txt", "0\t0\n2.5\t200\n5\t400\n")
    (test,) = clot_pure_shear.read(tmp_path)
    assert test.mode == "tension"
    assert test.record.force[-1] == pytest.approx(0.4)
    assert test.strain[-1] == pytest.approx(0.5)
    assert (test.shape.length, test.shape.width) == pytest.approx((0.04, 0.003))
    written(tmp_path / "example_data.txt", "0\t0\n5\t0.4\n")
    with pytest.raises(InputError, match="is the file in N"):
        clot_pure_shear.read(tmp_path)


def averages(folder, unit="[kPa]"):
    """Stress 3 kPa times (stretch - 1), and 1 kPa times the amount of shear, in every region."""
    header = [{}, {}, {}, {}]
    rows = [{} for _ in range(5)]
    for region, letters in brain.BLOCKS.items():
        for kind, (x, y) in zip(("comten", "shr"), letters.split(), strict=True):
            header[1] |= {x: f"{region}-{kind}", y: f"{region}-{kind}"}
            header[3] |= {x: "[-]", y: unit}
            for row, s in zip(rows, (-0.2, -0.1, 0.0, 0.1, 0.2), strict=True):
                row |= {x: 1.0 + s, y: 3.0 * s} if kind == "comten" else {x: s, y: s}
    return workbook(folder / "CANNsBRAINdata.xlsx", header + rows)


def test_brain_is_split_into_modes_from_zero_outward(tmp_path):
    averages(tmp_path)
    tests = {test.name: test for test in brain.read(tmp_path)}
    assert len(tests) == 12
    pushed = tests["CR_compression"]
    np.testing.assert_allclose(pushed.strain, [0.0, -0.1, -0.2], atol=1e-12)
    assert pushed.record.force[-1] == pytest.approx(-0.6e3 * 25e-6)  # 0.6 kPa on 5 x 5 mm
    assert tests["BG_tension"].record.force[-1] == pytest.approx(0.6e3 * 25e-6)
    assert tests["CC_shear"].record.force[-1] == pytest.approx(0.2e3 * 25e-6)
    averages(tmp_path, unit="[Pa]")
    with pytest.raises(InputError, match="not region CX in kPa"):
        brain.read(tmp_path)


def test_absent_data_are_said_plainly_with_where_to_get_them(tmp_path):
    with pytest.raises(InputError) as found:
        check_folder(tmp_path, CATALOGUE)
    for name in READERS:
        assert name in str(found.value)
    assert "github.com/abubakardawood" in str(found.value)
    assert "SOFTSAMPLE_MEASURED_ROOT" in str(found.value)


def test_changed_file_is_refused(tmp_path):
    row = CATALOGUE[CATALOGUE["set"] == "bloodclot-pureshear"]
    written(tmp_path / "bloodclot-pureshear/example_data.txt", "0 0\n")
    with pytest.raises(InputError, match="not that of the published file"):
        check_files(tmp_path, row)
    with pytest.raises(InputError, match="not there; fetch it from github"):
        check_files(tmp_path / "elsewhere", row)


def test_catalogue_names_source_licence_and_sum_of_every_set():
    assert set(CATALOGUE["set"]) == set(READERS)
    assert CATALOGUE[["source", "licence"]].notna().all().all()
    assert CATALOGUE["sha256"].str.fullmatch("[0-9a-f]{64}").all()


@pytest.mark.skipif(
    not MEASURED.is_dir(), reason=f"measured data not at {MEASURED}; set SOFTSAMPLE_MEASURED_ROOT"
)
@pytest.mark.parametrize(("name", "count"), [
    ("ecoflex-phantoms", 190), ("cmc-cryogel", 6), ("blood-clot-myocardium", 27),
    ("bloodclot-pureshear", 1), ("brain-budday", 12),
])  # fmt: skip
def test_real_files_are_read_whole(name, count):
    """Every record loads away from zero, against its travel; moduli are those of soft matter."""
    check_files(MEASURED, CATALOGUE[CATALOGUE["set"] == name])
    tests = READERS[name].read(MEASURED / name)
    assert len({test.name for test in tests}) == len(tests) == count
    for test in tests:
        end = int(np.abs(test.record.displacement).argmax())
        force, strain = test.record.force[end], test.strain[end]
        assert force * strain > 0.0, test.name
        assert 100.0 < force / test.shape.area / strain < 2e6, test.name  # Pa, secant
        assert np.sign(strain) == (-1.0 if test.mode == "compression" else 1.0)
