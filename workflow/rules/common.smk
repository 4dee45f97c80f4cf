# Configuration and table of samples; input functions, which forward to the plan of the study.

import os
import shlex
import sys
import time
from dataclasses import replace
from functools import wraps
from inspect import signature
from itertools import chain
from pathlib import Path

from snakemake.utils import update_config

# installed from a wheel, the library lies apart from the workflow
CLONE = (ROOT / "src/softsample").is_dir()
if CLONE and str(ROOT / "src") not in sys.path:
    sys.path.insert(0, str(ROOT / "src"))

import softsample

SOURCES = Path(softsample.__file__).parents[1]
# A project may lie in a folder with a space, and Snakemake puts the path of its Python into commands
# without quotes.
sys.executable = shlex.quote(sys.executable)
search_path = [str(SOURCES)] if CLONE else []
search_path += filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
os.environ.update(PYTHONPATH=os.pathsep.join(dict.fromkeys(search_path)))

from softsample.costs import (
    diagnosis_runtime_min,
    mesh_memory_mb,
    mesh_runtime_min,
    pool_memory_mb,
    pool_runtime_min,
)
from softsample.dependencies import dependencies, state_of_kernels
from softsample.errors import SoftsampleError
from softsample.holdout import check_hold_out
from softsample.io import read_json, read_samples, read_yaml
from softsample.presence import is_led, lead_run, show_presence
from softsample.progress import show_jobs_in_lines
from softsample.protocol import GEOMETRIES
from softsample.report.results import words_of_failure, words_of_success
from softsample.study import schema
from softsample.study.files import PICTURE_FORMATS, Files, in_formats
from softsample.study.plan import Plan
from softsample.validation import (
    check_config,
    check_samples,
    modelled_ends,
    resolved,
    states_directions,
)
from softsample.workflow import failed_jobs

if workflow.is_main_process:
    show_jobs_in_lines(dry=lambda: workflow.dryrun)


# A module is given what differs from the defaults alone.
defaults = read_yaml(ROOT / "config/config.yaml")
update_config(defaults, config)
config.update(defaults)


def checked_study():
    """Path and plan of the table of samples, after config and table passed their schemas."""
    source = ", ".join(str(name) for name in workflow.configfiles) + " or --config"
    try:
        check_config(config, schema("config"), source)
        table = Path(config["samples"])
        if not table.is_file() and (ROOT / table).is_file():
            table = Path(os.path.relpath(ROOT / table))
        given = read_samples(table), schema("samples"), str(table), config["formats"]
        rows, hold_out = check_samples(*given), config.get("hold_out", [])
        check_hold_out(rows, hold_out)
        return table, Plan({row["sample"]: row for row in rows}, hold_out, config.get("leave_out"))
    except SoftsampleError as error:
        raise WorkflowError(str(error)) from None


STARTED = time.time()
TABLE, PLAN = checked_study()
# A run begins only where no process of another one is alive.
if is_led(config["results"]) or not workflow.is_main_process:
    show_presence(config["results"])
# After a run in which samples failed, tables and figures of the others can still be had.
LEFT_OUT, FAILURES = [], []
if config["report"]["groups"] != "all":
    FAILURES = failed_jobs(f"{config['results']}/logs")
    reported = config["report"]["groups"] == "finished"
    finished = Files(PLAN).finished(config["results"], FAILURES, reported)
    LEFT_OUT = [name for name in PLAN.rows if name not in finished]
    if not finished:
        raise WorkflowError("no group of samples came through; there is nothing to report")
    PLAN = replace(PLAN, rows=finished)
FILES = Files(PLAN, TABLE.parent)
SAMPLES, GROUPS, PIECES = PLAN.rows, PLAN.groups, PLAN.pieces
COMPRESSED, HOLD_OUT, LEAVE_OUT = PLAN.compressed, PLAN.hold_out, PLAN.leave_out
SHIPPED = (ROOT / "resources").resolve() in TABLE.resolve().parents


pathvars:
    results=config["results"],
    logs=f"{config['results']}/logs",
    benchmarks=f"{config['results']}/benchmarks",


wildcard_constraints:
    sample=r"[A-Za-z0-9_-]+",
    group=r"[A-Za-z0-9_-]+",
    geometry="|".join(GEOMETRIES),
    model="ogden1|ogden2",


# Each state of the kernels has a cache of its own; they do without threads: jobs run side by side.
os.environ.update(NUMBA_CACHE_DIR=os.path.abspath(f".snakemake/numba/{state_of_kernels(SOURCES)}"))
for variable in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


def library(script):
    """Files of the library that a script imports, directly or not: its hidden inputs."""
    return dependencies(ROOT / script, SOURCES)


# What a job on meshes needs beyond the default of a cluster's profile.
ELEMENT_SIZE = config["mesh"]["element_size_mm"]
OF_MESHES = {
    "mem_mb": lambda wildcards, attempt: mesh_memory_mb(ELEMENT_SIZE, attempt),
    "runtime": lambda wildcards, attempt: mesh_runtime_min(ELEMENT_SIZE, attempt),
}


def of(function, *given, **fixed):
    """Input or params function: what a function of the library finds for a job's wildcards."""
    names = signature(function).parameters

    def find(wildcards):
        own = {name: value for name, value in wildcards.items() if name in names}
        try:
            return function(*given, **{**own, **fixed})
        except SoftsampleError as error:
            raise WorkflowError(str(error)) from None

    return find


def each(samples, pattern, **fixed):
    """Input function: a file for each sample that a function finds (`Files.each`)."""
    find = of(samples)
    return lambda wildcards: FILES.each(
        pattern, find(wildcards), **{**dict(wildcards.items()), **fixed}
    )


def of_piece(pattern):
    """Input function: the file of the sample's piece."""
    find = each(PLAN.same_piece, pattern)
    return lambda wildcards: find(wildcards)[0]


def of_row(function):
    """Params function: what a function of the library makes of the sample's row."""
    return of(lambda sample: function(PLAN.row(sample)))


def row_value(column):
    """Params function: one value of the sample's row."""
    return of_row(lambda row: resolved(row)[column])


def rows(samples):
    """Params function: rows of the samples that a function finds, with what empty cells mean."""
    find = of(samples)
    return lambda wildcards: PLAN.cells_of(find(wildcards))


def image_files(column, sample, geometry="real"):
    """Files of an image (`Files.image`); of a folder they say more than its time stamp."""
    found = FILES.image(column, sample, geometry)
    return [ancient(file) if os.path.isdir(file) else file for file in found]


def chosen(samples, choose):
    """Function of the library: what it makes of the samples that another one finds."""
    return wraps(samples)(lambda *given, **known: choose(samples(*given, **known)))


def of_model(samples, ends="", **fixed):
    """Curves of samples and of changed models, on the best geometry if none is fixed."""
    curves, changes = "<results>/curves/{piece}/{geometry}", "<results>/loop/perturbations/{piece}"
    return {
        "curves": each(samples, f"{curves}/ogden2{ends}.csv", **fixed),
        "perturbations": each(samples, f"{changes}_{{geometry}}{ends}.csv", **fixed),
    }


def recorded(samples):
    """Records of samples, and dimensions of the ideal shapes."""
    return {
        "records": each(samples, "<results>/records/{sample}.csv"),
        "cuboids": each(samples, "<results>/cuboid/{piece}.json"),
    }


def responses(**fixed):
    """What a diagnosis predicts records with, on the best geometry if none is fixed."""
    sliding = of_model(chosen(PLAN.diagnosed, PLAN.opened), "{ends}", **fixed)
    return {
        **of_model(PLAN.diagnosed, **fixed),
        **{f"sliding_{name}": files for name, files in sliding.items()},
        **recorded(PLAN.diagnosed),
        "fit": of(FILES.calibration_of_group, **fixed),
    }


def of_alike(*files):
    """Input function: files that rest on samples of known shape, bonded, each tested once."""

    def checked():
        PLAN.check_alike()
        return files

    return of(checked)


def captioned(names):
    """Those of the files that have a caption, which the report shows."""
    captions = {path.stem for path in (ROOT / "workflow/report").glob("*.rst")}
    return [
        name for name in names if name.endswith((".csv", ".png")) and Path(name).stem in captions
    ]


RECORDS = each(PLAN.same_piece, "<results>/records/{sample}.csv")  # of the sample's piece
FIT = of(FILES.calibration, "json")  # of the sample's group on the same geometry
ENDS = of_row(modelled_ends)

PAPER = [str(ROOT / f"resources/paper/{name}.csv") for name in ("moduli", "summary")]
PAPERS = TABLE.resolve() == (ROOT / "resources/cohort/samples.tsv").resolve()  # materials are its
COHORT = "virtual cohort" if PAPERS else f"study {TABLE.resolve().parent.name}"

# The pieces that stand for a loading mode in figures 3 and 7, and those of figure 2.
EXAMPLES = PLAN.examples(config["report"]["examples"])
REAL_EXAMPLES = [name for name in EXAMPLES.values() if PLAN.real_of(name)]
SHOWN = PLAN.shown(EXAMPLES)
SHOWN_GEOMETRIES = GEOMETRIES if PLAN.has_real(SHOWN) else ["ideal"]
SHOWN_GROUPS = list(dict.fromkeys(SAMPLES[name]["group"] for name in EXAMPLES.values()))
BONDED_GROUPS = list(dict.fromkeys(SAMPLES[piece]["group"] for piece in PLAN.bonded))


def numbers_of_this_run():
    """The document of all numbers, if this run has made it, or the report of it."""
    paths = [Path(config["results"], name) for name in ("results.json", "report.html")]
    made = any(path.is_file() and path.stat().st_mtime >= STARTED for path in paths)
    return read_json(paths[0]) if made and paths[0].is_file() else None


onstart:
    try:
        lead_run(config["results"])
    except SoftsampleError as error:
        raise WorkflowError(str(error)) from None
    # By default Snakemake looks at all jobs again a second after each look. Each job that ends adds
    # such a series: after the 25,000 jobs of 1,000 samples they would take several cores.
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None
