"""Files that other programs read: versions agree, and commands are those that there are."""

import itertools
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from softsample import __version__
from softsample.__main__ import command_line

ROOT = Path(__file__).resolve().parents[2]


def targets():
    return set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))


def test_versions_and_titles_agree():
    meta = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert meta["version"] == citation["version"] == __version__
    assert meta["referencePublication"]["name"] == citation["references"][0]["title"]
    names = [a["familyName"] for a in meta["referencePublication"]["author"]]
    assert names == [a["family-names"] for a in citation["references"][0]["authors"]]


def test_continuous_integration_calls_what_make_knows_on_the_systems_that_are_promised():
    text = (ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8")
    found = yaml.safe_load(text)
    assert {"push", "pull_request", "schedule", "workflow_dispatch"} == set(found[True])  # on:
    called, systems = set(), set()
    for job in found["jobs"].values():
        assert set(job) <= {"if", "runs-on", "timeout-minutes", "strategy", "steps"}
        matrix = job.get("strategy", {}).get("matrix", {})
        assert set(re.findall(r"matrix\.(\w+)", yaml.dump(job))) == set(matrix)
        for values in itertools.product(*matrix.values()):
            words = yaml.dump(job)
            for name, value in zip(matrix, values, strict=True):
                words = words.replace(f"${{{{ matrix.{name} }}}}", value)
            called |= set(re.findall(r"\bmake ([a-z][\w-]*)", words)) - {"coreutils"}
            systems |= set(re.findall(r"runs-on: (\w+)", words))
        for step in job["steps"]:
            assert set(step) in ({"uses"}, {"uses", "with"}, {"run"}, {"if", "run"})
    assert called >= {"check", "test", "test-study", "test-long", "study", "site"}
    assert called <= targets()
    assert systems == {"ubuntu", "macos"}


def test_the_container_builds_the_environment_of_the_lock_and_runs_the_program():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert "make env VENV=/venv" in text
    assert "env" in targets()
    assert 'ENTRYPOINT ["softsample"]' in text
    ignored = (ROOT / ".dockerignore").read_text(encoding="utf-8").split()
    for needed in (
        "Makefile",
        "requirements.lock",
        "pyproject.toml",
        "src",
        "Snakefile",
        "LICENSE",
    ):
        assert needed not in ignored
        assert (ROOT / needed).exists()


def test_the_conda_environment_of_all_rules_has_the_dependencies_of_the_project():
    """`snakemake --lint` asks each rule for one."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [name for name in project["dependencies"] if not name.startswith("snakemake")]
    given = yaml.safe_load((ROOT / "workflow/envs/softsample.yaml").read_text(encoding="utf-8"))
    assert given["dependencies"] == [f"python{project['requires-python']}", *wanted]


def test_the_program_tells_its_version(capsys):
    with pytest.raises(SystemExit, match="^0$"):
        command_line().parse_args(["--version"])
    assert capsys.readouterr().out.strip() == f"softsample {__version__}"


def test_a_platform_that_is_not_supported_is_refused_by_name():
    code = "import sys; sys.platform = 'win32'; import softsample"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT / "src", capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 1
    assert "on Windows, install and run it in WSL" in done.stderr
