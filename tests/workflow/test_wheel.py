"""Installed from a wheel, softsample works from any folder, without its clone."""

import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest
import toy

ROOT = Path(__file__).resolve().parents[2]

PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet")


def succeeded(*command, cwd):
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    done = subprocess.run(
        command, cwd=cwd, env={**environment, "NO_COLOR": "1"}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """The command of a wheel, in an environment that takes what it needs from this one."""
    folder = tmp_path_factory.mktemp("wheel house")
    tree = folder / "sources"
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        files = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("what belongs into a wheel is told by git")
    for name in filter(None, files.split("\0")):
        if not name.startswith(("tests/", "docs/")) and (ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).write_bytes((ROOT / name).read_bytes())
    build = ("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(tree))
    succeeded(*PIP, *build, cwd=folder)
    venv.create(folder / "env", with_pip=False)
    lib = next((folder / "env/lib").glob("python*/site-packages"))
    wheel = str(next(folder.glob("softsample-*.whl")))
    install = ("--python", str(folder / "env/bin/python"), "install", "--no-deps", wheel)
    succeeded(*PIP, *install, cwd=folder)
    # a path file is read after the wheel's own folder, and an editable install there not at all
    packages = Path(pytest.__file__).parents[1]
    (lib / "packages.pth").write_text(f"{packages}\n")
    return folder / "env/bin/softsample"


def test_a_study_is_made_checked_and_planned_anywhere(program, tmp_path):
    told = succeeded(program, "new", "my lab", cwd=tmp_path)
    assert "softsample add 'my lab' --image scan.nii.gz --record test.csv" in told
    assert "make " not in told
    assert "No fault found; samples: 1" in succeeded(program, "check", "my lab", cwd=tmp_path)


@pytest.mark.long
def test_a_study_runs_to_its_report_anywhere(program, tmp_path):
    study = tmp_path / "study"
    study.mkdir()
    toy.write_study(study)
    options = ("--settings", str(ROOT / "config/test.yaml"), "--cores", "2")
    told = succeeded(program, "run", "study", *options, cwd=tmp_path)
    assert "Report: study/results/report.html" in told
    assert (study / "results/report.html").is_file()


def test_the_shipped_study_is_planned_anywhere(program, tmp_path):
    options = ("--snakefile", snakefile(program), "--cores", "1", "-n", "sample_C3")
    told = succeeded(program.with_name("python"), "-m", "snakemake", *options, cwd=tmp_path)
    assert "C3" in told


def snakefile(program):
    """Where the wheel has brought the workflow."""
    found = program.parents[1] / "share/softsample/Snakefile"
    assert found.is_file()
    return found
