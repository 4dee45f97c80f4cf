"""Table 1 or 2: moduli on both geometries beside the paper's (rules `table_moduli...`)."""

import logging

from softsample.io import read_json, read_table, write_table
from softsample.report.tables import moduli_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, paper = snakemake.input, snakemake.input.paper
    shapes = dict(zip(snakemake.params.samples, map(read_json, given.cuboids), strict=True))
    table, notes = moduli_table(
        map(read_json, [*given.ideal, *given.real]),
        snakemake.params.model,
        read_table(paper) if paper else None,
        shapes,
    )
    for note in notes:
        logging.getLogger("table").warning(note)
    write_table(snakemake.output.table, table)
