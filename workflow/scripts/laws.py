"""Every law of the dictionary on the tests of a group (rule `laws_of_group`)."""

from softsample.fem.setup import set_up
from softsample.io import (
    read_json,
    read_mesh_with_data,
    read_record,
    read_table,
    write_json,
    write_table,
)
from softsample.laws.group import LawSettings, group_report
from softsample.laws.response import HomogeneousResponse
from softsample.laws.setup import simulated, tests_of
from softsample.records import reach
from softsample.response.floor import FloorSettings
from softsample.shapes import IdealShape
from softsample.workflow import logged_to, progress_bar, provenance

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    settings, material = LawSettings(**given.laws), given.material
    records = [read_record(path) for path in files.records]
    shapes = [IdealShape.of_report(read_json(path)) for path in files.cuboids]
    responses = {
        piece: HomogeneousResponse(shape, row["mode"], material["poisson_ratio"])
        for piece, shape, row in zip(given.pieces, shapes, given.rows, strict=True)
    }
    floor, scale_errors = FloorSettings(**given.floor), dict.fromkeys(given.pieces, 0.0)
    for piece, ends, mesh, curves, report, quality in zip(
        given.simulated,
        given.ends,
        files.meshes,
        files.curves,
        files.reports,
        files.qualities,
        strict=True,
    ):
        uniform = responses[piece]
        size = read_json(quality)["element_size_mm"]
        scale_errors[piece] = floor.scale_error(uniform.mode, size)
        sections = {name: given[name] for name in ("solver", "contact", "material")}
        own = [r for r, of in zip(records, given.pieces, strict=True) if of == piece]
        responses[piece] = simulated(
            set_up(*read_mesh_with_data(mesh), uniform.mode, **sections, ends=ends),
            reach(own, uniform.mode),
            uniform,
            material["alpha"],
            (read_table(curves), read_json(report)),
            read_json(files.fit[0])["mu1_fraction"],
        )
    tests = tests_of(
        given.rows,
        records,
        [responses[piece] for piece in given.pieces],
        [shape.height for shape in shapes],
        [scale_errors[piece] for piece in given.pieces],
        given.hold_out,
    )
    found, curves = group_report(
        tests,
        settings.laws(material["alpha"]),
        given.folds,
        0.01 * settings.curve_error_percent,
        given.confidence,
        progress_bar(),
    )
    write_table(snakemake.output.curves, curves)
    write_json(
        snakemake.output.report,
        {
            "group": snakemake.wildcards.group,
            "modes": [row["mode"] for row in given.rows],
            **found,
            "provenance": provenance(snakemake),
        },
    )
