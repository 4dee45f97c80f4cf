"""Check the mesh and the runs of one sample on one geometry (rule `check_simulation`)."""

from softsample.checks import checked, simulation_checks
from softsample.io import read_json, read_mesh, write_json
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    checks = simulation_checks(
        read_mesh(snakemake.input.mesh),
        read_json(snakemake.input.quality),
        [read_json(path) for path in snakemake.input.curves],
        read_json(snakemake.input.direct),
        snakemake.params.limits,
    )
    write_json(snakemake.output.report, {**checked(checks), "provenance": provenance(snakemake)})
