"""The deforming sample as a series of meshes for ParaView (rule `series`)."""

from softsample.constitutive.ogden import of_fit
from softsample.export.series import write_series
from softsample.fem.setup import set_up
from softsample.io import read_json, read_mesh_with_data, read_record
from softsample.records import reach
from softsample.response.optimum import SNAPSHOTS, loading_time
from softsample.workflow import logged_to, progress_bar

with logged_to(snakemake):
    given = snakemake.params
    sample = read_mesh_with_data(snakemake.input.mesh)
    model, boundary = set_up(sample, given.mode, given, given.ends)
    bar = progress_bar()
    run = model.run(
        of_fit(read_json(snakemake.input.fit)),
        boundary,
        reach([read_record(path) for path in snakemake.input.records], given.mode),
        snapshots=SNAPSHOTS,
        loading_time=loading_time(read_json(snakemake.input.response), model),
        progress=lambda fraction: bar("run with snapshots", fraction),
    )
    write_series(snakemake.output.collection, model.mesh, run.snapshots)
