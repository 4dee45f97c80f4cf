"""From a fresh clone, an image and a file of a UniVert to a report: four commands of make."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import nibabel
import pandas as pd
import pytest
import toy

import machines

ROOT = Path(__file__).resolve().parents[2]

# the environment of this run stands for the one that make would build from the lock
BUILT = (f"VENV={sys.prefix}", "stamp=LICENSE")

pytestmark = pytest.mark.skipif(
    not (shutil.which("git") and shutil.which("make") and (ROOT / ".git").exists()),
    reason="a clone needs git, make and a repository",
)


@pytest.fixture
def clone(tmp_path):
    """What a clone would hold, with a space in its path: no results, no caches."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    files = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    folder = tmp_path / "fresh clone"
    for name in filter(None, files.split("\0")):
        if name.startswith("tests/") or not (ROOT / name).exists():
            continue
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, target, follow_symlinks=False)
    return folder


@pytest.fixture
def committed(tmp_path):
    """A clone of the last commit, with nothing in it that is not committed."""
    folder = tmp_path / "fresh clone"
    subprocess.run(["git", "clone", "--quiet", ROOT, folder], check=True)
    return folder


def run(clone, command, given=BUILT):
    """Run a command as printed, make with the variables given; returns what it prints."""
    words = shlex.split(command)
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "MAKEFLAGS")}
    done = subprocess.run(
        [*words, *given] if words[0] == "make" else words,
        cwd=clone,
        env={**environment, "NO_COLOR": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-5000:]
    return done.stdout


def next_command(told, target):
    """The command that a step tells to give next."""
    return next(line for line in told.splitlines() if line.strip().startswith(f"make {target} "))


def write_toy(folder):
    """Image and record of a newcomer: a toy, too small for the limits of quick.yaml."""
    nibabel.save(nibabel.Nifti1Image(*toy.image(2)), folder / "S7.nii.gz")
    machines.write(folder / "UniVert 7.csv", machines.univert(*toy.record("shear", 2)))


def write_sample_of_the_cohort(folder):
    """Image and record of a newcomer: a sample as large as real ones are."""
    cohort = ROOT / "resources/cohort"
    shutil.copy(cohort / "images/S1.nii.gz", folder / "S7.nii.gz")
    record = pd.read_csv(cohort / "records/S1.csv", comment="#").to_numpy().T
    machines.write(folder / "UniVert 7.csv", machines.univert(*record))


def up_to_the_check(clone, given=BUILT):
    """Three commands, each as the one before tells it; returns what the check says."""
    told = run(clone, "make new-study DIR='../my lab µ'", given)
    add = next_command(told, "add-sample")
    own = {"scan.nii.gz": "../S7.nii.gz", "test.csv": "'../UniVert 7.csv'", "compression": "shear"}
    for example, value in own.items():
        add = add.replace(example, value)
    return run(clone, next_command(run(clone, add, given), "check-study"), given)


@pytest.mark.study
def test_three_commands_bring_a_newcomer_to_a_plan_of_the_study(clone):
    write_toy(clone.parent)
    told = up_to_the_check(clone)
    assert "record ../my lab µ/UniVert 7.csv: CellScale UniVert" in told
    assert "No fault found; samples: 1" in told
    study = shlex.split(next_command(told, "study"))[2:]
    plan = run(clone, shlex.join(["make", "-n", "study", *study]))
    assert 'softsample run "../my lab µ" --settings "config/quick.yaml"' in plan
    options = ["--configfile", "config/quick.yaml", "../my lab µ/study.yaml", "--config"]
    lab = ["samples=../my lab µ/samples.tsv", "results=../my lab µ/results"]
    command = [sys.executable, "-m", "snakemake", "-n", "--cores", "1", *options, *lab]
    assert "Unit-modulus response: S7, real geometry" in run(clone, shlex.join(command))


@pytest.mark.long
def test_the_fourth_command_makes_the_report_of_the_sample(clone):
    write_toy(clone.parent)
    study = next_command(up_to_the_check(clone), "study")
    has_its_report(clone, run(clone, study.replace("quick.yaml", "test.yaml")))


@pytest.mark.long
def test_four_commands_from_a_clone_with_an_environment_of_its_own(committed):
    """As a newcomer does it: make builds the environment, which takes a network and minutes.

    SOFTSAMPLE_NEWCOMER_VENV names a folder where it is built, or found from the last time.
    """
    write_sample_of_the_cohort(committed.parent)
    kept = os.environ.get("SOFTSAMPLE_NEWCOMER_VENV")
    given = (f"VENV={kept}",) if kept else ()
    study = next_command(up_to_the_check(committed, given), "study")
    has_its_report(committed, run(committed, study, given))
    assert (Path(kept or committed / ".venv") / "bin/snakemake").exists()


def has_its_report(clone, told):
    """Whether the study of the sample came through, and its report is where make says."""
    results = clone.parent / "my lab µ/results"
    assert "Report: ../my lab µ/results/report.html" in told
    page = (results / "report.html").read_text(encoding="utf-8")
    assert 'id="sample-S7"' in page
    assert "Samples that failed" not in page
    assert json.loads((results / "checks/passed.json").read_text())["passed"] is True
    moduli = pd.read_csv(results / "tables/table1.csv")
    assert moduli["group"].tolist() == ["S7"]
    assert moduli[["mu_real_pa", "mu_ideal_pa"]].notna().all(axis=None)
