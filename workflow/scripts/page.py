"""The report of the study in one file (rule `page`)."""

from itertools import chain
from pathlib import Path

from softsample.calibration.slsqp import STARTS_PER_PARAMETER
from softsample.figures.strain import Deformed
from softsample.figures.style import map_colours
from softsample.imaging.segment import BIAS_ORDER, FLUID_RATIO, SMOOTHING_MM
from softsample.io import read_json, read_mesh_with_data, read_table, read_yaml, write_text
from softsample.report.facts import findings_of, record_fact, sample_facts, verdict_sentence
from softsample.report.html import (
    as_json,
    caption,
    download,
    markdown,
    parameters,
    picture,
    render_report,
)
from softsample.report.results import brief
from softsample.report.scene import scene
from softsample.report.tables import moduli_shown
from softsample.workflow import logged_to, provenance

PICTURES = {"samples": "sample", "response": "response", "strain": "strain"}

with logged_to(snakemake):
    given, shown = snakemake.input, snakemake.params
    parts, config = Path(given.template).parent, shown.config
    group_of = {name: row["group"] for name, row in shown.samples.items()}
    samples, scenes, reports, inputs = {}, {}, [], {}
    kinds = ("segmentation", "cuboid")
    owners = (shown.segmented, dict.fromkeys(shown.piece_of.values()))
    reports_of = {
        kind: dict(zip(names, map(read_json, given[kind]), strict=True))
        for kind, names in zip(kinds, owners, strict=True)
    }
    pictures_of = {
        kind: dict(zip(names, map(Path, given[kind]), strict=True))
        for kind, names in shown.pictured.items()
    }
    runs, surfaces = {}, {}
    files = zip(shown.runs, given.mesh, given.run, given.fields, strict=True)
    for (name, geometry), *found, fields in files:
        runs.setdefault(name, {})[geometry] = [*map(read_json, found)]
        mesh, points, cells = read_mesh_with_data(fields)
        run = points["displacement_mm"], cells["max_principal_hencky_strain"]
        shape = Deformed.of_run(mesh, *run)
        surface = (shape.before.points, shape.after.points, shape.after.faces, shape.after.values)
        surfaces.setdefault(name, {})[geometry] = surface
    for (name, row), file in zip(shown.samples.items(), given.inputs, strict=True):
        found = read_json(file)
        inputs |= found["provenance"]["inputs"]
        reports.append(found)
        samples[name] = {
            "name": name,
            "mode": row["mode"].replace("_", " "),
            "piece": shown.piece_of[name],
            "pictures": [
                {
                    "picture": picture(pictures_of[kind][name], f"{name}, {kind}"),
                    "caption": caption(parts / f"{text}.rst", config, sample=name),
                }
                for kind, text in PICTURES.items()
                if name in pictures_of[kind]
            ],
        }
        if name in runs:
            scenes[name] = scene(surfaces[name])
            others = [reports_of[kind].get(name) for kind in kinds]
            mesh, run = (
                {geometry: pair[at] for geometry, pair in runs[name].items()} for at in (0, 1)
            )
            reports += [*filter(None, others), *mesh.values(), *run.values()]
            samples[name] |= {
                "limits": scenes[name]["limits"],
                "geometries": list(mesh),
                "facts": sample_facts(found, *others, mesh, run),
            }
        else:
            samples[name]["facts"] = [("Record", record_fact(found["record"]))]
    intervals, groups, fits = read_table(given.intervals), [], {}
    for fit in map(read_json, given.fits):
        fits.setdefault(fit["group"], []).append(fit)
    for at, (name, members) in enumerate(shown.groups.items()):
        verdict = read_json(given.verdict_json[at])
        reports.append(verdict)
        groups.append(
            {
                "name": name,
                "samples": [samples[member] for member in members],
                "real": "real" in runs[shown.piece_of[members[0]]],
                "findings": findings_of(fits[name]),
                "moduli": intervals[intervals["group"] == name].drop(columns="group"),
                "verdict": verdict["verdict"],
                "saying": verdict_sentence(verdict),
                "page": markdown(
                    Path(given.verdict_md[at]).read_text(encoding="utf-8"),
                    {"verdict.png": Path(given.verdict_png[at])},
                ),
            }
        )
    reports += chain.from_iterable(fits.values())
    real = any("real" in of for of in runs.values())
    checks = {Path(name).stem: read_json(name)["checks"] for name in given.checks}
    own = provenance(snakemake)
    page = render_report(
        Path(given.template),
        cohort=shown.cohort,
        cards=brief(read_json(given.document)),
        real=real,
        summary=caption(parts / ("workflow.rst" if real else "workflow_ideal.rst"), config),
        left_out=shown.left_out,
        failures=shown.failures,
        tables=[
            {
                "name": Path(name).stem,
                "frame": moduli_shown(Path(name).stem, read_table(name), intervals, group_of),
                "caption": caption(parts / f"{Path(name).stem}.rst", config),
                "download": download(Path(name)),
            }
            for name in given.tables
        ],
        figures=[
            {
                "name": Path(name).stem,
                "picture": picture(Path(name), Path(name).stem),
                "caption": caption(parts / f"{Path(name).stem}.rst", config),
            }
            for name in given.figures
        ],
        groups=groups,
        imaged=bool(shown.pictured["samples"]),
        ideal=shown.ideal,
        config=config,
        constants={
            "bias_order": BIAS_ORDER,
            "smoothing_mm": SMOOTHING_MM,
            "fluid_ratio": FLUID_RATIO,
            "starts_per_parameter": STARTS_PER_PARAMETER[config["calibration"]["method"]],
        },
        references=read_yaml(given.references),
        parameters=list(parameters(config, read_yaml(given.schema))),
        checks=[{"of": of, **check} for of, found in checks.items() for check in found],
        versions=own["versions"],
        settings_sha256=own["settings_sha256"],
        stages={r["provenance"]["rule"]: r["provenance"]["code_sha256"] for r in reports},
        inputs=inputs,
        scenes=as_json(
            {
                "colours": map_colours(),
                "extent_mm": max(s["extent_mm"] for s in scenes.values()),
                "samples": scenes,
            }
        ),
    )
    write_text(snakemake.output.page, page)
