"""Models of the ideal shapes of a set of others' records (rule `measured_models`)."""

from pathlib import Path

from softsample.fem.explicit import SolverSettings
from softsample.io import read_table, write_table
from softsample.measured.catalogue import check_files
from softsample.measured.models import ModelSettings, model_table
from softsample.measured.readers import READERS
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, name = snakemake.params, snakemake.wildcards.set
    catalogue = read_table(snakemake.input.catalogue)
    check_files(Path(given.root), catalogue[catalogue["set"] == name])
    keys = given.settings
    table = model_table(
        READERS[name].read(Path(given.root, name)),
        ModelSettings(tuple(keys["alpha"]), tuple(keys["kinds"]), keys["reach"], keys["elements"]),
        SolverSettings(**given.solver),
    )
    write_table(snakemake.output.models, table)
