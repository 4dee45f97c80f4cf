"""What the workflow refuses, reruns, resumes and leaves alone; checked on its cheapest stage."""

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import pydicom
import pytest
import pyvista
import toy
import yaml

from softsample.workflow import FAILED, STARTED

ROOT = Path(__file__).resolve().parents[2]
DRY = ("-n", "--quiet", "host")  # with the table of jobs
NOTHING = "Nothing to be done"


def dry_run(*arguments):
    run = subprocess.run(
        [sys.executable, "-m", "snakemake", *DRY, "--cores", "1", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    return run.returncode, run.stdout + run.stderr


def jobs(text):
    """Number of jobs of each rule, from the table that a dry run prints."""
    return {name: int(count) for name, count in re.findall(r"^(\w+)\s+(\d+)$", text, re.M)}


@pytest.mark.parametrize("config", ["config.yaml", "quick.yaml", "test.yaml"])
def test_dry_run_plans_the_whole_study(config, tmp_path):
    status, text = dry_run(
        "--configfile", f"config/{config}", "--config", f"results={tmp_path / 'results'}"
    )
    assert status == 0, text
    planned = jobs(text)
    assert planned["segment"] == planned["measure"] == 15
    assert planned["check_image"] == planned["check_record"] == 15
    assert planned["mesh"] == planned["mesh_coarse"] == 30
    assert planned["confirm"] == planned["check_simulation"] == 30
    assert planned["band"] == planned["figure_sample"] == 15
    assert planned["bond"] == 10  # what no platen presses
    assert planned["simulate"] == 30
    assert planned["one_term"] == 10  # compression alone, out of the same runs
    assert planned["calibrate"] == 20 + 10
    assert "compare_with_truth" not in planned


def on_a_cluster(tmp_path, *files, **settings):
    """A dry run with the profile of the cluster."""
    entries = [f"{key}={value}" for key, value in {"results": tmp_path / "out", **settings}.items()]
    profile = ("--workflow-profile", "workflow/profiles/slurm")
    options = ("--configfile", *files) if files else ()
    status, text = dry_run(*profile, *options, "--config", *entries)
    assert status == 0, text
    return text


def ungrouped(text):
    """Rules of a dry run that have no group."""
    profile = yaml.safe_load((ROOT / "workflow/profiles/slurm/config.yaml").read_text())
    return set(jobs(text)) - {"all", "total"} - set(profile["groups"])


def test_on_a_cluster_every_job_of_a_study_has_a_group_and_what_it_needs(tmp_path):
    profile = yaml.safe_load((ROOT / "workflow/profiles/slurm/config.yaml").read_text())
    assert set(profile["default-resources"]) == {"mem_mb", "runtime"}
    usual = yaml.safe_load((ROOT / "workflow/profiles/default/config.yaml").read_text())
    assert {name: profile[name] for name in usual} == usual
    text = on_a_cluster(tmp_path)
    assert not ungrouped(text)
    assert text.count("Group job animal") == 10


@pytest.mark.parametrize("images", [False, True])
@pytest.mark.parametrize(
    ("ends", "settings", "alone"),
    [
        ("unknown", {}, {"diagnose_alone", "diagnose_pooled"}),
        ("bonded", {"leave_out": "group"}, {"diagnose_pooled"}),
        (
            "bonded",
            {"leave_out": "group", "hold_out": [{"strain_above": 0.15}]},
            {"diagnose_alone", "diagnose_whole", "pool", "diagnose_pooled"},
        ),
    ],
)
def test_on_a_cluster_an_animal_is_one_job_where_verdicts_need_other_animals(
    images, ends, settings, alone, tmp_path
):
    """Only these verdicts have no group; Snakemake refuses a rule that a group goes through."""
    shape = "image.nii\t\t\t" if images else "\tcylinder\t20\t10"
    rows = ["sample\tgroup\tmode\trecord\tends\timage\tshape\tdiameter_mm\theight_mm"]
    rows += [f"{name}1\t{name}\tcompression\tr.csv\t{ends}\t{shape}" for name in "ABCD"]
    (tmp_path / "samples.tsv").write_text("\n".join(rows) + "\n")
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(settings or {"hold_out": []}))
    for name in ("r.csv", "image.nii"):
        (tmp_path / name).touch()
    text = on_a_cluster(tmp_path, tmp_path / "study.yaml", samples=tmp_path / "samples.tsv")
    of_ideal = {"diagnose_ideal_pooled"} if images else set()
    assert ungrouped(text) == alone | of_ideal
    assert text.count("Group job animal") == 4


def test_no_rule_takes_a_file_that_another_one_makes_as_ancient():
    """Snakemake plans nothing that comes after it then, in the run that makes that file anew
    (github.com/snakemake/snakemake/issues/4166): results of old code would be called done."""
    for rules in (ROOT / "workflow/rules").glob("*.smk"):
        assert not re.search(r"ancient\(\s*[^)]*<results>", rules.read_text("utf-8")), rules.name


def test_one_sample_builds_its_group_alone(tmp_path):
    status, text = dry_run("sample_C3", "--config", f"results={tmp_path / 'results'}")
    assert status == 0, text
    planned = jobs(text)
    assert planned["segment"] == 2  # T3 and C3
    assert planned["calibrate"] == 4


def test_a_test_is_exported_on_demand_without_a_run_at_the_optimum(tmp_path):
    status, text = dry_run("export_C3", "--config", f"results={tmp_path / 'results'}")
    assert status == 0, text
    planned = jobs(text)
    assert planned["export"] == planned["calibrate"] == 2  # both geometries
    assert "confirm" not in planned


def test_no_table_of_laws_is_taken_for_a_groups(tmp_path):
    """Else Snakemake prints tracebacks while it finds the rule of laws/choice.json."""
    status, text = dry_run("laws", "--config", f"results={tmp_path / 'results'}")
    assert status == 0, text
    assert {"laws_of_group", "choose_law", "confirm_law"} <= set(jobs(text))
    assert "Traceback" not in text


def test_one_calibration_can_be_asked_for_by_file():
    status, text = dry_run("results/calibration/TC1/real/ogden2.json", "--forceall")
    assert status == 0, text
    assert jobs(text)["simulate"] == 2


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["samples=none.tsv"], "none.tsv: no such table of samples; give its path with --config"),
        (["results=a{b}"], "results: 'a{b}' has another form"),
        (["jobs=3"], "jobs: unknown name; known are samples"),
    ],
)
def test_bad_settings_are_one_clear_message(settings, message):
    status, text = dry_run("--config", *settings)
    assert status != 0
    assert message in text
    assert "Traceback" not in text


def test_a_bad_table_is_one_clear_message(project):
    project.table.write_text(project.table.read_text().replace("tension", "pull"))
    status, text = project.run("-n")
    assert status != 0
    assert "row 2 (A), column 'mode': 'pull' is not one of tension, compression, shear" in text
    assert "Traceback" not in text


def test_an_unknown_sample_is_refused_by_name(project):
    status, text = project.run("-n", f"{project.results}/inputs/Z.json")
    assert status != 0
    assert "no sample 'Z'" in text


def test_an_unknown_group_is_refused_by_name(project):
    status, text = project.run("-n", f"{project.results}/loop/Z/verdict.json")
    assert status != 0
    assert "no group 'Z'" in text


def test_a_run_tells_of_each_job_in_one_line_with_a_bar(project):
    status, text = project.run(str(checked(project, "A")), str(checked(project, "B")))
    assert status == 0, text
    lines = re.findall(r"^\[([# ]{20})\] +(\d+) %(?:, .*? left)?: (.*)$", text, re.M)
    assert {words for *_, words in lines} == {
        "Check the record: A", "Check the record: B",
    }  # fmt: skip
    assert len(lines) == 2
    assert "Finished jobid" not in text
    assert "Execute" not in text


def checked(project, sample="A"):
    return project.results / f"inputs/{sample}.json"


@pytest.mark.study
def test_only_what_depends_on_an_edit_reruns(project):
    targets = (str(checked(project, "A")), str(checked(project, "B")))
    status, text = project.run(*targets)
    assert status == 0, text
    source = project.folder / "src/softsample"

    # a touch, an edit of a module or of a setting that the stage does not use: nothing to do
    (source / "records.py").touch()
    edit(source / "scoring.py")
    config = project.folder / "config/test.yaml"
    config.write_text(config.read_text().replace("element_size_mm: 1.0", "element_size_mm: 1.5"))
    assert NOTHING in project.run(*targets, *DRY)[1]

    edit(source / "protocol.py")  # imported by records.py, which the script imports
    assert jobs(project.run(*targets, *DRY)[1])["check_record"] == 2
    assert project.run(*targets)[0] == 0
    assert NOTHING in project.run(*targets, *DRY)[1]

    edit(project.study / "A.csv")
    assert jobs(project.run(*targets, *DRY)[1])["check_record"] == 1


@pytest.mark.study
def test_a_new_record_meshes_nothing_again_and_a_new_image_does(project):
    project.table.write_text("".join(project.table.read_text().splitlines(keepends=True)[:2]))
    names = ("inputs/A.json", "mesh/A/real.vtu", "mesh/A/real_coarse.vtu")
    targets = [str(project.results / name) for name in names]
    status, text = project.run(*targets)
    assert status == 0, text
    changes = str(project.results / "loop/perturbations/A_real.csv")
    rest = {"simulate": 1, "calibrate": 1, "perturbations": 1}

    def planned():
        found = jobs(project.run(*targets, changes, *DRY)[1])
        return {name: count for name, count in found.items() if name != "total"}

    assert planned() == rest
    edit(project.study / "A.csv")
    assert planned() == rest | {"check_record": 1}
    assert project.run(*targets)[0] == 0
    data, affine = toy.image(2)
    nibabel.save(nibabel.Nifti1Image(data, affine), project.study / "A.nii.gz")
    of_image = ("check_image", "segment", "measure", "mesh", "mesh_coarse")
    assert planned() == rest | dict.fromkeys(of_image, 1)


def test_a_verdict_depends_on_every_effect_though_none_is_imported_by_name(project):
    graph = project.run(str(project.results / "loop/AB/verdict.json"), "--filegraph")[1]
    (node,) = re.findall(r">diagnose</font></b>(.*?)</table>", graph, re.S)
    effects = Path("src/softsample/loop/effects")
    files = [str(effects / file.name) for file in (project.folder / effects).glob("*.py")]
    assert len(files) > 20
    assert not [file for file in files if file not in node]


def edit(path):
    """Change the content of a text file without a change of meaning."""
    path.write_text(path.read_text() + "# edited\n")


def test_the_environment_may_lie_in_a_folder_with_a_space(project):
    (project.folder / "my tools").symlink_to(sys.prefix)
    project.python = str(project.folder / "my tools/bin/python")
    status, text = project.run(str(project.results / "inputs/A.json"))
    assert status == 0, text


@pytest.mark.study
def test_a_bad_sample_stops_itself_alone(project):
    record = project.study / "A.csv"
    lines = record.read_text().splitlines()
    lines[40] = lines[40].split(",")[0] + ",oops,0.1"
    record.write_text("\n".join(lines) + "\n")
    status, text = project.run(str(checked(project, "A")), str(checked(project, "B")))
    assert status != 0
    assert not checked(project, "A").exists()
    assert checked(project, "B").exists()
    message = "A.csv, line 41, column 'displacement_mm': 'oops' is not a number"
    assert re.search(rf"check_record/A: .*{message}", text.split("Some jobs failed")[1])


@pytest.mark.study
def test_missing_files_stop_their_sample_alone_and_are_all_told(project):
    names = [f"{kind}/{sample}.json" for sample in "AB" for kind in ("inputs", "cuboid")]
    targets = [project.results / name for name in names]
    for file in ("A.csv", "A.nii.gz"):
        (project.study / file).unlink()
    status, text = project.run(*map(str, targets))
    assert status != 0
    assert [name.exists() for name in targets] == [False, False, True, True]
    for file, kind in (("A.csv", "record"), ("A.nii.gz", "image")):
        message = f"{file}: no such {kind}; correct its path in the table"
        assert re.search(rf"check_{kind}/A: .*{message}", text.split("Some jobs failed")[1])


@pytest.mark.study
def test_a_sample_without_platen_stops_itself_alone(project):
    """A floats: its underside is the mirror image of its top."""
    data, affine = toy.image(0)
    above = data[:, :, 8:]  # of 36 layers of 0.4 mm, the platen ends in the eighth
    floating = np.concatenate([above[:, :, ::-1], above], axis=2)
    nibabel.save(nibabel.Nifti1Image(floating, affine), project.study / "A.nii.gz")
    masks = [project.results / f"segmentation/{sample}.nii.gz" for sample in "AB"]
    status, text = project.run(*map(str, masks))
    assert status != 0
    assert [mask.exists() for mask in masks] == [False, True]
    message = "no platen found below the sample: .*; give an image of the sample bonded"
    assert re.search(rf"segment/A: .*{message}", text.split("Some jobs failed")[1])


@pytest.mark.long
def test_other_axes_and_a_segmentation_made_elsewhere(project):
    """A is imaged lying on its side; B comes with a mask, and an image that shows nothing."""
    lying = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)
    data, affine = toy.image(0)
    nibabel.save(nibabel.Nifti1Image(data, lying @ affine), project.study / "A.nii.gz")
    data, affine = toy.image(1)
    nibabel.save(
        nibabel.Nifti1Image((data > 150).astype(np.uint8), affine), project.study / "mask.nii.gz"
    )
    noise = np.random.default_rng(0).normal(100.0, 5.0, data.shape).astype(np.int16)
    nibabel.save(nibabel.Nifti1Image(noise, affine), project.study / "B.nii.gz")
    header, first, second = project.table.read_text().splitlines()
    rows = [f"{header}\tloading_axis\tsegmentation", f"{first}\t-y\t", f"{second}\t\tmask.nii.gz"]
    project.table.write_text("\n".join(rows) + "\n")
    targets = [str(project.results / f"cuboid/{sample}.json") for sample in "AB"]
    status, text = project.run(*targets)
    assert status == 0, text
    for target in targets:
        cuboid = json.loads(Path(target).read_text())
        assert cuboid["height_mm"] == pytest.approx(toy.HEIGHT, abs=0.35)
        assert toy.LENGTH - 1.0 < cuboid["length_mm"] < toy.LENGTH + 0.1
        assert toy.WIDTH - 1.0 < cuboid["width_mm"] < toy.WIDTH + 0.1


def save_series(folder, data, affine):
    """DICOM slices along the third axis of an image, the topmost first, by file name."""
    folder.mkdir()
    to_lps = np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine
    size = np.linalg.norm(to_lps[:3, :3], axis=0)
    for k in range(data.shape[2]):
        found = pydicom.Dataset()
        found.file_meta = pydicom.dataset.FileMetaDataset()
        found.file_meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
        found.file_meta.MediaStorageSOPClassUID = found.SOPClassUID = pydicom.uid.MRImageStorage
        found.SOPInstanceUID = found.file_meta.MediaStorageSOPInstanceUID = f"1.2.3.{k + 1}"
        found.SeriesInstanceUID, found.PhotometricInterpretation = "1.2.3", "MONOCHROME2"
        found.Rows, found.Columns, found.SamplesPerPixel = data.shape[1], data.shape[0], 1
        found.BitsAllocated = found.BitsStored = 16
        found.HighBit, found.PixelRepresentation = 15, 1
        found.PixelSpacing = [size[1], size[0]]
        found.ImageOrientationPatient = list((to_lps[:3, :2] / size[:2]).T.ravel())
        found.ImagePositionPatient = list(to_lps[:3, 2] * k + to_lps[:3, 3])
        found.PixelData = np.ascontiguousarray(data[:, :, k].T).tobytes()
        name = folder / f"MR{data.shape[2] - k:03}.dcm"
        found.save_as(name, enforce_file_format=True)


def slicer_segments(path, labels, affine, names):
    """Segmentation in the manner of 3D Slicer, cropped to its segments."""
    ends = [np.flatnonzero(labels.any(axis=tuple({0, 1, 2} - {a})))[[0, -1]] for a in range(3)]
    low, high = np.transpose(ends)
    to_lps = np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine
    header = {
        "space": "left-posterior-superior",
        "space directions": to_lps[:3, :3].T,
        "space origin": to_lps[:3, :3] @ low + to_lps[:3, 3],
    }
    for number, name in enumerate(names):
        header[f"Segment{number}_Name"] = name
        header[f"Segment{number}_LabelValue"] = str(number + 1)
        header[f"Segment{number}_Layer"] = "0"
    box = tuple(slice(a, b + 1) for a, b in zip(low, high, strict=True))
    nrrd.write(str(path), labels[box].astype(np.uint8), header)


@pytest.mark.long
def test_a_dicom_folder_and_a_segmentation_of_slicer(project):
    """A is a series of slices; B is a NRRD that shows nothing, with a segmentation beside it."""
    data, affine = toy.image(0)
    save_series(project.study / "A", data, affine)
    data, affine = toy.image(1)
    labels = np.where(data > 150, 2, 0)
    labels[:, :, :3] = 1  # of the platen, to be left out
    segments = project.study / "B.seg.nrrd"
    slicer_segments(segments, labels, affine, ["platen", "B"])
    noise = np.random.default_rng(0).normal(100.0, 5.0, data.shape).astype(np.int16)
    vectors, origin = affine[:3, :3].T, affine[:3, 3]
    header = {"space": "RAS", "space directions": vectors, "space origin": origin}
    nrrd.write(str(project.study / "B.nrrd"), noise, header)
    rows = [line.split("\t") for line in project.table.read_text().splitlines()]
    rows[0] += ["segmentation"]
    rows[1][3:] = ["A/", "A.csv", ""]
    rows[2][3:] = ["B.nrrd", "B.csv", "B.seg.nrrd"]
    project.table.write_text("\n".join("\t".join(row) for row in rows) + "\n")
    targets = [str(project.results / f"cuboid/{sample}.json") for sample in "AB"]
    status, text = project.run(*targets)
    assert status == 0, text
    for target in targets:
        cuboid = json.loads(Path(target).read_text())
        assert cuboid["height_mm"] == pytest.approx(toy.HEIGHT, abs=0.35)
        assert toy.LENGTH - 1.0 < cuboid["length_mm"] < toy.LENGTH + 0.1

    found = json.loads((project.results / "inputs/images/A.json").read_text())["provenance"][
        "inputs"
    ]
    assert len([name for name in found if name.endswith(".dcm")]) == toy.image(0)[0].shape[2]
    for sample, volume in zip("AB", (toy.image(0)[0], data), strict=True):
        marked, header = nrrd.read(str(project.results / f"segmentation/{sample}.seg.nrrd"))
        assert header["Segment0_Name"] == sample
        assert header["space"] == "left-posterior-superior"
        np.testing.assert_allclose(header["space origin"], [-1, -1, 1] * affine[:3, 3], atol=1e-6)
        assert np.mean((marked == 1) == (volume > 150)) > 0.99
        surface = pyvista.read(project.results / f"segmentation/{sample}.stl")
        assert surface.is_manifold
        assert surface.volume == pytest.approx(marked.sum() * toy.VOXEL**3, rel=0.06)
        np.testing.assert_allclose(surface.center[:2], [0.0, 0.0], atol=0.5)
        assert surface.bounds[5] == pytest.approx(toy.HEIGHT, abs=1.0)

    assert NOTHING in project.run(*targets, *DRY)[1]
    (project.study / "A/.DS_Store").touch()  # as a look at the folder leaves behind
    assert NOTHING in project.run(*targets, *DRY)[1]
    touched = project.study / "A/MR007.dcm"
    touched.write_bytes(touched.read_bytes()[:-2] + b"\1\0")
    assert jobs(project.run(*targets, *DRY)[1])["check_image"] == 1
    touched.unlink()
    status, text = project.run(*targets)
    assert status != 0
    assert re.search(r"A, series .*: 0.8 mm lie between MR00\d.dcm and MR00\d.dcm", text)


def draw(project, name, values):
    """Write whole numbers on voxels of 1 mm, the first at (-10, -10, -2)."""
    affine = np.eye(4)
    affine[:3, 3] = [-10.0, -10.0, -2.0]
    image = nibabel.Nifti1Image(values.astype(np.uint8), affine)
    nibabel.save(image, project.study / f"{name}.nii.gz")


@pytest.mark.long
def test_glue_and_regions_drawn_in_the_image_reach_the_real_mesh(project):
    """The images have a grid of their own in the world of the sample's image."""
    x, _, heights = np.indices((20, 20, 16)) - np.array([10, 10, 2]).reshape(3, 1, 1, 1)
    draw(project, "glue", x < 0.5)
    draw(project, "regions", 1 + (heights > 3.5))
    header, first, second = project.table.read_text().splitlines()
    marked = [f"{header}\tbond_mask\tlabels", f"{first}\tglue.nii.gz\tregions.nii.gz", second]
    project.table.write_text("\n".join(marked) + "\t\t\n")
    real, ideal = (str(project.results / f"mesh/A/{name}.vtu") for name in ("real", "ideal"))
    status, text = project.run(real, ideal)
    assert status == 0, text

    meshes = [pyvista.read(name) for name in (real, ideal)]
    x, _, z = meshes[0].points[meshes[0]["glued"] == 1].T
    assert len(z) > 20
    assert z.min() > toy.HEIGHT - 2.0
    # the frame may lie a voxel beside, and nodes are a millimetre apart
    assert -0.5 * toy.LENGTH - toy.VOXEL < x.min() < 0.0
    assert abs(x.max() - 0.5) < 1.0 + toy.VOXEL
    middle = meshes[0].cell_centers().points[:, 2]
    assert set(meshes[0]["region"][middle < 3.0]) == {1}
    assert set(meshes[0]["region"][middle > 4.0]) == {2}
    assert "region" not in meshes[1].cell_data
    top = meshes[1].points[:, 2] == meshes[1].points[:, 2].max()
    np.testing.assert_array_equal(meshes[1]["glued"], top)

    draw(project, "glue", heights < 4.0)
    status, text = project.run(real)
    assert status != 0
    assert "glue.nii.gz: marks no node of the top surface" in text


@pytest.mark.study
def test_after_a_failure_the_report_holds_the_groups_that_came_through(project):
    project.table.write_text(project.table.read_text() + "C\tCC\tshear\tA.nii.gz\tA.csv\n")
    table = [line.split("\t")[:2] for line in project.table.read_text().splitlines()[1:]]

    def finish(sample, group):
        for name in (
            *(f"fields/{sample}/real.json", f"fields/{sample}/ideal.json"),
            *(f"{part}/{sample}.json" for part in ("band", "bond")),
            *(f"sensitivity/{sample}/real.json", f"bond/moduli/{group}.json"),
            *(f"loop/{group}/verdict.json", f"loop/{group}/ideal/verdict.json"),
        ):
            file = project.results / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text("{}")

    for own in table[:2]:
        finish(*own)

    finished = ("report={groups: finished}",)

    def partial():
        return project.run("reported", *DRY, config=finished)[1]

    assert jobs(project.run("reported", *DRY)[1])["check_record"] == 3
    assert jobs(partial())["check_record"] == 2
    assert jobs(partial())["table_moduli"] == jobs(partial())["numbers"] == 1
    for name in ("export/A_real.log", "figure_sample/A.log", "segment/A.log"):
        log = project.results / "logs" / name
        log.parent.mkdir(parents=True, exist_ok=True)
        log.write_text(f"{STARTED}\n{FAILED}the image\n")
        left = jobs(partial()).get("check_record", 0)
        assert left == 2 if name.startswith("export") else left < 2  # an export is not reported
        log.unlink()
    band = project.results / f"band/{table[1][0]}.json"
    band.unlink()
    assert "no group of samples came through" in partial()
    finish(*table[2])
    (project.results / "logs/segment/A.log").write_text(f"{STARTED}\n{FAILED}the image\n")
    status, text = project.run(str(checked(project, "C")), config=finished)
    assert status == 0, text
    assert "\nLeft out: A, B\n  segment/A: the image\n" in text


@pytest.mark.long
def test_a_killed_run_leaves_no_half_file_and_resumes(project):
    script = project.folder / "workflow/scripts/check_record.py"
    whole = script.read_text()
    marker = project.folder / "writing"
    slow = whole.replace(
        "    io.write_json(",
        f"    import pathlib, time\n    pathlib.Path({str(marker)!r}).touch()\n"
        "    time.sleep(120)\n    io.write_json(",
    )
    assert slow != whole
    script.write_text(slow)
    process = project.start(str(checked(project)))
    deadline = time.monotonic() + 60.0
    while not marker.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    assert marker.exists(), "the job did not start"
    project.kill(process)
    assert not checked(project).exists()

    script.write_text(whole)
    project.run("--unlock")
    status, text = project.run(str(checked(project)))
    assert status == 0, text
    assert checked(project).exists()
    assert not [name for name in os.listdir(checked(project).parent) if "partial" in name]


@pytest.mark.study
def test_undeclared_records_go_from_image_to_verdict(tmp_path):
    status, text = dry_run(
        "verdicts", "--configfile", "config/undeclared.yaml",
        "--config", f"results={tmp_path / 'results'}",
    )  # fmt: skip
    assert status == 0, text
    planned = jobs(text)
    assert planned["segment"] == planned["check_image"] == planned["check_record"] == 30
    assert planned["diagnose"] == planned["diagnose_ideal"] == 10


@pytest.mark.parametrize("snakefile", ["Snakefile", "workflow/Snakefile"])
def test_either_file_is_the_workflow_in_any_folder(snakefile, tmp_path):
    status, text = dry_run("--snakefile", snakefile, "--directory", str(tmp_path))
    assert status == 0, text
    assert jobs(text)["all"] == 1


def test_as_a_module_it_is_given_what_differs_from_the_defaults(tmp_path):
    table = ROOT / "resources/cohort/samples.tsv"
    own = tmp_path / "Snakefile"
    own.write_text(
        f"module softsample:\n    snakefile: {str(ROOT / 'Snakefile')!r}\n"
        f"    config: {{'results': 'moduli', 'samples': {str(table)!r}}}\n"
        "use rule * from softsample as softsample_*\n"
    )
    place = ("--snakefile", str(own), "--directory", str(tmp_path))
    status, text = dry_run(*place, "--", "moduli/calibration/TC1/real/ogden2.json")
    assert status == 0, text
    assert jobs(text)["softsample_calibrate"] == 1
    assert "mesh" not in jobs(text)
    status, text = dry_run(*place, "--", "softsample_all")
    assert status == 0, text


def test_a_new_sample_takes_its_row_from_the_command_line_alone():
    """Shells set GROUP to the group of the user."""
    command = ["make", "-n", "add-sample", "DIR=lab", "RECORD=a.csv", "MODE=tension"]

    def told(*cells):
        environment = os.environ | {"GROUP": "staff"}
        run = subprocess.run(
            [*command, *cells],
            cwd=ROOT,
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        return run.stdout

    assert "--group" not in told()
    assert '--group="g1"' in told("GROUP=g1", "HEIGHT=3")
    assert "--height" not in told("HEIGHT=")
