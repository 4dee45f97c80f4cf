"""The documentation: every command in it is run, every link leads somewhere, the site is built."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

sys.path.append(str(Path(__file__).resolve().parents[2] / "docs"))
import reference

from softsample.__main__ import command_line

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "config/README.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "resources").glob("*/README.md")),
]
PROGRAM = re.compile(
    r"(?m)^ {4}((?:make|snakemake|softsample|python|ccx|abaqus|febio4|uv|git|pip|cd|\.) [^\n]*)"
)
INLINE = re.compile(r"`((?:make|snakemake|python -m softsample) [a-z][^`…]*)`")

NOT_RUN = {
    "abaqus job=real interactive": "Nothing was run in Abaqus or FEBio",
    "febio4 -i real.feb": "Nothing was run in Abaqus or FEBio",
}
"""Commands of programs that are not to be had, with what the documentation says of it."""

ELSEWHERE = {
    "ccx real_calculix": ("tests/regression/test_export.py", '["ccx", "test"]'),
    ". .venv/bin/activate": ("Makefile", "VENV ?= .venv"),
    "softsample new": ("tests/workflow/test_wheel.py", 'program, "new"'),
    "softsample add": ("tests/unit/test_study_folder.py", '"add"'),
    "softsample check": ("tests/workflow/test_wheel.py", 'program, "check"'),
    "softsample run": ("tests/workflow/test_wheel.py", 'program, "run"'),
    "uv pip compile": ("Makefile", "--require-hashes -r requirements.lock"),
}
"""Commands that another place runs or that need a network, with what holds them there."""


def commands():
    """Commands of all pages without their comments, each once."""
    texts = [path.read_text(encoding="utf-8") for path in PAGES]
    found = [text for page in texts for text in PROGRAM.findall(page) + INLINE.findall(page)]
    return sorted({re.split(r"\s+#|\s+\\$", text)[0].strip() for text in found})


def run(words, **options):
    done = subprocess.run(
        words, cwd=ROOT, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src"), "NO_COLOR": "1"}, **options,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


def test_pages_have_the_commands_that_are_looked_for():
    found = commands()
    assert "make new-study DIR=lab" in found
    assert "snakemake --cores 2 export_C3" in found
    assert len(found) > 20


@pytest.mark.parametrize("command", [c for c in commands() if c.startswith("make ")])
def test_make_knows_what_the_pages_tell_it(command):
    words = [word for word in shlex.split(command) if not word.endswith("=...")]
    run([*words, "-n", f"VENV={sys.prefix}", "stamp=LICENSE"])


@pytest.mark.parametrize("command", [c for c in commands() if c.startswith("snakemake ")])
def test_the_workflow_plans_what_the_pages_ask_for(command, tmp_path):
    """With places for those that the reader fills in; what it then does, the studies test."""
    for name in ("my", "study"):
        (tmp_path / f"{name}.yaml").write_text("mesh:\n  element_size_mm: 1.0\n")
    assert "--cores" in command or "profiles/slurm" in command  # which says how many jobs
    places = {
        "PATH/samples.tsv": "resources/cohort/samples.tsv",
        "results=DIR": f"results={tmp_path}/DIR",
        "PATH/study.yaml": str(tmp_path / "study.yaml"),
        "my.yaml": str(tmp_path / "my.yaml"),
    }
    for place, path in places.items():
        command = command.replace(place, path)
    words = shlex.split(command)[1:]
    if not any(word.startswith("results=") for word in words):
        words = [re.sub("^results/", f"{tmp_path}/results/", word) for word in words]
        words += ["--config", f"results={tmp_path}/results"]
    plan = run([sys.executable, "-m", "snakemake", *words, "-n", "--quiet", "host"])
    assert re.search(r"^total +[1-9]", plan, re.M), plan[-2000:]


@pytest.mark.parametrize("command", [c for c in commands() if c.startswith("python ")])
def test_results_are_shown_as_the_pages_say(command, tmp_path):
    mesh = "tests/data/reference/mesh/compression_h1.vtu"
    words = shlex.split(command.replace("results/mesh/C3/real.vtu", mesh).replace("FILE", mesh))
    words += ["-o", str(tmp_path / "mesh.png")] if "show" in words else []
    if words[3] in ("new", "check"):  # of a study anywhere
        words[-1] = str(tmp_path / "study")
    if words[3] == "check":
        run([sys.executable, "-m", "softsample", "new", words[-1]])
    assert run([sys.executable, *words[1:]])


def test_every_other_command_is_accounted_for():
    rest = [c for c in commands() if not c.startswith(("make ", "snakemake ", "python "))]
    export = (ROOT / "docs/export.md").read_text(encoding="utf-8")
    for command in rest:
        if command in NOT_RUN:
            assert NOT_RUN[command].lower() in export.lower()
            continue
        places = [place for known, place in ELSEWHERE.items() if command.startswith(known)]
        assert places, f"{command!r} is in the documentation, but nothing runs it"
        file, text = places[0]
        assert text in (ROOT / file).read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_to_files_that_are_there(page):
    for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not re.match(r"https?:|mailto:", link) and not link.startswith("generated/"):
            assert (page.parent / link).exists(), link


def test_every_page_is_on_the_site():
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    trees = re.findall(r"```{toctree}(.*?)```", index, re.S)
    listed = {page for tree in trees for page in tree.split()}
    assert {path.stem for path in (ROOT / "docs").glob("*.md")} - {"index"} <= listed


def test_the_reference_names_every_setting_with_its_default():
    schema = yaml.safe_load((ROOT / "workflow/schemas/config.schema.yaml").read_text("utf-8"))
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    table = "\n".join(reference.schema_table(schema, config))
    assert "| `mesh: element_size_mm` | number ≥ 0.1, ≤ 5 |" in table
    assert "| `0.5` |" in table
    for section, values in config.items():
        for key in values if isinstance(values, dict) else ():
            assert f"| `{section}: {key}` |" in table


def test_the_reference_of_results_follows_its_definitions():
    schema = yaml.safe_load((ROOT / "workflow/schemas/results.schema.yaml").read_text("utf-8"))
    table = "\n".join(reference.schema_table(schema))
    place = "groups: ...: calibration: real: ogden2: moduli: ...: value_pa"
    assert f"| `{place}` | number | calibrated [Pa] |" in table


def test_the_reference_of_commands_is_what_they_say_themselves():
    page = "\n".join(reference.command_pages(command_line()))
    assert re.findall(r"^## (\w+)$", page, re.M)[0] == "show"
    assert "--segment SEGMENT" in page


@pytest.mark.long
def test_the_site_is_built_without_a_warning(tmp_path):
    run([sys.executable, "-m", "sphinx", "-q", "-W", "-b", "html", "docs", str(tmp_path)])
    front = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert 'href="tutorial.html"' in front
    assert "http" not in re.sub(r'<a [^>]*href="http[^>]*>', "", front.split("</head>")[0])
    assert (tmp_path / "generated/code/softsample.fem.explicit.html").exists()
