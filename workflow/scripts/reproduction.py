"""Pages of the documentation with their tables and figures (rule `reproduction`)."""

from pathlib import Path

import pandas as pd

from softsample.figures.small import shrink
from softsample.files import sha256
from softsample.io import read_json, read_table, write_table, write_text
from softsample.report.claims import claims_table, fit_errors
from softsample.report.page import render_page
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, out = snakemake.input, snakemake.output
    data, figures = Path(out.data), Path(out.figures)
    write_table(data / "settings.csv", pd.DataFrame([dict(snakemake.params.settings)]))
    for source in map(Path, given.tables):
        write_table(data / source.name, read_table(source))
    write_table(data / "fit_errors.csv", fit_errors(map(read_json, [*given.real, *given.ideal])))
    tables = {path.stem: read_table(path) for path in sorted(data.glob("*.csv"))}
    tables["claims"] = claims_table(tables)
    write_table(data / "claims.csv", tables["claims"])
    for source in map(Path, given.figures):
        shrink(source, figures / source.name)
    written = [*sorted(data.glob("*.csv")), *sorted(figures.glob("*.png"))]
    sums = {"file": [path.name for path in written], "sha256": list(map(sha256, written))}
    write_table(data / "SHA256.csv", sums)
    for template, page in zip(given.templates, out.pages, strict=True):
        write_text(page, render_page(Path(template), tables))
