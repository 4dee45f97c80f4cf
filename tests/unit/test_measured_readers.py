"""Readers of the measured sets: units, signs and refusals on made-up files; real ones if present.

The real files are third-party data. What is expected of them is what their sources state.
"""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from softsample.errors import InputError
from softsample.holdout import Selection
from softsample.io import read_table
from softsample.measured.catalogue import check_files, check_folder
from softsample.measured.files import sheets
from softsample.measured.folder import chosen_studies
from softsample.measured.readers import (
    READERS,
    brain,
    clots,
    cryogel,
    ecoflex,
    muscle,
    mycelium,
    myocardium,
    pure_shear,
)

ROOT = Path(__file__).resolve().parents[2]
CATALOGUE = read_table(ROOT / "config/measured.tsv")
PLACES = [
    Path(os.environ.get("SOFTSAMPLE_MEASURED_ROOT", ROOT / "resources/measured")),
    ROOT.parent / "shared/measured",
]
MEASURED = next((place for place in PLACES if place.is_dir()), PLACES[0])
real = pytest.mark.skipif(
    not MEASURED.is_dir(), reason=f"measured data not at {MEASURED}; set SOFTSAMPLE_MEASURED_ROOT"
)


def written(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def workbook(path, **book):
    path.parent.mkdir(parents=True, exist_ok=True)
    with pd.ExcelWriter(path, engine="openpyxl") as writer:
        for name, rows in book.items():
            frame = pd.DataFrame(rows)
            frame.to_excel(writer, sheet_name=name, header=False, index=False)
    return path


def read_real(name):
    """Samples of a reader by their names; its files must be the published ones."""
    reader = READERS[name]
    check_files(MEASURED, CATALOGUE[CATALOGUE["set"] == reader.set])
    samples = reader.read(MEASURED / reader.set)
    assert len({sample.name for sample in samples}) == len(samples)
    return {sample.name: sample for sample in samples}


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
    (sample,) = ecoflex.read(tmp_path)
    assert (sample.name, sample.group, sample.specimen) == ("EF99_0T_A3", "EF99_0T", "EF99_0T_A")
    assert sample.mode == "compression"
    assert sample.shape == {"shape": "cylinder", "height_mm": 30.0, "diameter_mm": 50.0}
    assert sample.record.iloc[-1].to_dict() == pytest.approx(
        {"time_s": 6.0, "displacement_mm": -3.0, "force_N": -19.635}
    )
    assert sample.strain.iloc[-1] == pytest.approx(-0.1)


def test_phantom_in_another_unit_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"differ by .* is a unit another one"):
        ecoflex.read_file(phantom(tmp_path, stress_factor=1e-3))
    with pytest.raises(InputError, match=r"no column 'Load \(N\)'"):
        ecoflex.read_file(phantom(tmp_path, load="Load (kN)"))


@real
def test_real_phantoms():
    """19 materials, two specimens, five repeats, 10 mm/min to 66.7 %."""
    samples = read_real("ecoflex")
    assert len(samples) == 190
    assert len({s.group for s in samples.values()}) == 19
    for sample in samples.values():
        assert (sample.shape["diameter_mm"], sample.shape["height_mm"]) == (50.0, 30.0)
        assert sample.strain.min() == pytest.approx(-0.667, abs=1e-3)
        speed = np.ptp(sample.record["displacement_mm"]) / np.ptp(sample.record["time_s"])
        assert 60.0 * speed == pytest.approx(10.0, rel=0.02)
        assert sample.record["force_N"].iloc[-1] < -50.0
    strain, repeats = map(
        Selection.of, chosen_studies()["ecoflex-phantoms"]["settings"]["hold_out"]
    )
    assert strain.strain_above == 0.5
    rows = [{"sample": s.name, "group": s.group, "mode": s.mode} for s in samples.values()]
    held_out = {row["sample"] for row in rows if repeats.fits(row)}
    assert held_out == {f"{s.group}_B{k}" for s in samples.values() for k in (2, 3, 4, 5)}


TRACE = "g\tg\tg\t\nForce\tDistance\tTime\t\n{unit}\tmm\tsec\t\n\n"


def gel(folder, unit="g"):
    """A gel of 5 mm that is touched at 0.5 mm, 2.5 mm below the start: 2 mm high."""
    rows = [cryogel.LISTED, ("one.tab", "Z_9p\\syringe_1", 5, 2.5, 0.5)]
    of_no_file = (None, None, 7, None, None)
    workbook(folder / "samples/file_listing.xlsx", listing=[*rows, of_no_file])
    return written(
        folder / "samples/Z_9p/syringe_1/one.tab",
        TRACE.format(unit=unit) + "0.0\t0.0\t0\t\n10.0\t1.1\t110\t\n0.5\t0.5\t170\t\n",
    )


def test_gel_starts_above_its_touch_point_and_gram_is_force(tmp_path):
    gel(tmp_path)
    (sample,) = cryogel.read(tmp_path)
    assert (sample.name, sample.group) == ("Z_9p", "Z_9p")
    assert sample.shape["height_mm"] == pytest.approx(2.0)
    np.testing.assert_allclose(sample.record["displacement_mm"], [0.5, -0.6, 0.0], atol=1e-12)
    np.testing.assert_allclose(sample.strain, [0.25, -0.3, 0.0], atol=1e-12)
    assert sample.record["force_N"][1] == pytest.approx(-0.0980665)  # 10 g
    with pytest.raises(InputError, match="no column 'g'"):
        cryogel.read_trace(gel(tmp_path, unit="N"))


@real
def test_real_gels():
    """Six concentrations, one load-unload cycle at 0.01 mm/s and 200 Hz, 1.95 to 2.9 mm high."""
    samples = read_real("cryogel")
    assert list(samples) == ["F_0_75p", "E_1p", "D_1_5p", "C_2p", "B_2_5p", "A_3p"]
    heights = [float(sample.shape["height_mm"]) for sample in samples.values()]
    assert (min(heights), max(heights)) == pytest.approx((1.95, 2.9))
    for sample in samples.values():
        assert sample.shape["diameter_mm"] == 5.0
        time, travel = sample.record["time_s"], sample.record["displacement_mm"]
        assert np.median(np.diff(time)) == pytest.approx(0.005)
        lowest = int(travel.argmin())
        assert travel.iloc[-1] > travel.iloc[lowest] + 1.0  # it comes back
        down = np.diff(travel[:lowest]).sum() / np.diff(time[:lowest]).sum()
        assert down == pytest.approx(-0.01, rel=0.02)
        assert sample.record["force_N"].min() < -0.02


def clot(folder, sign=1.0, factor=1.0):
    """Shear force 0.1 N per strain, normal force 0.2 N per strain squared, both with an offset."""
    strain = np.linspace(-0.45, 0.55, 101)
    lines = [
        f"{s},{factor * (sign * 0.1 * s + 0.003)},{factor * (0.2 * s**2 + 0.002)}" for s in strain
    ]
    path = folder / "ExperimentalBloodClotData/C1_T2_y.csv"
    return written(path, "Strain,Fx,Fz\n" + "\n".join(lines) + "\n")


def test_clot_keeps_both_directions_and_both_channels(tmp_path):
    clot(tmp_path)
    (sample,) = clots.read(tmp_path)
    assert (sample.name, sample.group, sample.mode) == ("C1_T2_y", "C1_T2", "shear")
    assert list(sample.record) == ["displacement_mm", "force_N", "force_normal_N"]
    first, last = sample.record.iloc[0], sample.record.iloc[-1]
    np.testing.assert_allclose(first, [-4.5, -0.042, 0.0425], atol=1e-12)
    np.testing.assert_allclose(last, [5.5, 0.058, 0.0625], atol=1e-12)


def test_clot_in_millinewtons_or_turned_round_is_refused(tmp_path):
    with pytest.raises(InputError, match="is the file in mN"):
        clots.read_file(clot(tmp_path, factor=1e3))
    with pytest.raises(InputError, match="sign is not that of shear"):
        clots.read_file(clot(tmp_path, sign=-1.0))


@real
def test_real_clots():
    """Nine conditions of three clots, 100 rows from a strain of -0.5 to 0.5."""
    samples = read_real("clots")
    assert len(samples) == 27
    assert pd.Series([s.group for s in samples.values()]).value_counts().eq(3).all()
    for sample in samples.values():
        assert len(sample.record) == 100
        assert sample.strain.iloc[0] == pytest.approx(-0.5, abs=0.03)
        assert sample.strain.iloc[-1] == pytest.approx(0.5, abs=0.03)
        assert (np.diff(sample.strain) > 0.0).all()
        # tension on the platens both ways, beside which the one in the middle is small
        ends = sample.record["force_normal_N"].iloc[[0, -1]]
        middle = np.interp(0.0, sample.strain, sample.record["force_normal_N"])
        assert (ends > abs(middle)).all()


def heart(folder, factor=1.0):
    """Mode 3 in tension and compression, mode 4 in shear; 0.5 N per strain, cubes of 8 to 12 mm."""
    place = folder / "ExperimentalMyocardiumData/TSL7"
    edges = (9, 8, 10, 11, 7, 12, 9, 9, 9)
    written(place / "WDH_Params.csv", ",".join(str(factor * edge) for edge in edges))
    rows = [f"{s} , {0.5 * s} , {0.3 * s * s}" for s in (-0.3, -0.1, 0.1, 0.3)]
    written(place / "ForceStrain_M4.csv", "Strain, Fx, Fz \n" + "\n".join(rows))
    rows = [f"{s} , {0.5 * s}" for s in (-0.3, -0.1, 0.1, 0.3)]
    written(place / "ForceStrain_M3.csv", "Strain, Fz \n" + "\n".join(rows))
    return place


def test_every_third_mode_of_a_heart_is_axial_and_its_third_edge_the_height(tmp_path):
    place = heart(tmp_path)
    (sheared,) = myocardium.read_mode(place, 4)
    assert (sheared.name, sheared.mode, sheared.specimen) == ("TSL7_M4", "shear", "TSL7_2")
    assert [sheared.shape[f"{edge}_mm"] for edge in ("length", "width", "height")] == [11, 7, 12]
    np.testing.assert_allclose(sheared.record.iloc[0], [-3.6, -0.15, 0.027], atol=1e-12)
    pulled, pushed = myocardium.read_mode(place, 3)
    assert (pulled.mode, pushed.mode) == ("tension", "compression")
    np.testing.assert_allclose(pulled.record["displacement_mm"], [1.0, 3.0])
    np.testing.assert_allclose(pushed.record["displacement_mm"], [-1.0, -3.0])
    np.testing.assert_allclose(pushed.record["force_N"], [-0.05, -0.15])
    with pytest.raises(InputError, match="not between 1 and 50 mm"):
        myocardium.read_mode(heart(tmp_path, factor=1e-3), 3)


@real
def test_real_hearts():
    """Eleven hearts, nine modes; the platen went a round number of half millimetres each time."""
    samples = read_real("myocardium")
    assert len({s.group for s in samples.values()}) == 11
    counts = pd.Series([s.mode for s in samples.values()]).value_counts().to_dict()
    assert counts == {"shear": 66, "tension": 33, "compression": 33}
    for sample in samples.values():
        halves = 2.0 * (sample.record["displacement_mm"].abs().max() - 0.022)
        assert halves == pytest.approx(round(halves), abs=0.01), sample.name
        assert ("force_normal_N" in sample.record) == (sample.mode == "shear")
        assert sample.record["force_N"].abs().max() < 1.0


def test_strip_is_pulled_in_millinewtons(tmp_path):
    written(tmp_path / "example_data.txt", "0\t0\n2.5\t200\n5\t400\n")
    (sample,) = pure_shear.read(tmp_path)
    assert sample.mode == "pure_shear"
    assert sample.record["force_N"].iloc[-1] == pytest.approx(0.4)
    assert sample.strain.iloc[-1] == pytest.approx(0.5)
    assert [sample.shape[f"{edge}_mm"] for edge in ("length", "width", "height")] == [40, 3, 10]
    written(tmp_path / "example_data.txt", "0\t0\n5\t0.4\n")
    with pytest.raises(InputError, match="is the file in N"):
        pure_shear.read(tmp_path)


@real
def test_real_strip():
    (sample,) = read_real("pure_shear").values()
    assert len(sample.record) == 1068
    assert sample.record["displacement_mm"].max() == pytest.approx(5.0, abs=0.01)
    assert sample.record["force_N"].max() == pytest.approx(0.4766, abs=1e-4)


def averages(folder, unit="[kPa]"):
    """Stress 3 kPa times (stretch - 1), and 1 kPa times the amount of shear, in every region."""
    titles = [f"{region}-{kind}" for region in brain.REGIONS for kind in ("comten", "shr")]
    columns = {}
    for k, title in enumerate(titles):
        strain = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
        x, y = (1.0 + strain, 3.0 * strain) if title.endswith("comten") else (strain, strain)
        columns[2 * k] = ["Budday17", title, "lambda", "[-]", *x]
        columns[2 * k + 1] = ["Budday17", title, "P", unit, *y]
    return workbook(folder / "CANNsBRAINdata.xlsx", Sheet1=columns)


def test_brain_is_split_into_modes_from_zero_outward(tmp_path):
    averages(tmp_path)
    samples = {sample.name: sample for sample in brain.read(tmp_path)}
    assert len(samples) == 12
    pushed = samples["CR_compression"]
    np.testing.assert_allclose(pushed.strain, [0.0, -0.1, -0.2], atol=1e-12)
    assert pushed.record["force_N"].iloc[-1] == pytest.approx(-0.6e-3 * 25)  # 0.6 kPa on 25 mm2
    assert samples["BG_tension"].record["force_N"].iloc[-1] == pytest.approx(0.6e-3 * 25)
    assert samples["CC_shear"].record["force_N"].iloc[-1] == pytest.approx(0.2e-3 * 25)
    averages(tmp_path, unit="[Pa]")
    with pytest.raises(InputError, match="headed 'CX-comten', the second in kPa"):
        brain.read(tmp_path)


@real
def test_real_brain():
    """Cortex in compression at 10 %: -1.1484 kPa; shear is published with its mirror image."""
    samples = read_real("brain")
    assert len(samples) == 12
    pushed = samples["CX_compression"]
    assert pushed.strain.iloc[-1] == pytest.approx(-0.1)
    assert pushed.record["force_N"].iloc[-1] == pytest.approx(-1.1484e-3 * 25)
    sheet = next(iter(sheets(MEASURED / "brain-budday/CANNsBRAINdata.xlsx").values()))
    for column in (3, 8, 13, 18):
        stress = sheet.iloc[4:, column].dropna().to_numpy(float)
        np.testing.assert_array_equal(stress, -stress[::-1])


SEGMENT = [
    ("Axial", "", "", "", ""),
    ("Step time", "Temperature", "Normal stress", "Axial force", "Gap"),
]


def plug(folder, unit="N", sign=1.0):
    """Gaps of 10 and 5 mm; 1 N on 8 mm diameter is a rheometer's normal stress of 39.789 kPa."""
    pressed = [0.2, 25.0, sign * 39788.736, sign * 1.0, 5000.0]
    free = [0.1, 25.0, 0.0, 0.0, 10000.0]
    units = ("s", "°C", "Pa", unit, "µm")
    down, up = [free, [10.0, *pressed[1:]]], [[0.1, *pressed[1:]], [10.1, *free[1:]]]
    segments = zip(mycelium.SEGMENTS, (down, up, down, up), strict=True)
    book = {name: [*SEGMENT, units, *rows] for name, rows in segments}
    path = workbook(folder / "book.xlsx", **book)
    return path.rename(folder / "double-compression-slow-outplane-4.xlsx")


def test_plug_has_two_cycles_on_one_clock(tmp_path):
    sample = mycelium.read_file(plug(tmp_path))
    assert (sample.name, sample.group, sample.cycle) == ("slow_4", "slow", "first")
    assert sample.shape["height_mm"] == pytest.approx(10.0)
    np.testing.assert_allclose(
        sample.record["time_s"], [0.1, 10.0, 10.1, 20.1, 20.2, 30.1, 30.2, 40.2]
    )
    np.testing.assert_allclose(sample.record["displacement_mm"], [0, -5, -5, 0] * 2, atol=1e-12)
    np.testing.assert_allclose(sample.record["force_N"], [0, -1, -1, 0] * 2, atol=1e-12)


def test_plug_in_another_unit_or_pulled_is_refused(tmp_path):
    with pytest.raises(InputError, match="no column 'Axial force N'"):
        mycelium.read_file(plug(tmp_path, unit="mN"))
    with pytest.raises(InputError, match="not positive at the smallest gap"):
        mycelium.read_file(plug(tmp_path, sign=-1.0))


@real
def test_real_plugs():
    """Ten plugs at each of two speeds, 0.025 and 0.0025 /s, twice to 50 %, 8 to 12 mm high."""
    samples = read_real("mycelium")
    speeds = {"slowest": 0.025, "slowestslow": 0.0025}
    assert pd.Series([s.group for s in samples.values()]).value_counts().to_dict() == {
        "slowest": 10, "slowestslow": 10,
    }  # fmt: skip
    for sample in samples.values():
        assert 8.0 < float(sample.shape["height_mm"]) < 12.0
        assert sample.strain.min() == pytest.approx(-0.5, abs=0.01)
        time = sample.record["time_s"].to_numpy()
        assert (np.diff(time) > 0.0).all()
        rates = np.abs(np.diff(sample.strain)) / np.diff(time)
        assert np.median(rates) == pytest.approx(speeds[sample.group], rel=0.06)
        half = len(time) // 2
        force = sample.record["force_N"].to_numpy()
        first, second = force[:half].min(), force[half:].min()
        assert first < second < -0.5  # softer the second time


def curve(folder, sign=1.0, title="y"):
    """Cauchy stress -0.8 kPa at a stretch of 0.8; the raw clock `x` starts late."""
    rows = [("x", title, "t-s", "str"), (9.0, 0.0, 0.0, 1.0), (29.0, -0.8 * sign, 20.0, 0.8)]
    return workbook(folder / "muscle.xlsx", XF_20=rows)


def test_cauchy_stress_over_stretch_is_force_over_first_area(tmp_path):
    (sample,) = muscle._read(curve(tmp_path))
    assert (sample.name, sample.group) == ("across_20", "across")
    np.testing.assert_allclose(sample.record["time_s"], [0.0, 20.0])
    np.testing.assert_allclose(sample.record["displacement_mm"], [0.0, -2.0])
    np.testing.assert_allclose(sample.record["force_N"], [0.0, -0.1])  # 1 kPa on 100 mm2
    with pytest.raises(InputError, match="not negative in compression"):
        muscle._read(curve(tmp_path, sign=-1.0))
    with pytest.raises(InputError, match="no column 'y'"):
        muscle._read(curve(tmp_path, title="stress"))


RATES = {"005": 0.005, "01": 0.01, "05": 0.05}
ENDS = {"10": 0.1, "20": 0.2, "30": 0.3}


@real
@pytest.mark.parametrize(
    ("name", "rates", "ends"),
    [
        ("muscle_rate", RATES, dict.fromkeys(RATES, 0.3)),
        ("muscle_magnitude", dict.fromkeys(ENDS, 0.01), ENDS),
    ],
)
def test_real_muscle(name, rates, ends):
    """Three curves along and three across the fibres, held for 300 s."""
    samples = read_real(name)
    assert len(samples) == 6
    for sample in samples.values():
        which = sample.name.split("_")[1]
        assert sample.strain.min() == pytest.approx(-ends[which], abs=1e-3)
        early = sample.record[sample.strain > -0.95 * ends[which]]
        slope = np.polyfit(early["time_s"], early["displacement_mm"] / 10.0, 1)[0]
        assert -slope == pytest.approx(rates[which], rel=0.05), sample.name
        time = sample.record["time_s"].to_numpy()
        assert (np.diff(time) > 0.0).all()
        assert time[-1] - ends[which] / rates[which] == pytest.approx(298.0, abs=8.0)
        assert 0.0 > sample.record["force_N"].iloc[-1] > 0.6 * sample.record["force_N"].min()


def test_a_file_that_is_no_workbook_is_refused(tmp_path):
    with pytest.raises(InputError, match="not a readable workbook"):
        sheets(written(tmp_path / "no.xlsx", "text"))
    with pytest.raises(InputError, match="not a readable workbook"):
        sheets(written(tmp_path / "no.xls", "text"))


def test_absent_data_are_said_plainly_with_where_to_get_them(tmp_path):
    with pytest.raises(InputError) as found:
        check_folder(tmp_path, CATALOGUE)
    for reader in READERS.values():
        assert reader.set in str(found.value)
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
    assert set(CATALOGUE["set"]) == {reader.set for reader in READERS.values()}
    assert CATALOGUE[["source", "licence"]].notna().all().all()
    assert CATALOGUE["sha256"].str.fullmatch("[0-9a-f]{64}").all()
    assert not CATALOGUE.duplicated(["set", "file"]).any()
