"""The report of the study in one file (rule `page`)."""

from pathlib import Path

from softsample.calibration.slsqp import STARTS_PER_PARAMETER
from softsample.figures.strain import moved_surface
from softsample.figures.style import map_colours
from softsample.imaging.segment import BIAS_ORDER, FLUID_RATIO, SMOOTHING_MM
from softsample.io import read_json, read_mesh_with_data, read_table, read_yaml, write_text
from softsample.report.study import StudyReport, by_name
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given, shown = snakemake.input, snakemake.params
    runs, own = [*map(tuple, shown.runs)], provenance(snakemake)
    report = StudyReport(
        rows=shown.samples,
        groups=shown.groups,
        piece_of=shown.piece_of,
        inputs=by_name(shown.samples, map(read_json, given.inputs)),
        segmentation=by_name(shown.segmented, map(read_json, given.segmentation)),
        cuboid=by_name(shown.piece_of.values(), map(read_json, given.cuboid)),
        meshes=by_name(runs, map(read_json, given.mesh)),
        runs=by_name(runs, map(read_json, given.run)),
        surfaces=by_name(
            runs, (moved_surface(*read_mesh_with_data(name)) for name in given.fields)
        ),
        pictures={k: by_name(names, map(Path, given[k])) for k, names in shown.pictured.items()},
        fits=[*map(read_json, given.fits)],
        verdicts=by_name(shown.groups, map(read_json, given.verdict_json)),
        verdict_pages=by_name(shown.groups, map(Path, given.verdict_md)),
        verdict_plots=by_name(shown.groups, map(Path, given.verdict_png)),
        intervals=read_table(given.intervals),
        parts=Path(given.template).parent,
        config=shown.config,
    )
    page = report.page(
        Path(given.template),
        document=read_json(given.document),
        tables=by_name(map(Path, given.tables), map(read_table, given.tables)),
        figures=[*map(Path, given.figures)],
        checks={Path(name).stem: read_json(name)["checks"] for name in given.checks},
        schema=read_yaml(given.schema),
        colours=map_colours(),
        references=read_yaml(given.references),
        cohort=shown.cohort,
        ideal=shown.ideal,
        left_out=shown.left_out,
        failures=shown.failures,
        versions=own["versions"],
        settings_sha256=own["settings_sha256"],
        constants={
            "bias_order": BIAS_ORDER,
            "smoothing_mm": SMOOTHING_MM,
            "fluid_ratio": FLUID_RATIO,
            "starts_per_parameter": STARTS_PER_PARAMETER[shown.config["calibration"]["method"]],
        },
    )
    write_text(snakemake.output.page, page)
