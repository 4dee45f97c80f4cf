"""Interval of the shear modulus by the uncertain boundary of every sample (rule `table_band`)."""

import pandas as pd

from softsample.io import read_json, write_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    reports = map(read_json, snakemake.input.reports)
    rows = [
        {"sample": sample, **{k: v for k, v in report.items() if k != "provenance"}}
        for sample, report in zip(snakemake.params.samples, reports, strict=True)
    ]
    write_table(snakemake.output.table, pd.DataFrame(rows))
