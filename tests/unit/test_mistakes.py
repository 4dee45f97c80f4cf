"""What laboratories get wrong: each mistake is told with its place, and the told cure works.

A small study is sound; one mistake at a time is made in it. `check_study` has to name file, row and
value. Where its message holds a cure (a line of settings in backquotes, cells of the table, another
title), the cure is applied as it stands, and the message has to be gone.
"""

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import nibabel
import numpy as np
import pytest
import yaml

import machines
from softsample.study.check import check_study
from softsample.validation import overlaid

AFFINE = np.diag([0.5, 0.5, 0.5, 1.0])
COLUMNS = (
    *("sample", "group", "mode", "image", "record", "shape", "length_mm", "width_mm", "height_mm"),
    *("diameter_mm", "loading_axis", "cycle", "format", "specimen"),
)
FOUND = "Time (s),Extension (mm),Force (N)"
OURS = "time_s,displacement_mm,force_N"
TEST = machines.compression(3)


def tissue(up=1, seed=0, shape=(11.0, 9.0, 7.0)):
    """Share of tissue of a block with an uneven top, its flat base down or, with -1, up."""
    x, y, z = (0.5 * np.arange(n) - start for n, start in ((44, 11.0), (40, 10.0), (32, 4.0)))
    x, y, z = np.meshgrid(x, y, z if up > 0 else 8.0 - z, indexing="ij")
    top = shape[2] + 0.6 * np.cos(x / 2.0 + seed) * np.cos(y / 1.7) - 0.04 * (x**2 + y**2)
    outside = np.max([abs(x) - 0.5 * shape[0], abs(y) - 0.5 * shape[1], z - top, -z], axis=0)
    return np.clip(0.5 - outside / 0.5, 0.0, 1.0)


def on_a_platen(share):
    """With 40 % of the brightness of tissue in the slices below the base."""
    share[3:-3, 3:-3, 2:8] = np.maximum(share[3:-3, 3:-3, 2:8], 0.4)
    return share


def scanned(share, seed=0):
    noise = np.random.default_rng(seed).normal(0.0, 8.0, (2, *share.shape))
    return np.hypot(300.0 * share + noise[0], noise[1]).astype(np.int16)


@dataclass
class Study:
    """A study folder whose files and cells can be changed."""

    folder: Path

    def image(self, name, values, affine=AFFINE):
        nibabel.save(nibabel.Nifti1Image(values, affine), self.folder / name)

    def record(self, name, time, travel, force, titles=OURS):
        rows = [f"{t:.6g},{d:.6g},{f}" for t, d, f in zip(time, travel, force, strict=True)]
        machines.write(self.folder / name, "\n".join([titles, *rows, ""]))

    def text(self, name, change):
        path = self.folder / name
        path.write_text(change(path.read_text()))

    @property
    def rows(self):
        lines = (self.folder / "samples.tsv").read_text().splitlines()
        return [dict(zip(COLUMNS, line.split("\t"), strict=True)) for line in lines[1:]]

    def write(self, rows):
        lines = ["\t".join(COLUMNS), *("\t".join(row[c] for c in COLUMNS) for row in rows)]
        (self.folder / "samples.tsv").write_text("\n".join(lines) + "\n")

    def cells(self, sample, **cells):
        self.write([row | cells if row["sample"] == sample else row for row in self.rows])

    def settings(self, own):
        path = self.folder / "study.yaml"
        base = yaml.safe_load(path.read_text()) if path.exists() else {}
        path.write_text(yaml.safe_dump(overlaid(base, own), allow_unicode=True))


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """Two images of one animal, and two cylinders by their dimensions."""
    study = Study(tmp_path_factory.mktemp("sound"))
    for seed, name in enumerate("AB"):
        study.image(f"{name}.nii.gz", scanned(tissue(seed=seed), seed))
    study.record("A.csv", *machines.compression(1, travel=1.4, peak=0.4))
    study.record("B.csv", *machines.compression(2, travel=-1.4, peak=-0.4))
    study.record("C.csv", *TEST)
    study.record("D.csv", *machines.compression(4))
    empty = dict.fromkeys(COLUMNS, "")
    imaged = [
        empty | {"sample": n, "group": "G", "mode": m, "image": f"{n}.nii.gz", "record": f"{n}.csv"}
        for n, m in (("A", "tension"), ("B", "compression"))
    ]
    round_ones = [
        empty | {"sample": n, "group": n, "mode": "compression", "record": f"{n}.csv"}
        | {"shape": "cylinder", "height_mm": "10", "diameter_mm": "14"}
        for n in "CD"
    ]  # fmt: skip
    study.write([*imaged, *round_ones])
    return study.folder


@pytest.fixture
def study(sound, tmp_path):
    shutil.copytree(sound, tmp_path / "lab")
    return Study(tmp_path / "lab")


def told(study):
    found = check_study(study.folder)
    return [*found.faults, *found.doubts]


def apply_cures(study, messages):
    """Apply the first cure of each message as it stands; returns how many messages had one."""
    rows = study.rows
    cured = 0
    for message in messages:
        first = message.split("If it is right")[0]
        line = re.search(r"samples\.tsv, row (\d+)", first)
        row = rows[int(line[1]) - 2] if line else {}
        cells = re.findall(r"(\S+) into column (\w+)", first)
        cells += [("", c) for c in re.findall(r"column '(\w+)': .*leave the cell empty", first)]
        titles = re.findall(r"write '([^']+)' in place of '([^']+)' in line (\d+)", first)
        for setting in re.findall(r"`(\w+: \{.*\})`", first):
            study.settings(yaml.safe_load(setting))
        for value, column in cells:
            row[column] = value
        for new, old, number in titles:
            lines = (study.folder / row["record"]).read_text().splitlines()
            assert old in lines[int(number) - 1]
            lines[int(number) - 1] = lines[int(number) - 1].replace(old, new)
            (study.folder / row["record"]).write_text("\n".join(lines) + "\n")
        cured += bool(cells or titles or "`" in first)
    study.write(rows)
    return cured


def cycles(count):
    """Test of `count` equal loadings and unloadings after the rest."""
    rest = TEST[0] < 0.5
    legs = [np.concatenate([x[~rest], x[~rest][::-1]]) for x in TEST[1:]]
    columns = [
        np.concatenate([x[rest], *[leg] * count]) for x, leg in zip(TEST[1:], legs, strict=True)
    ]
    return 0.02 * np.arange(len(columns[0])), *columns


def creeping_hold():
    """The hold of a relaxation test alone, in which the platen creeps on."""
    time = TEST[0]
    noise = 1e-3 * np.random.default_rng(0).normal(size=len(time))
    return time, -2.0 - 0.2 * time / time[-1] + noise, -0.9 + 0.3 * (1.0 - np.exp(-time / 3.0))


def on_its_side(s):
    both = np.where(np.arange(32) < 16, tissue(up=-1), tissue())
    s.image("A.nii.gz", scanned(both))


time_s, travel, force = TEST

MISTAKES = {
    # what is done: the change, what is told, whether a cure is told
    "dimensions in cm": (
        lambda s: s.cells("C", height_mm="1", diameter_mm="1.4"),
        r"row 4 \(C\).*C.csv: strain of 199 % .*write .*10 into column height_mm",
        True,
    ),
    "displacement in cm": (
        lambda s: s.record("C.csv", time_s, 0.1 * travel, force),
        r"row 4 \(C\).*C.csv: strain of 1.99 % .*write 'displacement_cm'",
        True,
    ),
    "displacement of an imaged sample in cm": (
        lambda s: s.record("B.csv", *(machines.compression(2, travel=-0.14, speed=0.03))),
        r"row 3 \(B\).*B.csv: strain of .* %.*write 'displacement_cm'",
        True,
    ),
    "ms as s": (
        lambda s: s.record("C.csv", 1e3 * time_s, travel, force),
        r"row 4 \(C\).*C.csv: 0.05 samples per s.*write 'time_ms' in place of 'time_s'",
        True,
    ),
    "mN as N": (
        lambda s: s.record("C.csv", time_s, travel, 1e3 * force),
        r"row 4 \(C\).*C.csv: stress over strain of 2\d{4} kPa.*write 'force_mN'",
        True,
    ),
    "m as mm": (
        lambda s: s.record("C.csv", time_s, 1e-3 * travel, force),
        r"row 4 \(C\).*C.csv, column 'displacement_mm': the platen moves 0.00199 mm only; is the "
        "column in m",
        False,
    ),
    "absolute crosshead position": (
        lambda s: s.record("C.csv", time_s, travel + 131.2, force),
        r"row 4 \(C\).*C.csv, column 'displacement_mm': .* mm at the end of .* is above zero",
        True,
    ),
    "absolute position without a rest": (
        lambda s: s.record("C.csv", time_s[30:], travel[30:] + 131.2, force[30:]),
        r"row 4 \(C\).*above zero, where no sample is .*zero: \{displacement: start\}",
        True,
    ),
    "reversed sign": (
        lambda s: [s.record(f"{n}.csv", time_s, -travel, -force) for n in "BCD"],
        r"row 4 \(C\).*C.csv, line \d+, column 'force_N': 0.8.* but negative is right",
        True,
    ),
    "upside down": (
        lambda s: s.image("A.nii.gz", scanned(tissue(up=-1))),
        r"row 2 \(A\).*A.nii.gz: no platen found.*: 1\d % .*write -z into column loading_axis",
        True,
    ),
    "visible platen": (
        lambda s: s.image("A.nii.gz", scanned(on_a_platen(tissue()))),
        r"row 2 \(A\).*A.nii.gz: what lies below the sample is \d\d % as bright",
        False,
    ),
    "two samples": (
        lambda s: s.image("A.nii.gz", np.concatenate([scanned(tissue())] * 2)),
        r"row 2 \(A\).*A.nii.gz: two samples found, of \d+ and \d+ mm3; crop",
        False,
    ),
    "no platen": (
        on_its_side,
        r"row 2 \(A\).*A.nii.gz: no platen found.*: 1\d % .*bonded to its platen, and",
        False,
    ),
    "at the border": (
        lambda s: s.image("A.nii.gz", scanned(tissue())[12:]),
        r"row 2 \(A\).*A.nii.gz: sample touches the edge of the field of view \(first slice",
        False,
    ),
    "2-D": (
        lambda s: s.image("A.nii.gz", scanned(tissue())[:, :, 14]),
        r"row 2 \(A\).*A.nii.gz: image has shape \(44, 40\); give one three-dim",
        False,
    ),
    "an offset": (
        lambda s: s.image("A.nii.gz", scanned(tissue()) - 1000),
        r"row 2 \(A\).*A.nii.gz: 1 % of the values lie below -99\d",
        False,
    ),
    "another sample's image": (
        lambda s: s.image("A.nii.gz", scanned(tissue()), np.diag([1.0, 1.0, 1.0, 1.0])),
        r"row 2 \(A\): a sample of about 4.*mm3, [67].* times the others' volume; is it the right",
        False,
    ),
    "a missing column": (
        lambda s: s.record("C.csv", *TEST, "time_s,displacement_mm,Kanal: 3"),
        r"row 4 \(C\).*C.csv, line 1: no column is known to hold force",
        True,
    ),
    "a missing time": (
        lambda s: s.record("C.csv", *TEST, "n,Extension (mm),Load (N)"),
        r"row 4 \(C\).*C.csv: no column is known to hold time.*if 'n' is the time",
        True,
    ),
    "an empty file": (
        lambda s: s.text("C.csv", lambda _: ""),
        r"row 4 \(C\).*C.csv: the file is empty",
        False,
    ),
    "titles alone": (
        lambda s: s.text("C.csv", lambda text: text.split("\n")[0] + "\n"),
        r"row 4 \(C\).*C.csv: no numbers below the titles",
        False,
    ),
    "NaN": (
        lambda s: s.record("C.csv", time_s, travel, np.where(time_s == 1.0, np.nan, force)),
        r"row 4 \(C\).*C.csv, line 52, column 'force_N': 'nan' is not a number",
        False,
    ),
    "cut off": (
        lambda s: s.record("C.csv", *(x[: len(time_s) // 2] for x in TEST)),
        r"row 4 \(C\): the record ends in its ramp, at a strain of 9.14 %, .* was it cut off",
        False,
    ),
    "a hold alone": (
        lambda s: s.record("C.csv", time_s, 0.0 * travel - 2.0, force),
        r"row 4 \(C\).*displacement stays within 0 mm.*there is no loading ramp",
        False,
    ),
    "a hold taken for a ramp": (
        lambda s: s.record("C.csv", *creeping_hold()),
        r"row 4 \(C\).*C.csv: the force falls from -0.868 N to -0.631 N along the loading, as in a",
        False,
    ),
    "five cycles": (
        lambda s: s.record("C.csv", *cycles(5)),
        r"row 4 \(C\).*C.csv: loading 1 of 5 is calibrated.*write last into column cycle",
        True,
    ),
    "its loading held out": (
        lambda s: (
            s.record("C.csv", *cycles(3)),
            s.cells("C", cycle="3"),
            s.settings({"hold_out": [{"cycle": [2, 3], "sample": "C"}]}),
        ),
        r"row 4 \(C\).*C.csv: loading 3 of 3, the one .* is held out; write 1 into column cycle",
        True,
    ),
    "capital letters": (
        lambda s: s.cells("C", mode="Compression"),
        r"row 4 \(C\), column 'mode': 'Compression' is not one of.*write compression into column",
        True,
    ),
    "image and dimensions": (
        lambda s: s.cells("A", shape="cuboid", length_mm="11", width_mm="9", height_mm="7"),
        r"row 2 \(A\), column 'height_mm': is measured in the image; leave the cell empty",
        True,
    ),
    "a dimension in the wrong column": (
        lambda s: s.cells("C", diameter_mm="", length_mm="14"),
        r"row 4 \(C\), column 'diameter_mm': is missing; .*write 14 into column diameter_mm",
        True,
    ),
    # and more
    "the other shape": (
        lambda s: s.cells("C", shape="cuboid"),
        r"row 4 \(C\), column 'length_mm': is missing; .*write cylinder into column shape",
        True,
    ),
    "an axis without a sign": (
        lambda s: s.cells("A", loading_axis="z"),
        r"row 2 \(A\), column 'loading_axis': 'z' is not one of.*write \+z into column",
        True,
    ),
    "letters of a file's name": (
        lambda s: s.cells("A", record="a.csv"),
        r"row 2 \(A\): .*a.csv: no such record; write A.csv into column record",
        True,
    ),
    "a wrong extension": (
        lambda s: s.cells("A", record="A.docx"),
        r"row 2 \(A\), column 'record': 'A.docx' has a wrong extension; expected: .*\.csv",
        False,
    ),
    "one record for two samples": (
        lambda s: s.cells("D", record="C.csv"),
        r"row 5 \(D\), column 'record': C.csv stands in the row of C already",
        False,
    ),
    "one image for two samples": (
        lambda s: s.cells("B", image="A.nii.gz"),
        r"row 3 \(B\), column 'image': A.nii.gz stands in the row of A already; .*column specimen",
        False,
    ),
    "one piece at two speeds": (
        lambda s: (s.cells("D", group="C"), s.record("D.csv", 2.0 * time_s, travel, force)),
        r"row 5 \(D\), column 'specimen': .*those of C, .*write C into column specimen",
        True,
    ),
    "a force that was not tared": (
        lambda s: s.record("C.csv", time_s, travel, force + 0.4),
        r"row 4 \(C\).*C.csv: the force before the ramp is 0.4 N",
        True,
    ),
    "an overloaded cell": (
        lambda s: s.record("C.csv", time_s, travel, np.maximum(force, -0.5)),
        r"row 4 \(C\).*C.csv: the force stays at -0.5 N: the load cell seems to be overloaded",
        False,
    ),
    "a title without a unit": (
        lambda s: s.record("C.csv", *TEST, "Time (s),Extension (mm),Load"),
        r"row 4 \(C\).*C.csv, column 'Load': no unit is named",
        True,
    ),
    "two forces": (
        lambda s: s.record(
            "C.csv", time_s, travel, [f"{f:.5f},0" for f in force], f"{FOUND},Load (N)"
        ),
        r"row 4 \(C\).*C.csv, line 1: 2 columns may hold force",
        True,
    ),
    "time that runs back": (
        lambda s: s.record("C.csv", np.where(time_s > 3.0, time_s - 2.5, time_s), travel, force),
        r"row 4 \(C\).*C.csv, line \d+, column 'time_s': .* time must rise from line to line",
        False,
    ),
    "centimetres in an image's header": (
        lambda s: s.image("A.nii.gz", scanned(tissue()), np.diag([0.05, 0.05, 0.05, 1.0])),
        r"row 2 \(A\): .*A.nii.gz: a field of view of 2.2 x 2 x 1.6 mm, expected 3 to 500 mm",
        False,
    ),
    "a segmentation as image": (
        lambda s: s.cells("A", image="A.seg.nrrd"),
        r"row 2 \(A\), column 'image': 'A.seg.nrrd' has a wrong extension; .*column segmentation",
        False,
    ),
}


def test_the_study_without_a_mistake_is_sound(study):
    assert told(study) == []


@pytest.mark.parametrize("name", MISTAKES)
def test_each_mistake_is_told_and_its_cure_works(study, name):
    change, message, cured = MISTAKES[name]
    change(study)
    messages = told(study)
    assert any(re.search(message, one) for one in messages), messages
    assert str(study.folder) in next(one for one in messages if re.search(message, one))
    meant = [one for one in messages if re.search(message.split(r"\)")[0] + r"\)", one)]
    if cured:
        assert apply_cures(study, meant)
        left = check_study(study.folder)
        assert left.faults == []
        assert not [one for one in left.doubts if re.search(message, one)], left.doubts


def test_a_mistake_is_never_followed_by_no_fault_found(study, capsys):
    from softsample.__main__ import main

    study.record("C.csv", time_s, 0.1 * travel, force)
    assert main(["check", str(study.folder)]) == 0
    printed = capsys.readouterr().out
    assert "Doubts: 1" in printed
    assert "No fault found" not in printed
