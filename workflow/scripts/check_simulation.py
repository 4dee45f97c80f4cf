"""Check the mesh and the runs of one sample on one geometry (rule `check_simulation`)."""

from softsample.checks import simulation_checks
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
    report = {"passed": all(item["passed"] for item in checks), "checks": checks}
    write_json(snakemake.output.report, {**report, "provenance": provenance(snakemake)})
