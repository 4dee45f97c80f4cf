"""Input abuse: whatever a file holds, it is refused in our words or read as sound numbers."""

import copy
import math
import os
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import pydicom
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import machines
from softsample.errors import InputError
from softsample.formats import read_image
from softsample.formats.machine import read
from softsample.images import check_image
from softsample.io import read_samples, read_yaml
from softsample.records import RecordSettings, aligned_record
from softsample.study.check import check_study
from softsample.validation import check_config, check_samples

ROOT = Path(__file__).resolve().parents[2]
SCHEMAS = {
    name: read_yaml(ROOT / f"workflow/schemas/{name}.schema.yaml")
    for name in ("config", "samples", "record")
}
CONFIG = read_yaml(ROOT / "config/config.yaml")
SETTINGS = RecordSettings(**CONFIG["records"])
TEST = machines.compression(step=0.1)

pytestmark = pytest.mark.filterwarnings("ignore")  # of libraries, about files that are broken
COUNTS = [40, pytest.param(400, marks=pytest.mark.long)]
"""Cases of each of five kinds: 200 in all for `make test`, 2,000 more for `make test-long`."""


def cases(count, check, *strategies):
    """Run a property on `count` cases, the same every time."""

    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        derandomize=True,
        suppress_health_check=list(HealthCheck),
    )
    @given(st.tuples(*strategies))
    def run(values):
        check(*values)

    run()


def understood(path, attempt):
    """Result of an attempt on a file; None if it is refused, in words that name the file."""
    try:
        return attempt()
    except InputError as error:
        message = str(error)
    assert str(path) in message
    return None


NASTY = [
    *("", " ", "nan", "inf", "-inf", "1e999", "-1e308", "1_0", "0x10", "1,5", "1.5.2", "١٢", "−1"),
    *("true", "NULL", "#", '"', "'", ";", ",", "\t", "../../x", "/etc/passwd", "C:\\x", "a\0b"),
    *("%s%n", "{0}", "$(touch x)", "`x`", "\ufeff", "\u2028", "é" * 300, "🧠", "9" * 400),
]
CELLS = st.one_of(st.sampled_from(NASTY), st.text(max_size=12), st.floats().map(repr))


@st.composite
def broken(draw, content):
    """Bytes with a few of them cut, doubled, changed or put in."""
    data = bytearray(content)
    for _ in range(draw(st.integers(0, 4))):
        at = draw(st.integers(0, len(data)))
        kind = draw(st.sampled_from(["cut", "drop", "double", "change", "insert"]))
        size = draw(st.integers(1, 40))
        if kind == "cut":
            del data[at:]
        elif kind == "drop":
            del data[at : at + size]
        elif kind == "double":
            data[at:at] = data[at : at + size]
        elif kind == "change":
            put = draw(st.binary(min_size=1, max_size=8))
            data[at : at + len(put)] = put
        else:
            data[at:at] = draw(st.one_of(st.binary(max_size=8), CELLS.map(_encoded)))
    return bytes(data)


def _encoded(text):
    return text.encode("utf-8", errors="replace")


@st.composite
def broken_cells(draw, lines, separator, cells, columns=None):
    """Lines of a table with cells replaced ({} is what was there), and one repeated elsewhere.

    If `columns` are named, one of their cells is replaced, and no line is repeated.
    """
    lines = [line.split(separator) for line in lines]
    for _ in range(1 if columns else draw(st.sampled_from([0, 0, 1, 2]))):
        row = draw(st.sampled_from(lines[1:]))
        at = draw(st.sampled_from(columns or range(len(row))))
        row[at] = draw(cells if columns or draw(st.booleans()) else CELLS).replace("{}", row[at])
    if not columns and draw(st.booleans()):
        lines.insert(draw(st.integers(1, len(lines))), draw(st.sampled_from(lines)))
    return _encoded("\n".join(separator.join(row) for row in lines))


def all_of(makers):
    """Any of several contents, broken."""
    contents = [maker(*TEST) for maker in makers.values()]
    return st.sampled_from([c if isinstance(c, bytes) else c.encode() for c in contents])


NUMBERS = st.sampled_from(["nan", "inf", "1e999", "-1e308", "{}0", "-{}", "0", "1e-320"])
TYPED = broken_cells(machines.univert(*TEST).splitlines(), ",", NUMBERS)
RECORDS = st.booleans().flatmap(
    lambda typed: TYPED if typed else all_of(machines.MACHINES).flatmap(broken)
)


MODES = st.sampled_from(["compression", "compression", "compression", "tension", "shear"])


@pytest.mark.parametrize("count", COUNTS)
def test_records(count, tmp_path):
    """A record is refused by name, or comes out finite, in order, in units that it names."""
    path = tmp_path / "r.csv"

    def check(content, mode):
        machines.write(path, content)
        raw = understood(path, lambda: read(path))
        if raw is None:
            return
        for told in raw.reading["columns"].values():
            text = content.replace(b"\0", b"")
            assert {told["unit"].encode(code) in text for code in ("utf-8", "cp1252")} & {True}
        facts = (raw.reading, mode, SETTINGS, SCHEMAS["record"], str(path))
        made = understood(path, lambda: aligned_record(raw.table, *facts))
        if made:
            table, facts = made
            numbers = table.drop(columns=["phase", "cycle", "calibrated"])
            assert numbers.dtypes.eq(np.float64).all()
            assert np.isfinite(numbers.to_numpy()).all()
            assert facts["timed"] == ("time_s" in table)
            assert not facts["timed"] or (np.diff(table["time_s"]) > 0.0).all()
            assert np.isfinite([facts["travel_mm"], facts["peak_force_N"]]).all()

    cases(count, check, RECORDS, MODES)


SIZES = {
    "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "min": 60.0},
    "displacement": {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "cm": 10.0, "m": 1e3, "in": 25.4},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "gf": 9.80665e-3, "lbf": 4.4482216152605},
}
TITLES = {"time": "Time", "displacement": "Extension", "force": "Load"}


def written(units, delimiter, comma, below):
    """The test in other units, with decimal commas or not, units behind the titles or below."""
    columns = [
        [f"{value / SIZES[name][unit]:.17g}" for value in values]
        for (name, unit), values in zip(units.items(), TEST, strict=True)
    ]
    rows = [delimiter.join(row) for row in zip(*columns, strict=True)]
    titles = [TITLES[name] if below else f"{TITLES[name]} ({units[name]})" for name in units]
    head = [delimiter.join(titles), *([delimiter.join(units.values())] if below else [])]
    text = "\n".join(rows)
    return "\n".join([*head, text.replace(".", ",") if comma else text, ""])


@pytest.mark.parametrize("count", COUNTS)
def test_units(count, tmp_path):
    """The same test comes out of every combination of units; one unknown unit is refused."""

    def check(units, delimiter, comma, below, strange):
        units = {name: units[name] for name in TITLES}  # in the order of the test
        content = written(units, delimiter, comma and delimiter != ",", below)
        table = read(machines.write(tmp_path / "r.csv", content)).table
        for column, values in zip(table, TEST, strict=True):
            np.testing.assert_allclose(table[column], values, rtol=1e-12, atol=1e-15)
        wrong = content.replace(units["force"], strange) if below else ""
        path = machines.write(tmp_path / "w.csv", wrong)
        assert understood(path, lambda: read(path)) is None

    units = st.fixed_dictionaries({n: st.sampled_from(list(sizes)) for n, sizes in SIZES.items()})
    strange = st.sampled_from(["hN", "MN", "Pa", "n", "%", "kn", "V", "mm"])
    flags = (st.sampled_from(["\t", ";", ","]), st.booleans(), st.booleans())
    cases(count, check, units, *flags, strange)


ROWS = [
    "sample\tgroup\tmode\timage\trecord\tlabels",
    "A\tg\ttension\tA.nii\tA.csv\t",
    "B\tg\tcompression\tB.nii.gz\tr/B.txt\tl.nrrd",
]
PATHS = st.sampled_from(["../{}", "a/../../{}", "/{}", "C:/{}", "..\\{}", "a/{}", "~/{}"])


@pytest.mark.parametrize("count", COUNTS)
def test_tables(count, tmp_path):
    """A table is refused by name, or has sound ids and paths that stay in its folder."""
    path = tmp_path / "samples.tsv"

    def check(content):
        machines.write(path, content)
        schema = SCHEMAS["samples"]
        rows = understood(path, lambda: check_samples(read_samples(path), schema, str(path)))
        for row in rows or []:
            assert row["sample"].isascii()
            for column in {"image", "record", "labels"} & set(row):
                inside = os.path.normpath(tmp_path / row[column])
                assert inside.startswith(str(tmp_path) + os.sep), row
        for fault in check_study(tmp_path).faults:  # as a command; files are missing at least
            assert str(tmp_path) in fault

    table = broken_cells(ROWS, "\t", CELLS) | broken("\n".join(ROWS).encode())
    cases(count, check, broken_cells(ROWS, "\t", PATHS, (3, 4)) | table)


def volume():
    return np.random.default_rng(0).integers(0, 400, (14, 13, 12)).astype(np.int16)


def contents(folder):
    """A sound image of each format, by ending."""
    nibabel.save(nibabel.Nifti1Image(volume(), np.diag([0.4, 0.4, 0.4, 1.0])), folder / "a.nii")
    nibabel.save(nibabel.load(folder / "a.nii"), folder / "a.nii.gz")
    place = {"space": "RAS", "space directions": 0.4 * np.eye(3), "space origin": np.zeros(3)}
    nrrd.write(str(folder / "a.nrrd"), volume(), place)
    nrrd.write(str(folder / "b.nrrd"), volume(), {**place, "encoding": "raw"})
    dicom(folder / "slice.dcm", 0)
    names = ("a.nii", "a.nii.gz", "a.nrrd", "b.nrrd", "slice.dcm")
    return [(Path(name).name, (folder / name).read_bytes()) for name in names]


def dicom(path, number):
    """One slice of a series."""
    found = pydicom.Dataset()
    found.file_meta = pydicom.dataset.FileMetaDataset()
    found.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
    found.file_meta.MediaStorageSOPClassUID = found.SOPClassUID = pydicom.uid.MRImageStorage
    found.SOPInstanceUID = found.file_meta.MediaStorageSOPInstanceUID = f"1.2.{number + 1}"
    found.SeriesInstanceUID, found.PhotometricInterpretation = "1.2.3", "MONOCHROME2"
    found.Rows, found.Columns, found.SamplesPerPixel = 13, 14, 1
    found.BitsAllocated = found.BitsStored = 16
    found.HighBit, found.PixelRepresentation = 15, 1
    found.PixelSpacing, found.ImageOrientationPatient = [0.4, 0.4], [1, 0, 0, 0, 1, 0]
    found.ImagePositionPatient = [0, 0, 0.4 * number]
    found.PixelData = np.ascontiguousarray(volume()[:, :, number].T).tobytes()
    found.save_as(path, enforce_file_format=True)


@st.composite
def broken_images(draw, sound):
    name, content = draw(st.sampled_from(sound))
    return name, draw(broken(content))


@pytest.mark.parametrize("count", COUNTS)
def test_images(count, tmp_path):
    """An image is refused by name, or comes out finite, of known place and the size of a sample."""
    series = tmp_path / "series"
    series.mkdir()
    for number in range(1, 12):
        dicom(series / f"{number}.dcm", number)

    def check(case):
        name, content = case
        path = series if name.endswith(".dcm") else tmp_path / name
        machines.write(series / "0.dcm" if path == series else path, content)
        volume = understood(path, lambda: read_image(path))
        facts = volume and understood(path, lambda: check_image(*volume, str(path)))
        if facts:
            data, affine = volume
            assert (data.dtype, data.ndim) == (np.float32, 3)
            assert np.isfinite(data).all()
            assert np.isfinite(affine).all()
            assert 3.0 <= min(facts["extent_mm"]) <= max(facts["extent_mm"]) <= 500.0

    cases(count, check, broken_images(contents(tmp_path)))


SECTIONS = {name: part for name, part in CONFIG.items() if isinstance(part, dict)}
LEAVES = [(name, key) for name, part in SECTIONS.items() for key in part]
NUMERIC = [(name, key) for name, key in LEAVES if isinstance(CONFIG[name][key], float)]
STRANGE = st.sampled_from([math.nan, math.inf, -math.inf, 0.0, -1, 1e300, "1.0", None])
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.dates(),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(max_size=5) | st.integers() | st.none(), inner, max_size=3)
    ),
    max_leaves=6,
)


def finite(value):
    """Whether no number in a tree is NaN or infinite."""
    if isinstance(value, dict):
        return all(map(finite, value.values()))
    if isinstance(value, list):
        return all(map(finite, value))
    return not isinstance(value, float) or np.isfinite(value)


@pytest.mark.parametrize("count", COUNTS)
def test_settings(count, tmp_path):
    """Settings are refused by key, or every number in them is finite."""
    path = tmp_path / "study.yaml"
    machines.write(tmp_path / "samples.tsv", "\n".join(ROWS))

    def check(changes, noise):
        config = copy.deepcopy(CONFIG)
        for (section, key), value in changes:
            config[section][key] = value
        machines.write(path, _encoded(yaml.safe_dump(config, allow_unicode=True)))
        schema = SCHEMAS["config"]
        sound = understood(path, lambda: check_config(read_yaml(path), schema, str(path)) or True)
        assert sound is None or finite(config)
        machines.write(path, _encoded(noise))
        for fault in check_study(tmp_path).faults:
            assert str(tmp_path) in fault

    number = st.tuples(st.sampled_from(NUMERIC), STRANGE)
    anything = st.tuples(st.sampled_from(LEAVES), VALUES)
    cases(count, check, st.lists(number | anything, min_size=1, max_size=2), st.text())
