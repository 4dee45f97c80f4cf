"""The same marker at the same place through NIfTI, NRRD and DICOM; refusals name their cure.

Files are written by nibabel, pynrrd and pydicom, each by the rules of its own format.
"""

import gzip

import nibabel
import nrrd
import numpy as np
import pydicom
import pytest
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import EnhancedMRImageStorage, ExplicitVRLittleEndian, MRImageStorage, generate_uid

from softsample.errors import InputError
from softsample.formats import files_of, read_image
from softsample.images import on_grid_of
from softsample.io import write_segmentation

SHAPE = (9, 7, 5)
VOXEL = np.array([0.4, 0.3, 0.5])
ORIGIN = np.array([12.0, -31.0, 7.0])  # of voxel (0, 0, 0), RAS mm
MARKER = (6, 1, 3)
FLIP = np.array([-1.0, -1.0, 1.0])  # RAS to LPS


def turned():
    """Oblique axes, right-handed: 20 degrees about x after 30 degrees about z."""
    a, b = np.radians([20.0, 30.0])
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_z = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    return about_x @ about_z


AXES = turned()  # columns: directions of i, j, k in RAS
AFFINE = np.eye(4)
AFFINE[:3, :3], AFFINE[:3, 3] = AXES * VOXEL, ORIGIN


def phantom():
    """Without symmetry: a ramp along each axis, and one bright voxel."""
    i, j, k = np.indices(SHAPE)
    data = 10 * i + 3 * j + k
    data[MARKER] = 1000
    return data.astype(np.int16)


def world(index):
    return AXES @ (VOXEL * index) + ORIGIN


def brightest(volume):
    data, affine = volume
    return affine[:3, :3] @ np.unravel_index(data.argmax(), data.shape) + affine[:3, 3]


def save_nifti(path):
    nibabel.save(nibabel.Nifti1Image(phantom(), AFFINE), path)


def nrrd_header(space="left-posterior-superior"):
    sign = {"l": FLIP, "r": np.ones(3)}[space[0].lower()]
    vectors = (sign[:, None] * AXES * VOXEL).T
    return {"space": space, "space directions": vectors, "space origin": sign * ORIGIN}


def slice_of(k, **changes):
    """Slice k of the phantom as an MR image; columns run along i, rows along j."""
    data = Dataset()
    data.file_meta = FileMetaDataset()
    data.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    data.file_meta.MediaStorageSOPClassUID = data.SOPClassUID = MRImageStorage
    data.file_meta.MediaStorageSOPInstanceUID = data.SOPInstanceUID = generate_uid()
    data.Modality, data.SeriesInstanceUID = "MR", "1.2.3"
    data.SeriesNumber, data.SeriesDescription = 4, "t2 sample"
    data.Rows, data.Columns, data.SamplesPerPixel = SHAPE[1], SHAPE[0], 1
    data.PhotometricInterpretation = "MONOCHROME2"
    data.BitsAllocated = data.BitsStored = 16
    data.HighBit, data.PixelRepresentation = 15, 1
    data.PixelSpacing = [VOXEL[1], VOXEL[0]]  # between rows, between columns
    data.ImageOrientationPatient = [float(f"{x:.6f}") for x in (FLIP[:, None] * AXES).T[:2].ravel()]
    data.ImagePositionPatient = [float(f"{x:.6f}") for x in FLIP * world((0, 0, k))]
    data.PixelData = np.ascontiguousarray(phantom()[:, :, k].T).tobytes()
    for name, value in changes.items():
        setattr(data, name, value)
    return data


def save_dicom(folder, slices=None):
    """Files whose names tell nothing of the order of the slices."""
    folder.mkdir(exist_ok=True)
    slices = [slice_of(k) for k in (3, 0, 4, 2, 1)] if slices is None else slices
    for number, data in enumerate(slices):
        data.save_as(folder / f"IM{number}", enforce_file_format=True)
    return folder


def enhanced():
    """All slices in one file, last first, with rescaling; places in functional groups."""
    data, last = slice_of(0), SHAPE[2] - 1
    data.SOPClassUID = data.file_meta.MediaStorageSOPClassUID = EnhancedMRImageStorage
    shared, data.PerFrameFunctionalGroupsSequence = Dataset(), []
    for name, sequence, keys in (
        ("own", "PlanePositionSequence", ["ImagePositionPatient"]),
        ("shared", "PlaneOrientationSequence", ["ImageOrientationPatient"]),
        ("shared", "PixelMeasuresSequence", ["PixelSpacing"]),
    ):
        for k in range(last, -1, -1) if name == "own" else [0]:
            item, groups = Dataset(), Dataset() if name == "own" else shared
            for key in keys:
                setattr(item, key, getattr(slice_of(k), key))
            setattr(groups, sequence, [item])
            if name == "own":
                data.PerFrameFunctionalGroupsSequence.append(groups)
    rescale = Dataset()
    rescale.RescaleSlope, rescale.RescaleIntercept = 2.0, -5.0
    shared.PixelValueTransformationSequence = [rescale]
    data.SharedFunctionalGroupsSequence = [shared]
    for key in ("PixelSpacing", "ImagePositionPatient", "ImageOrientationPatient"):
        delattr(data, key)
    data.NumberOfFrames = SHAPE[2]
    data.PixelData = phantom().transpose(2, 1, 0)[::-1].copy().tobytes()
    return data


def written(kind, folder):
    """The phantom in one of the formats."""
    if kind == "nifti":
        save_nifti(folder / "a.nii.gz")
        return folder / "a.nii.gz"
    if kind == "dicom":
        return save_dicom(folder / "dicom")
    if kind == "enhanced":
        return save_dicom(folder / "dicom", [enhanced()])
    if kind == "detached":
        nrrd.write(str(folder / "a.nhdr"), phantom(), nrrd_header())
        return folder / "a.nhdr"
    nrrd.write(str(folder / "a.nrrd"), phantom(), nrrd_header(kind))
    return folder / "a.nrrd"


@pytest.mark.parametrize(
    "kind",
    [
        "nifti",
        "left-posterior-superior",
        "right-anterior-superior",
        "LPS",
        "RAS",
        "detached",
        "dicom",
        "enhanced",
    ],
)
def test_a_marker_has_the_same_place_in_every_format(tmp_path, kind):
    data, affine = read_image(written(kind, tmp_path))
    np.testing.assert_allclose(brightest((data, affine)), world(MARKER), atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(affine[:3, :3], axis=0), VOXEL, atol=1e-5)
    slope, intercept = (2.0, -5.0) if kind == "enhanced" else (1.0, 0.0)
    np.testing.assert_array_equal(data, slope * phantom() + intercept)
    assert data.dtype == np.float32
    assert np.linalg.det(affine[:3, :3]) > 0.0


def test_slices_are_rescaled_one_by_one(tmp_path):
    slices = [slice_of(k, RescaleSlope=str(1 + k), RescaleIntercept="7") for k in range(SHAPE[2])]
    data, _ = read_image(save_dicom(tmp_path / "d", slices))
    np.testing.assert_array_equal(data, (1 + np.arange(SHAPE[2])) * phantom() + 7)


def test_what_is_no_image_in_a_folder_is_passed_over(tmp_path):
    folder = save_dicom(tmp_path / "d")
    (folder / "notes.txt").write_text("protocol of 3 May")
    report = slice_of(0, SeriesInstanceUID="1.2.9")
    del report.PixelData
    report.save_as(folder / "report.dcm", enforce_file_format=True)
    (folder / "more").mkdir()
    assert read_image(folder)[0].shape == SHAPE


def slices_with(k, **changes):
    """The series with slice k changed."""
    return [slice_of(m, **(changes if m == k else {})) for m in range(SHAPE[2])]


def sheared():
    """Slices that lie straight above each other in z, though they are tilted."""
    origin = FLIP * world((0, 0, 0))
    return [
        slice_of(k, ImagePositionPatient=[*origin[:2], origin[2] + 0.5 * k])
        for k in range(SHAPE[2])
    ]


BAD_SERIES = {
    "two series": (
        lambda: slices_with(2, SeriesInstanceUID="1.2.4", SeriesDescription="scout"),
        r"holds 2 series \(4 't2 sample' with 4 files from IM0 on; 4 'scout' with 1 files from "
        r"IM2 on\); move each into a folder of its own",
    ),
    "missing slice": (
        lambda: [slice_of(k) for k in (0, 1, 3, 4)],
        r"series 4 't2 sample'.*: 1 mm lie between IM1 and IM2, 0\.5 mm as a rule; slices are miss",
    ),
    "sheared": (sheared, "series 4.*not stacked along their normal .20 degrees off.*resample"),
    "staggered": (
        lambda: slices_with(2, ImagePositionPatient=list(FLIP * world((0.1, 0, 2)))),
        "not stacked along their normal .*or staggered",
    ),
    "two echoes": (
        lambda: [slice_of(k) for k in (0, 1, 2, 2)],
        "IM2 and IM3 lie at the same place; keep one echo",
    ),
    "localiser": (
        lambda: slices_with(1, ImageOrientationPatient=[1, 0, 0, 0, 1, 0]),
        "IM1 differs from IM0 in orientation, size or PixelSpacing; keep the slices of one",
    ),
    "other pixels": (
        lambda: slices_with(1, PixelSpacing=[0.5, 0.4]),
        "IM1 differs from IM0 in orientation, size or PixelSpacing",
    ),
    "no place": (
        lambda: slices_with(0, ImagePositionPatient=None),
        "IM0 has no ImagePositionPatient, so that its place is not known; export the original",
    ),
    "no directions": (
        lambda: slices_with(0, ImageOrientationPatient=[1, 0, 0, 1, 0, 0]),
        "ImageOrientationPatient of IM0 is .*not two unit vectors at a right angle",
    ),
    "one slice": (lambda: [slice_of(0)], "one slice is no volume; export the whole series"),
    "too few pixels": (
        lambda: slices_with(0, PixelData=b"\0\0"),
        r"the pixels of IM0 cannot be read .*without compression",
    ),
    "colour": (lambda: slices_with(0, SamplesPerPixel=3), "IM0 is a colour image; export the grey"),
    "nothing": (lambda: [], "holds no DICOM image; name the folder that holds the slices"),
}


@pytest.mark.parametrize("name", BAD_SERIES)
def test_a_bad_series_is_refused_with_folder_series_and_cure(tmp_path, name):
    slices, message = BAD_SERIES[name]
    folder = save_dicom(tmp_path / "mri", slices())
    with pytest.raises(InputError, match=r"(?s)mri[:,].*" + message):
        read_image(folder)


def test_a_truncated_slice_is_refused_by_name(tmp_path):
    folder = save_dicom(tmp_path / "mri")
    whole = (folder / "IM1").read_bytes()
    (folder / "IM1").write_bytes(whole[:-40])
    with pytest.raises(InputError, match=r"mri.*IM1"):
        read_image(folder)


BAD_NRRD = {
    "no space": ({"space": None}, "no field 'space', so that the place .* in 3D Slicer"),
    "no directions": ({"space directions": None}, "no field 'space directions'"),
    "no origin": ({"space origin": None}, "no field 'space origin'"),
    "scanner": ({"space": "scanner-xyz"}, "space 'scanner-xyz' is not tied to the body; save"),
    "metres": ({"space units": ["m", "m", "m"]}, "space units m; save the image in mm"),
}


@pytest.mark.parametrize("name", BAD_NRRD)
def test_an_nrrd_without_a_place_is_refused_with_a_cure(tmp_path, name):
    changes, message = BAD_NRRD[name]
    header = {
        key: value for key, value in {**nrrd_header(), **changes}.items() if value is not None
    }
    nrrd.write(str(tmp_path / "a.nrrd"), phantom(), header)
    with pytest.raises(InputError, match=rf"a\.nrrd: .*{message}"):
        read_image(tmp_path / "a.nrrd")


def test_a_damaged_nrrd_and_a_header_without_its_data_are_refused(tmp_path):
    path = written("LPS", tmp_path)
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(InputError, match=r"a\.nrrd: not a readable NRRD image"):
        read_image(path)
    header = written("detached", tmp_path)
    (tmp_path / "a.raw.gz").unlink()
    with pytest.raises(InputError, match=r"a\.nhdr: not a readable NRRD .*together with its data"):
        read_image(header)


def test_a_series_of_volumes_in_a_nrrd_is_refused(tmp_path):
    header = nrrd_header()
    header["space directions"] = np.vstack([np.full(3, np.nan), header["space directions"]])
    nrrd.write(str(tmp_path / "a.nrrd"), np.stack([phantom(), phantom()]), header)
    with pytest.raises(InputError, match=r"shape \(2, 9, 7, 5\); give one three-dimensional"):
        read_image(tmp_path / "a.nrrd")


def test_unknown_and_missing_images_are_refused(tmp_path):
    (tmp_path / "a.png").write_bytes(b"\x89PNG")
    with pytest.raises(InputError, match=r"a\.png: not an image of a known kind; give \.nii, "):
        read_image(tmp_path / "a.png")
    with pytest.raises(InputError, match=r"b\.nrrd: no such image; correct its path"):
        read_image(tmp_path / "b.nrrd")


def slicer_file(path, layers, segments, **fields):
    """A `.seg.nrrd` with the fields that 3D Slicer writes; segments are (name, layer, label)."""
    header = nrrd_header()
    if layers.ndim == 4:
        header["space directions"] = np.vstack([np.full(3, np.nan), header["space directions"]])
    header["kinds"] = ["list"] * (layers.ndim - 3) + ["domain"] * 3
    for number, (name, layer, label) in enumerate(segments):
        header |= {
            f"Segment{number}_Color": "0.694118 0.478431 0.396078",
            f"Segment{number}_ColorAutoGenerated": "1",
            f"Segment{number}_Extent": "0 8 0 6 0 4",
            f"Segment{number}_ID": f"Segment_{number + 1}",
            f"Segment{number}_LabelValue": str(label),
            f"Segment{number}_Layer": str(layer),
            f"Segment{number}_Name": name,
            f"Segment{number}_NameAutoGenerated": "0",
            f"Segment{number}_Tags": "Segmentation.Status:inprogress|TerminologyEntry:~^^~|",
        }
    header |= {
        "Segmentation_ContainedRepresentationNames": "Binary labelmap|Closed surface|",
        "Segmentation_ConversionParameters": "Smoothing factor|0.5|0.0 (none) to 1.0 (strong).&",
        "Segmentation_MasterRepresentation": "Binary labelmap",
        "Segmentation_ReferenceImageExtentOffset": "0 0 0",
        **fields,
    }
    nrrd.write(str(path), layers.astype(np.uint8), header)
    return path


def parts():
    """Two disjoint regions of the phantom."""
    i, j, k = np.indices(SHAPE)
    inner = (i > 1) & (i < 7) & (j > 0) & (j < 5) & (k > 0)
    return inner, (i == 0) & (j > 3)


@pytest.mark.parametrize("wanted", [("T7", "sample"), ("t7",)])
def test_the_segment_of_the_sample_is_taken_by_name(tmp_path, wanted):
    inner, other = parts()
    path = slicer_file(
        tmp_path / "a.seg.nrrd", 2 * inner + 5 * other, [("platen", 0, 5), ("T7", 0, 2)]
    )
    data, affine = read_image(path, wanted)
    np.testing.assert_array_equal(data, inner)
    np.testing.assert_allclose(affine[:3, 3], ORIGIN)
    np.testing.assert_array_equal(read_image(path)[0], 2 * inner + 5 * other)


def test_overlapping_segments_lie_in_layers(tmp_path):
    inner, other = parts()
    layers = np.stack([other, inner | other])
    segments = [("platen", 0, 1), ("Sample", 1, 1)]
    path = slicer_file(tmp_path / "a.seg.nrrd", layers, segments)
    np.testing.assert_array_equal(read_image(path, ("T7", "sample"))[0], inner | other)
    with pytest.raises(InputError, match=r"the segments 'platen', 'Sample' may overlap.*labelmap"):
        read_image(path)


def test_files_from_before_layers_are_read(tmp_path):
    inner, other = parts()
    path = slicer_file(
        tmp_path / "a.seg.nrrd", np.stack([other, inner]), [("a", 0, 1), ("b", 1, 1)]
    )
    text = path.read_bytes()
    lines = text[: text.index(b"\n\n")].split(b"\n")
    kept = [line for line in lines if b"_Layer" not in line and b"_LabelValue" not in line]
    path.write_bytes(b"\n".join(kept) + text[text.index(b"\n\n") :])
    np.testing.assert_array_equal(read_image(path, ("b",))[0], inner)


def test_the_only_segment_is_taken_by_any_name(tmp_path):
    inner, _ = parts()
    path = slicer_file(tmp_path / "a.seg.nrrd", inner, [("Segment_1", 0, 1)])
    np.testing.assert_array_equal(read_image(path, ("T7", "sample"))[0], inner)


def test_a_plain_labelmap_stays_as_it_is(tmp_path):
    path = written("LPS", tmp_path)
    np.testing.assert_array_equal(read_image(path, ("T7",))[0], phantom())


@pytest.mark.parametrize(
    ("segments", "fields", "message"),
    [
        (
            [("tissue", 0, 1), ("platen", 0, 2)],
            {},
            "holds the segments 'tissue', 'platen'; name the one that is wanted 'T7' or 'sample'",
        ),
        ([("T7", 0, 9)], {}, "segment 'T7' is empty"),
        ([("T7", 1, 1)], {}, r"lacks layers of its segments \('T7'\)"),
        (
            [("T7", 0, 1)],
            {"Segmentation_SourceRepresentation": "Fractional labelmap"},
            "a fractional labelmap; convert it to a binary one",
        ),
    ],
)
def test_a_doubtful_segmentation_is_refused(tmp_path, segments, fields, message):
    path = slicer_file(tmp_path / "a.seg.nrrd", parts()[0], segments, **fields)
    with pytest.raises(InputError, match=rf"a\.seg\.nrrd: {message}"):
        read_image(path, ("T7", "sample"))


def test_a_segmentation_is_written_as_slicer_expects_it(tmp_path):
    inner, _ = parts()
    path = tmp_path / "T7.seg.nrrd"
    write_segmentation(path, inner, AFFINE, "T7")
    data, header = nrrd.read(str(path))
    np.testing.assert_array_equal(data, inner)
    assert header["space"] == "left-posterior-superior"
    np.testing.assert_allclose(header["space directions"], (FLIP[:, None] * AXES * VOXEL).T)
    np.testing.assert_allclose(header["space origin"], FLIP * ORIGIN)
    assert header["Segment0_Name"] == "T7"
    assert header["Segment0_LabelValue"] == "1"
    assert header["Segment0_Extent"] == "2 6 1 4 1 4"
    assert all(0.0 <= float(part) <= 1.0 for part in header["Segment0_Color"].split())
    assert header["Segmentation_SourceRepresentation"] == "Binary labelmap"
    back, back_affine = read_image(path, ("T7",))
    np.testing.assert_array_equal(back, inner)
    np.testing.assert_allclose(back_affine, AFFINE)
    first = path.read_bytes()
    write_segmentation(path, inner, AFFINE, "T7")
    assert path.read_bytes() == first  # no date: an equal result is an equal file
    assert gzip.decompress(first[first.index(b"\n\n") + 2 :]) == inner.tobytes(order="F")


def test_a_cropped_segmentation_comes_back_on_the_grid_of_the_image():
    inner, _ = parts()
    cropped = AFFINE.copy()
    cropped[:3, 3] = world((2, 1, 1))
    image = (phantom().astype(np.float32), AFFINE)
    found = on_grid_of(image, inner[2:7, 1:5, 1:].astype(np.float32), cropped, "a")
    np.testing.assert_array_equal(found, inner)
    fine = np.kron(inner, np.ones((3, 3, 3)))  # thirds of voxels, centres included
    third = AFFINE @ np.diag([1 / 3, 1 / 3, 1 / 3, 1])
    third[:3, 3] = world((-1 / 3, -1 / 3, -1 / 3))
    np.testing.assert_array_equal(on_grid_of(image, fine.astype(np.float32), third, "a"), inner)


def test_a_segmentation_of_another_place_is_refused():
    affine = np.diag([0.4, 0.4, 0.4, 1.0])
    far = affine.copy()
    far[:3, 3] = 100.0
    image = (phantom().astype(np.float32), affine)
    with pytest.raises(InputError, match=r"m\.nrrd: marks no voxel of the image; draw the sample"):
        on_grid_of(image, parts()[0].astype(np.float32), far, "m.nrrd")
    with pytest.raises(InputError, match=r"m\.nrrd: the affine is singular"):
        on_grid_of(image, parts()[0].astype(np.float32), np.diag([1.0, 1, 0, 1]), "m.nrrd")


def test_the_files_of_an_image_are_known_without_reading_it(tmp_path):
    folder = save_dicom(tmp_path / "d", [slice_of(0), slice_of(1)])
    (folder / ".DS_Store").write_text("")
    assert files_of(folder) == [str(folder), str(folder / "IM0"), str(folder / "IM1")]
    header = written("detached", tmp_path)
    assert files_of(header) == [str(header), str(tmp_path / "a.raw.gz")]
    assert files_of(tmp_path / "none.nii") == [str(tmp_path / "none.nii")]


def test_pydicom_wrote_what_the_tests_mean(tmp_path):
    """Independent of our reader: the marker by the standard's own equation."""
    found = pydicom.dcmread(save_dicom(tmp_path / "d") / "IM0")  # slice 3
    row, column = np.unravel_index(found.pixel_array.argmax(), found.pixel_array.shape)
    x, y = np.reshape(found.ImageOrientationPatient, (2, 3)).astype(float)
    place = np.array(found.ImagePositionPatient, dtype=float)
    place += x * found.PixelSpacing[1] * column + y * found.PixelSpacing[0] * row
    np.testing.assert_allclose(FLIP * place, world(MARKER), atol=1e-4)
