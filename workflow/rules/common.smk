# Configuration, table of samples, and the helpers that every rule uses.

import ast
import os
import shlex
import sys
import time
from functools import cache
from itertools import accumulate, chain
from pathlib import Path

ROOT = Path(workflow.basedir)
# installed from a wheel, the library lies apart from the workflow
CLONE = (ROOT / "src/softsample").is_dir()
if CLONE and str(ROOT / "src") not in sys.path:
    sys.path.insert(0, str(ROOT / "src"))

import softsample

SOURCES = Path(softsample.__file__).parents[1]
# Snakemake puts the path of its Python into commands as it is, where a space would split it
sys.executable = shlex.quote(sys.executable)
search_path = [str(SOURCES)] if CLONE else []
search_path += filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
os.environ.update(PYTHONPATH=os.pathsep.join(dict.fromkeys(search_path)))

from softsample.errors import SoftsampleError
from softsample.files import show_presence
from softsample.formats import files_of
from softsample.holdout import check_hold_out, folds, in_turn, wholly_held_out
from softsample.io import read_json, read_samples, read_table
from softsample.progress import show_jobs_in_lines
from softsample.report.results import words_of_failure, words_of_success
from softsample.response.unit import is_homogeneous
from softsample.study import schema
from softsample.study.plan import GEOMETRIES, Plan
from softsample.validation import (
    DEFAULT_AXES,
    check_config,
    check_samples,
    has_open_ends,
    modelled_ends,
    resolved,
)
from softsample.workflow import failed_jobs, sha256_of_files

if workflow.is_main_process:
    show_jobs_in_lines(dry=lambda: workflow.dryrun)

# `make` removes the lock of a killed run only if no run and no job of one is alive.
show_presence(".snakemake/alive.lock")


def checked_study():
    """Path and plan of the table of samples, after config and table passed their schemas."""
    source = ", ".join(str(name) for name in workflow.configfiles) + " or --config"
    try:
        check_config(config, schema("config"), source)
        table = Path(config["samples"])
        if not table.is_file() and (ROOT / table).is_file():
            table = Path(os.path.relpath(ROOT / table))
        given = read_samples(table), schema("samples"), str(table), config["formats"]
        rows = check_samples(*given)
        check_hold_out(rows, HOLD_OUT)
        held_out = (row["sample"] for row in rows if wholly_held_out(row, HOLD_OUT))
        return table, Plan({row["sample"]: row for row in rows}, frozenset(held_out))
    except SoftsampleError as error:
        raise WorkflowError(str(error)) from None


# Stages that the report rests on; an export, say, may have failed.
REPORTED = {
    *("check_inputs", "segment", "measure", "mesh", "simulate", "calibrate", "confirm"),
    *("one_term", "band", "bond", "calibrate_bond", "sensitivity", "perturbations"),
    *("diagnose", "checks"),
    *("figure_sample", "figure_response", "figure_strain"),
}


def finished(plan, failures):
    """Rows of the groups that have what the report needs, none of it of a job that failed since."""
    names = sorted({*plan.rows, *plan.groups}, key=len, reverse=True)

    def owner(job):
        stage, _, rest = job.partition("/")
        own = (name for name in names if rest == name or rest.startswith(f"{name}_"))
        return next(own, None) if stage in REPORTED else None

    def complete(group):
        pieces, geometries = plan.pieces_of(group), plan.geometries(group)
        needed = [
            *(f"fields/{piece}/{name}.json" for piece in pieces for name in geometries),
            *(f"sensitivity/{piece}/{plan.best(group)}.json" for piece in pieces),
            *(f"band/{piece}.json" for piece in pieces if piece in plan.banded),
            *(f"bond/{piece}.json" for piece in pieces if piece in plan.bonded),
            *([f"bond/moduli/{group}.json"] if {*plan.bonded} & {*pieces} else []),
            f"loop/{group}/verdict.json",
            *([f"loop/{group}/ideal/verdict.json"] if "real" in geometries else []),
        ]
        there = all(Path(config["results"], name).is_file() for name in needed)
        return there and not {group, *plan.groups[group]} & failed

    failed = {owner(job) for job, _ in failures}
    through = [group for group in plan.groups if complete(group)]
    return {name: row for name, row in plan.rows.items() if row["group"] in through}


STARTED = time.time()
# What no model is fitted to, and what is left out in turn: the settings of a study may name some.
HOLD_OUT, LEAVE_OUT = config.get("hold_out", []), config.get("leave_out")
TABLE, PLAN = checked_study()
# After a run in which samples failed, tables and figures of the others can still be had.
LEFT_OUT, FAILURES = [], []
if os.environ.get("SOFTSAMPLE_PARTIAL"):
    FAILURES = failed_jobs(f"{config['results']}/logs")
    came_through = finished(PLAN, FAILURES)
    LEFT_OUT = [name for name in PLAN.rows if name not in came_through]
    PLAN = Plan(came_through, PLAN.held_out)
    if not came_through:
        raise WorkflowError("no group of samples came through; there is nothing to report")
SAMPLES, GROUPS, PIECES = PLAN.rows, PLAN.groups, PLAN.pieces
COMPRESSED = [name for name in PIECES if SAMPLES[name]["mode"] == "compression"]
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


@cache
def imported(path):
    """Files of the library that a file imports directly, or by looking through its own folder."""
    text = path.read_text(encoding="utf-8")
    found = list(path.parent.glob("*.py")) if "iter_modules(__path__)" in text else []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            names = [node.module, *(f"{node.module}.{a.name}" for a in node.names)]
        elif isinstance(node, ast.Import):
            names = [a.name for a in node.names]
        else:
            continue
        parts = (accumulate(name.split("."), "{}/{}".format) for name in names)
        for name in chain.from_iterable(parts):
            files = (SOURCES / f"{name}.py", SOURCES / f"{name}/__init__.py")
            found += [file for file in files if file.is_file()]
    return found


def library(script):
    """Files of the library that a script imports, directly or not: its hidden inputs."""
    seen, todo = set(), [ROOT / script]
    while todo:
        new = set(imported(todo.pop())) - seen
        seen |= new
        todo += new
    return sorted(os.path.relpath(file) for file in seen)


# What a job on meshes needs beyond the default of a cluster's profile, with room to spare: measured
# with elements of 0.5 mm; smaller ones are more, and so are the steps. A second attempt gets twice.
FINER = max(1.0, 0.5 / config["mesh"]["element_size_mm"])
OF_MESHES = {
    "mem_mb": lambda wildcards, attempt: round(attempt * (400 + 400 * FINER**3)),
    "runtime": lambda wildcards, attempt: round(attempt * 5 * FINER**4),
}


# A compiled kernel that calls another file's text keeps the old callee after an edit, so each state
# of the compiled sources, elastic laws included, has a cache of its own. Kernels do without threads: jobs run side by side.
kernels = [
    path
    for path in sorted((SOURCES / "softsample").rglob("*.py"))
    if "numba" in path.read_text("utf-8") or "constitutive" in path.parts
]
state_of_kernels = sha256_of_files(kernels)[:16]
os.environ.update(NUMBA_CACHE_DIR=os.path.abspath(f".snakemake/numba/{state_of_kernels}"))
for variable in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


def sample_file(sample, column):
    """The file that a column of the sample's row names, as a list; empty if the cell is."""
    name = SAMPLES[known(sample)].get(column, "")
    return [os.path.normpath(os.path.join(os.path.dirname(TABLE), name))] if name else []


def study_file(column):
    """Input function: the file that a column of the sample's row names, none if it is empty."""

    def find(wildcards):
        return next(iter(sample_file(wildcards.sample, column)), [])

    return find


def sample_image(sample, column):
    """The image that a column of the sample's row names, first, and the files that it consists of.

    The time of a folder says less than those files: what is hidden in it, say, is none of them.
    """
    found = [file for path in sample_file(sample, column) for file in files_of(path)]
    return [ancient(file) if os.path.isdir(file) else file for file in found]


def study_image(column):
    """Input function: the image that a column of the sample's row names, with its files."""
    return lambda wildcards: sample_image(wildcards.sample, column)


def real_image(column):
    """Input function: the image that a column names, with its files, for the real geometry."""
    find = study_image(column)
    return lambda wildcards: find(wildcards) if wildcards.geometry != "ideal" else []


def known(sample):
    """The sample's id, or an error that lists those there are."""
    if sample not in SAMPLES:
        raise WorkflowError(f"no sample {sample!r} in {TABLE}; there are {', '.join(SAMPLES)}")
    return sample


def known_group(group):
    """The group's name, or an error that lists those there are."""
    if group not in GROUPS:
        raise WorkflowError(f"no group {group!r} in {TABLE}; there are {', '.join(GROUPS)}")
    return group


def samples_of(group):
    """The group's samples."""
    return GROUPS[known_group(group)]


def row_value(column):
    """Params function: one value of the sample's row."""
    return lambda wildcards: resolved(SAMPLES[known(wildcards.sample)])[column]


def row_modelled_ends(wildcards):
    """Params function: what the ends of the sample do in the model, which bonds unknown ones."""
    return modelled_ends(SAMPLES[known(wildcards.sample)])


def test_axes(wildcards):
    """Params function: image world axes of loading and shear."""
    row = SAMPLES[known(wildcards.sample)]
    return {name: row.get(name, default) for name, default in DEFAULT_AXES.items()}


def has_image(sample):
    """Whether the sample comes with an image."""
    return PLAN.has_image(known(sample))


def has_real(sample):
    """Whether the sample comes with an image or a surface."""
    return PLAN.has_real(known(sample))


def geometries_of(name):
    """Geometries of a group, or of a sample's group: real and ideal, or ideal alone."""
    return PLAN.geometries(name if name in GROUPS else known(name))


def piece_of(sample):
    """The sample whose mesh and curves stand for those of all equal pieces of the group."""
    return PLAN.piece_of[known(sample)]


def pieces_of(group):
    """Pieces of a group."""
    return PLAN.pieces_of(known_group(group))


def records_of(piece):
    """Samples that share a piece."""
    return PLAN.records_of(known(piece))


def members(group, model):
    """Samples of a group that take part in the calibration of a model."""
    return PLAN.members(known_group(group), model)


def rows_of(names):
    """Rows of samples, with what empty cells mean."""
    return [resolved(SAMPLES[name]) for name in names]


def others_of(group):
    """Samples of the other groups that tell of one, by group; none if they are not known in full.

    Their geometry is known as well as that of the group.
    """
    alike = [name for name in GROUPS if PLAN.best(name) == PLAN.best(group)]
    pooled = in_turn(HOLD_OUT, LEAVE_OUT, alike)
    return {name: GROUPS[name] for name in alike if pooled and name != group}


def verdicts_of_others(kind):
    """Input function: verdicts of these groups, on all of their records or by themselves."""
    return lambda wildcards: [
        f"<results>/loop/{name}/{kind}/verdict.json" for name in others_of(wildcards.group)
    ]


def open_others_of(group):
    """Other groups of open ends, which tell what the platens do to those of the group."""
    open_ends = [
        name for name in GROUPS if any(has_open_ends(SAMPLES[part]) for part in samples_of(name))
    ]
    return [name for name in open_ends if group in open_ends and name != group]


def ends_of_others(wildcards):
    """Input function: verdicts of these groups."""
    others = open_others_of(wildcards.group)
    return [f"<results>/loop/{name}/alone/verdict.json" for name in others]


def pools(group):
    """Whether the verdict of a group takes files of other groups."""
    alike = [name for name in GROUPS if PLAN.best(name) == PLAN.best(group)]
    return bool(open_others_of(group)) or (LEAVE_OUT == "group" and len(alike) > 1)


def folds_of(group):
    """Samples of each part of a group that is left out in turn, by the name of the fold.

    None where the study holds something out of one group at a time.
    """
    if LEAVE_OUT == "group":
        return {} if others_of(group) else {f"leave_out_{group}": samples_of(group)}
    rows = [SAMPLES[name] for name in samples_of(group)]
    return {f"leave_out_{value}": names for value, names in folds(rows, LEAVE_OUT)}


def calibration_curves(ending):
    """Input function: curves of the members of a calibration, one each, or their reports."""
    return lambda wildcards: [
        f"<results>/curves/{piece_of(name)}/{wildcards.geometry}/{wildcards.model}.{ending}"
        for name in members(wildcards.group, wildcards.model)
    ]


def calibration_meshes(wildcards):
    """Input function: meshes of the members of a calibration, one each."""
    return [
        f"<results>/mesh/{piece_of(name)}/{wildcards.geometry}.vtu"
        for name in members(wildcards.group, wildcards.model)
    ]


def calibration_shapes(wildcards):
    """Input function: idealised shapes of the members of a calibration, one each."""
    return [
        f"<results>/cuboid/{piece_of(name)}.json"
        for name in members(wildcards.group, wildcards.model)
    ]


def calibration_records(wildcards):
    """Input function: records of the samples that a calibration is made of."""
    names = members(wildcards.group, wildcards.model)
    return [f"<results>/records/{name}.csv" for name in names]


def bonded_of(group):
    """Samples of a group whose real top is bonded by a rule."""
    return [name for name in samples_of(group) if piece_of(name) in PLAN.bonded]


def calibrations(groups):
    """Calibration results of groups: every geometry and model."""
    return [
        f"<results>/calibration/{group}/{geometry}/{model}.json"
        for group in groups
        for geometry in geometries_of(group)
        for model in PLAN.models(group)
    ]


def optimum(kind):
    """Input function: calibration of the sample's group on the same geometry."""

    return lambda wildcards: calibration_of(wildcards.sample, wildcards.geometry, kind)


def calibration_of(sample, geometry, kind):
    """Calibration result of the sample's group on one geometry."""
    return f"<results>/calibration/{SAMPLES[known(sample)]['group']}/{geometry}/ogden2.{kind}"


def of_members(pattern):
    """Input function: a file for every sample of the group."""
    return lambda wildcards: expand(
        pattern, sample=samples_of(wildcards.group), **dict(wildcards.items())
    )


def of_pieces(pattern):
    """Input function: a file for every sample of the group, that of its piece."""
    return lambda wildcards: expand(
        pattern, sample=map(piece_of, samples_of(wildcards.group)), **dict(wildcards.items())
    )


def of_piece(pattern):
    """Input function: the file of the sample's piece."""
    return lambda wildcards: expand(
        pattern, sample=piece_of(wildcards.sample), geometry=wildcards.geometry
    )[0]


def of_real(pattern):
    """Input function: the sample's file of a pattern, none without a real geometry."""

    def find(wildcards):
        there = "real" in geometries_of(wildcards.sample)
        return pattern.format(sample=wildcards.sample) if there else []

    return find


def listed(find):
    """Input or params function: what another one finds, as a list."""
    return lambda wildcards: [name for name in [find(wildcards)] if name]


SHAPE_COLUMNS = ("shape", "length_mm", "width_mm", "height_mm", "diameter_mm")


def segmented(ending):
    """Input function: a result of the segmentation; none of a sample whose dimensions are stated."""

    def find(wildcards):
        row = SAMPLES[known(wildcards.sample)]
        there = "image" in row or "surface" in row
        return f"<results>/segmentation/{wildcards.sample}{ending}" if there else []

    return find


def shape_cells(wildcards):
    """Params function: cells of the sample's row about its idealised shape."""
    row = SAMPLES[known(wildcards.sample)]
    return {column: row[column] for column in SHAPE_COLUMNS if column in row}


def for_real(ending):
    """Input function: a result of the segmentation for the real geometry, none for the ideal one."""

    def find(wildcards):
        found = segmented(ending)(wildcards) if wildcards.geometry != "ideal" else []
        if wildcards.geometry != "ideal" and not found:
            raise WorkflowError(
                f"the dimensions of sample {wildcards.sample!r} are stated in {TABLE}: it has no "
                "real geometry; ask for the ideal one, or give an image or a surface"
            )
        return found

    return find


def records_of_piece(wildcards):
    """Input function: records of the samples that share the sample's piece."""
    names = records_of(piece_of(wildcards.sample))
    return [f"<results>/records/{name}.csv" for name in names]


def has_closed_form(piece, geometry, ends=None):
    """Whether the piece deforms uniformly, so that its response needs no run."""
    row = SAMPLES[piece]
    return geometry == "ideal" and is_homogeneous(row["mode"], ends or modelled_ends(row))


def mesh_of_runs(ending, ends=None):
    """Input function: a mesh of the piece, none if its response has a closed form."""
    return lambda wildcards: (
        []
        if has_closed_form(wildcards.sample, wildcards.geometry, ends)
        else f"<results>/mesh/{wildcards.sample}/{wildcards.geometry}{ending}.vtu"
    )


def coarsening(times):
    """Parameter: size of elements over that of the settings; any mesh holds a uniform field."""
    return lambda wildcards: times * (
        2 if has_closed_form(wildcards.sample, wildcards.geometry) else 1
    )


def diagnosed(wildcards):
    """Samples that a diagnosis is told of: those of the group, or all if a group is left out.

    All whose geometry is known as well as that of the group: others have another bias.
    """
    if LEAVE_OUT != "group":
        return samples_of(wildcards.group)
    best = PLAN.best(known_group(wildcards.group))
    return [name for name in SAMPLES if PLAN.best(name) == best]


def of_diagnosed(pattern, geometry=None, of=lambda name: name):
    """Input function: a file for each of these samples, or for its piece.

    Without a geometry it is the one nearest to the sample's: `real` if there is one.
    """
    return lambda wildcards: [
        pattern.format(sample=of(name), geometry=geometry or PLAN.best(wildcards.group))
        for name in diagnosed(wildcards)
    ]


def of_sliding(pattern, geometry=None):
    """Input function: files of the same pieces with sliding ends where these are unknown.

    None if all ends are stated.
    """

    def find(wildcards):
        pieces = [piece_of(name) for name in diagnosed(wildcards)]
        ends = ["_sliding" if has_open_ends(SAMPLES[piece]) else "" for piece in pieces]
        shape = geometry or PLAN.best(wildcards.group)
        found = zip(pieces, ends, strict=True) if any(ends) else []
        return [pattern.format(sample=piece, geometry=shape, ends=end) for piece, end in found]

    return find


def bonded_by_rule(wildcards):
    """Parameter: whether each of these samples has its real top bonded by a rule."""
    real = PLAN.best(wildcards.group) == "real"
    return [real and piece_of(name) in PLAN.bonded for name in diagnosed(wildcards)]


def bonds(wildcards):
    """Input function: what either rule makes of those that have."""
    names = zip(diagnosed(wildcards), bonded_by_rule(wildcards), strict=True)
    return [f"<results>/bond/{piece_of(name)}.json" for name, bonded in names if bonded]


def responses(geometry=None):
    """What a diagnosis on a geometry predicts records with."""
    return {
        "curves": of_diagnosed(
            "<results>/curves/{sample}/{geometry}/ogden2.csv", geometry, piece_of
        ),
        "perturbations": of_diagnosed(
            "<results>/loop/perturbations/{sample}_{geometry}.csv", geometry, piece_of
        ),
        "sliding_curves": of_sliding(
            "<results>/curves/{sample}/{geometry}/ogden2{ends}.csv", geometry
        ),
        "sliding_perturbations": of_sliding(
            "<results>/loop/perturbations/{sample}_{geometry}{ends}.csv", geometry
        ),
        "fit": lambda wildcards: (
            f"<results>/calibration/{wildcards.group}/"
            f"{geometry or PLAN.best(wildcards.group)}/ogden2.json"
        ),
        "records": of_diagnosed("<results>/records/{sample}.csv"),
        "cuboids": of_diagnosed("<results>/cuboid/{sample}.json", of=piece_of),
    }


def of_row(function):
    """Params function: what a function of the library makes of the sample's row."""
    return lambda wildcards: function(SAMPLES[known(wildcards.sample)])


def best_sensitivities(pieces):
    """Sensitivities to numerical choices, on the best geometry that each piece has."""
    return [f"<results>/sensitivity/{piece}/{PLAN.best(piece)}.json" for piece in pieces]


def everything_of(sample):
    """What `sample_{id}` builds: the sample's files, its group's calibration and checks."""
    group = SAMPLES[sample]["group"]
    runs = [run for run in PLAN.runs if run[0] in pieces_of(group)]
    return [
        *calibrations([group]),
        *(f"<results>/fields/{piece}/{geometry}.vtu" for piece, geometry in runs),
        *(f"<results>/checks/{piece}_{geometry}.json" for piece, geometry in runs),
        *best_sensitivities(pieces_of(group)),
    ]


def exports_of(sample):
    """What `export_{id}` builds: the sample's test at the optimum for other programs."""
    return [
        f"<results>/export/{sample}/{geometry}{ending}"
        for geometry in geometries_of(SAMPLES[sample]["group"])
        for ending in (".inp", "_calculix.inp", ".feb", ".pvd")
    ]


def simulated_laws(group):
    """Pieces of a group whose response to a law is simulated."""
    return [piece for piece in pieces_of(group) if not has_closed_form(piece, PLAN.best(piece))]


def law_pieces(wildcards):
    """Input or params function: these pieces."""
    return simulated_laws(wildcards.group)


def of_law_pieces(pattern):
    """Input function: a file for every piece of a group whose response is simulated."""
    return lambda wildcards: [
        pattern.format(sample=piece, geometry=PLAN.best(piece)) for piece in law_pieces(wildcards)
    ]


PAPER = [str(ROOT / f"resources/paper/{name}.csv") for name in ("moduli", "summary")]
PAPERS = TABLE.resolve() == (ROOT / "resources/cohort/samples.tsv").resolve()  # materials are its
COHORT = "virtual cohort" if PAPERS else f"study {TABLE.resolve().parent.name}"
FORMATS = ("png", "pdf")


def moduli_tables():
    """Table of moduli by model; none for a model that no group has."""
    names = {"ogden2": "table1", "ogden1": "table2"}
    return {m: f"<results>/tables/{t}.csv" for m, t in names.items() if groups_with(m)}


def tables():
    """The tables of the study, and the numbers that the captions quote."""
    names = [
        "geometry.csv",
        "summary.csv",
        "stress_strain.csv",
        "sensitivity.csv",
        *(["band.csv"] if PLAN.banded else []),
        *(["bond.csv"] if PLAN.bonded else []),
        "intervals.csv",
        "loop.csv",
        "numbers.rst",
        *(["contact.csv"] if COMPRESSED else []),
    ]
    return [*moduli_tables().values(), *(f"<results>/tables/{name}" for name in names)]


def figures():
    """The figures of the study, numbered as in the paper."""
    there = {2: PLAN.imaged, 3: True, 4: True, 5: True, 6: COMPRESSED, 7: True}
    names = [f"figure{number}" for number, asked in there.items() if asked]
    names += ["contact"] if COMPRESSED else []
    return [f"<results>/figures/{name}.{kind}" for name in names for kind in FORMATS]


# Pictures by kind: image and mesh, record and model, strain; and of which samples there are some.
PICTURES = {"samples": PLAN.imaged, "response": list(SAMPLES), "strain": PIECES}


def pictures():
    """The pictures of single samples."""
    return [f"<results>/figures/{kind}/{name}.png" for kind in PICTURES for name in PICTURES[kind]]


def captioned(names):
    """Those of the files that have a caption, which the report shows."""
    captions = {path.stem for path in (ROOT / "workflow/report").glob("*.rst")}
    return [
        name for name in names if name.endswith((".csv", ".png")) and Path(name).stem in captions
    ]


def checks():
    """Checks of every run and every calibration."""
    runs = [f"<results>/checks/{piece}_{geometry}.json" for piece, geometry in PLAN.runs]
    return runs + expand("<results>/checks/{group}_calibration.json", group=GROUPS)


def groups_with(model):
    """Groups that a model can be calibrated on."""
    return [group for group in GROUPS if model in PLAN.models(group)]


def of_alike(*files):
    """Input function: files that rest on samples of known shape, bonded, each tested once."""

    def find(wildcards):
        try:
            PLAN.check_alike()
        except SoftsampleError as error:
            raise WorkflowError(str(error)) from None
        if HOLD_OUT:
            raise WorkflowError(
                "experiments on shape and free exponents use whole records; ask for them without "
                "the setting hold_out"
            )
        return files

    return find


def geometry_results():
    """Tables and figures of the experiments on the geometry; contact needs compression samples."""
    tables = ["geometry_effects", "bias_shares", "cohort_needed"]
    names = ["geometry_effects"] + (["prescribed"] if COMPRESSED else [])
    return [
        *(f"<results>/tables/{name}.csv" for name in tables + names[1:]),
        *(f"<results>/figures/{name}.{kind}" for name in names for kind in FORMATS),
    ]


def fitted_groups(model):
    """Groups with a calibration of the model, by geometry."""
    return {
        geometry: [group for group in groups_with(model) if geometry in geometries_of(group)]
        for geometry in GEOMETRIES
    }


def fits(model, kind):
    """Calibrations of one model by geometry, in the order of `fitted_groups(model)`."""
    return {
        geometry: [f"<results>/calibration/{group}/{geometry}/{model}.{kind}" for group in groups]
        for geometry, groups in fitted_groups(model).items()
    }


# The pieces that stand for a loading mode in figures 3 and 7, and those of figure 2.
EXAMPLES = PLAN.examples(config["report"]["examples"])
BONDED_GROUPS = list(dict.fromkeys(SAMPLES[piece]["group"] for piece in PLAN.bonded))
SHOWN_GROUPS = list(dict.fromkeys(SAMPLES[name]["group"] for name in EXAMPLES.values()))
FIRST = [EXAMPLES.get("compression"), *EXAMPLES.values()]
SHOWN = next(name for name in [*FIRST, *PLAN.imaged] if name in (PLAN.imaged or PIECES))
SHOWN_GEOMETRIES = GEOMETRIES if has_real(SHOWN) else ["ideal"]
REAL_EXAMPLES = [name for name in EXAMPLES.values() if "real" in PLAN.geometries(name)]


def numbers_of_this_run():
    """The document of all numbers, if this run has made it."""
    path = Path(config["results"], "results.json")
    made = path.is_file() and path.stat().st_mtime >= STARTED
    return read_json(path) if made else None


onstart:
    # with a limit of jobs per time each look at the jobs asks for another one later, and looks breed:
    # in a study of 400 jobs they took a fifth of a core
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None
