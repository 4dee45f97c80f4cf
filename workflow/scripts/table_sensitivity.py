"""Effect of numerical choices on the curve of every sample (rule `table_sensitivity`)."""

import pandas as pd

from softsample.io import read_json, write_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    rows = [
        {"sample": sample, "change": name, **figures}
        for sample, path in zip(snakemake.params.samples, snakemake.input.reports, strict=True)
        for name, figures in read_json(path)["changes"].items()
    ]
    write_table(snakemake.output.table, pd.DataFrame(rows))
