"""Files from outside: no path leaves their folder, nothing is unpickled or unpacked for ever."""

import ast
import gzip
import pickle
from contextlib import suppress
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import pytest
import yaml

import machines
from softsample.errors import InputError
from softsample.formats import files_of, read_image
from softsample.formats.machine import read
from softsample.io import read_samples, read_yaml

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted([*(ROOT / "src").rglob("*.py"), *(ROOT / "workflow").rglob("*.py")])
SPACE = {"space": "RAS", "space directions": 0.4 * np.eye(3), "space origin": np.zeros(3)}


def volume():
    return np.random.default_rng(0).integers(0, 400, (14, 13, 12)).astype(np.int16)


@pytest.mark.parametrize("where", ["../secret.raw", "{root}/secret.raw", "link.raw"])
def test_a_header_cannot_reach_out_of_its_folder(tmp_path, where):
    folder = tmp_path / "received"
    folder.mkdir()
    nrrd.write(str(folder / "a.nhdr"), volume(), {**SPACE, "encoding": "raw"})
    assert read_image(folder / "a.nhdr")[0].shape == (14, 13, 12)
    (folder / "a.raw").rename(tmp_path / "secret.raw")
    (folder / "link.raw").symlink_to(tmp_path / "secret.raw")
    header = (folder / "a.nhdr").read_bytes()
    name = where.replace("{root}", str(tmp_path)).encode()
    (folder / "a.nhdr").write_bytes(header.replace(b"a.raw", name))
    with pytest.raises(InputError, match="lies outside its folder; put both into one folder"):
        read_image(folder / "a.nhdr")
    assert files_of(folder / "a.nhdr") == [str(folder / "a.nhdr")]


def test_a_dicom_folder_cannot_reach_out(tmp_path):
    folder = tmp_path / "received"
    folder.mkdir()
    (tmp_path / "secret").write_text("not yours")
    (folder / "1.dcm").symlink_to(tmp_path / "secret")
    with pytest.raises(InputError, match=r"1\.dcm: is a link to outside its folder"):
        read_image(folder)


def test_data_that_unpack_to_more_than_told_are_refused(tmp_path):
    nrrd.write(str(tmp_path / "a.nhdr"), volume(), {**SPACE, "encoding": "gzip"})
    with gzip.open(tmp_path / "a.raw.gz", "wb") as stream:
        stream.write(bytes(2**23))
    with pytest.raises(InputError, match="unpacks to more than its header tells"):
        read_image(tmp_path / "a.nhdr")


@pytest.mark.parametrize("ending", ["nii", "nrrd"])
def test_a_header_that_claims_a_huge_volume_is_refused_before_room_is_made(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    if ending == "nii":
        image = nibabel.Nifti1Image(volume(), np.eye(4))
        image.header.set_data_shape((30000, 30000, 30000))
        path.write_bytes(image.header.binaryblock + bytes(4))
    else:
        nrrd.write(str(path), volume(), {**SPACE, "encoding": "raw"})
        path.write_bytes(path.read_bytes().replace(b"14 13 12", b"30000 30000 30000"))
    with pytest.raises(InputError, match="30000 x 30000 x 30000 voxels cannot be read"):
        read_image(path)


@pytest.mark.parametrize(("unit", "millimetre"), [("meter", 1e-3), ("micron", 1e3)])
def test_an_image_in_another_unit_is_read_in_it(tmp_path, unit, millimetre):
    affine = np.diag([0.4, 0.4, 0.5, 1.0])
    affine[:3, 3] = 3.0, -2.0, 1.0
    there = np.diag([*[millimetre] * 3, 1.0]) @ affine
    image = nibabel.Nifti1Image(volume(), there)
    image.header.set_xyzt_units(unit)
    nibabel.save(image, tmp_path / "a.nii")
    np.testing.assert_allclose(read_image(tmp_path / "a.nii")[1], affine, rtol=1e-6)


class Payload:
    """Makes a file when it is unpickled."""

    def __init__(self, mark):
        self.mark = mark

    def __reduce__(self):
        return Path.touch, (self.mark,)


@pytest.mark.parametrize("protocol", [0, 5])
@pytest.mark.parametrize(
    ("name", "reader"),
    [
        ("a.nii", read_image),
        ("a.nii.gz", read_image),
        ("a.nrrd", read_image),
        ("a.csv", read),
        ("samples.tsv", read_samples),
        ("study.yaml", read_yaml),
    ],
)
def test_no_pickle_is_loaded(tmp_path, name, reader, protocol):
    mark = tmp_path / "touched"
    path = machines.write(tmp_path / name, pickle.dumps(Payload(mark), protocol))
    pickle.loads(path.read_bytes())
    assert mark.exists()  # the payload works
    mark.unlink()
    with suppress(InputError):  # such bytes may even be a table
        reader(path)
    assert not mark.exists()


def test_yaml_makes_no_objects(tmp_path):
    mark = tmp_path / "touched"
    text = f"samples: !!python/object/apply:os.mkdir ['{mark}']\n"
    yaml.unsafe_load(text)
    mark.rmdir()  # the payload works
    with pytest.raises(InputError, match="not valid YAML"):
        read_yaml(machines.write(tmp_path / "study.yaml", text))
    assert not mark.exists()


def test_the_line_of_a_yaml_fault_is_named(tmp_path):
    path = machines.write(tmp_path / "study.yaml", "mesh: {element_size_mm: 1.0\nloop:\n")
    with pytest.raises(InputError, match=r"yaml, line 2, column 5: not valid YAML: .*bracket"):
        read_yaml(path)


def test_aliases_are_not_written_out_for_ever(tmp_path):
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n + 1}: &a{n + 1} [{', '.join([f'*a{n}'] * 10)}]" for n in range(9)]
    with pytest.raises(InputError, match="holds more than 100000 values"):
        read_yaml(machines.write(tmp_path / "study.yaml", "\n".join(lines)))


UNSAFE = {"pickle", "cPickle", "dill", "shelve", "marshal", "joblib", "cloudpickle"}


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_nothing_in_the_sources_runs_what_it_reads(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert not UNSAFE & {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert str(node.module).split(".")[0] not in UNSAFE
        elif isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            assert called not in ("eval", "exec", "os.system", "pd.read_pickle", "yaml.unsafe_load")
            given = {keyword.arg: ast.unparse(keyword.value) for keyword in node.keywords}
            assert given.get("allow_pickle", "False") == "False"
            assert given.get("shell", "False") == "False"
