"""The report of the study in one file (rule `page`)."""

from pathlib import Path

from softsample.figures.strain import Deformed
from softsample.figures.style import map_colours
from softsample.io import read_json, read_mesh_with_data, read_table, read_yaml, write_text
from softsample.report.facts import sample_facts, verdict_sentence
from softsample.report.html import (
    as_json,
    caption,
    download,
    markdown,
    parameters,
    picture,
    render_report,
)
from softsample.report.scene import scene
from softsample.workflow import logged_to, provenance

GEOMETRIES = ("real", "ideal")
PICTURES = {"samples": "sample", "response": "response", "strain": "strain"}

with logged_to(snakemake):
    given, shown = snakemake.input, snakemake.params
    parts, config = Path(given.template).parent, shown.config
    samples, scenes, reports, inputs = {}, {}, [], {}
    for at, (name, row) in enumerate(shown.samples.items()):
        surfaces = {}
        for geometry in GEOMETRIES:
            mesh, points, cells = read_mesh_with_data(given[f"fields_{geometry}"][at])
            run = points["displacement_mm"], cells["max_principal_hencky_strain"]
            shape = Deformed.of_run(mesh, *run)
            surfaces[geometry] = (shape.before.points, shape.after.points, shape.after.faces)
            surfaces[geometry] += (shape.after.values,)
        scenes[name] = scene(surfaces)
        found, *others = (read_json(given[k][at]) for k in ("inputs", "segmentation", "cuboid"))
        mesh, run = (
            {geometry: read_json(given[f"{kind}_{geometry}"][at]) for geometry in GEOMETRIES}
            for kind in ("mesh", "run")
        )
        inputs |= found["provenance"]["inputs"]
        reports += [found, *others, *mesh.values(), *run.values()]
        samples[name] = {
            "name": name,
            "mode": row["mode"],
            "limits": scenes[name]["limits"],
            "facts": sample_facts(found, *others, mesh, run),
            "pictures": [
                {
                    "picture": picture(Path(given[kind][at]), f"{name}, {kind}"),
                    "caption": caption(parts / f"{text}.rst", config, sample=name),
                }
                for kind, text in PICTURES.items()
            ],
        }
    intervals, groups = read_table(given.intervals), []
    for at, (name, members) in enumerate(shown.groups.items()):
        verdict = read_json(given.verdict_json[at])
        reports.append(verdict)
        groups.append(
            {
                "name": name,
                "samples": [samples[member] for member in members],
                "moduli": intervals[intervals["group"] == name].drop(columns="group"),
                "verdict": verdict["verdict"],
                "saying": verdict_sentence(verdict),
                "page": markdown(
                    Path(given.verdict_md[at]).read_text(encoding="utf-8"),
                    {"verdict.png": Path(given.verdict_png[at])},
                ),
            }
        )
    checks = {Path(name).stem: read_json(name)["checks"] for name in given.checks}
    own = provenance(snakemake)
    reports += [read_json(name) for name in given.fits]
    page = render_report(
        Path(given.template),
        cohort=shown.cohort,
        summary=caption(parts / "workflow.rst", config),
        left_out=shown.left_out,
        failures=shown.failures,
        tables=[
            {
                "name": Path(name).stem,
                "frame": read_table(name),
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
        config=config,
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
