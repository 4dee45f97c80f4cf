"""Compare geometry and moduli with the sealed truth (rule `compare_with_truth`)."""

from softsample.io import read_json, read_table, write_json, write_table
from softsample.scoring import score_summary, score_table
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    given = snakemake.params
    pairs = [(group, geometry) for group in given.groups for geometry in given.geometries]
    verdicts = map(read_json, snakemake.input.verdicts)
    table = score_table(
        dict(zip(given.samples, map(read_json, snakemake.input.truth), strict=True)),
        dict(zip(given.samples, map(read_json, snakemake.input.cuboids), strict=True)),
        given.groups,
        dict(zip(pairs, map(read_json, snakemake.input.fits), strict=True)),
        read_table(snakemake.input.intervals),
        {g: v["recommended"]["mu"] for g, v in zip(given.groups, verdicts, strict=True)},
    )
    write_table(snakemake.output.table, table)
    report = {**score_summary(table), "provenance": provenance(snakemake)}
    write_json(snakemake.output.report, report)
