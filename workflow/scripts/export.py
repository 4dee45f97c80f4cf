"""The calibrated test for other programs: input, material cards, mesh, curve (rule `export`)."""

from softsample import io
from softsample.constitutive.ogden import of_fit
from softsample.export.programs import export_test
from softsample.fem.boundary import ContactSettings
from softsample.files import copy
from softsample.records import reach
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files, written = snakemake.params, snakemake.input, snakemake.output
    fit, curve = io.read_json(files.fit), io.read_table(files.curve)
    export_test(
        written,
        files.mesh,
        io.read_mesh_with_data(files.mesh),
        of_fit(fit),
        (given.mode, given.ends, ContactSettings(**given.contact)),
        reach(map(io.read_record, files.records), given.mode),
        f"group {fit['group']}, {fit['geometry']} geometry, {fit['verdict']}",
    )
    own = curve[curve["sample"] == snakemake.wildcards.sample]
    io.write_table(written.curve, own.drop(columns="sample"))
    copy(files.mesh, written.mesh)
    copy(files.surface, written.surface)
