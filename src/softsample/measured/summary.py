"""Summary and page of the studies of measured sets: `python -m softsample.measured.summary DIR`."""

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from softsample.errors import SoftsampleError
from softsample.figures.measured import held_out_figure
from softsample.figures.style import save
from softsample.files import written_aside
from softsample.io import read_json, read_samples, read_table, write_table, write_text
from softsample.measured.folder import CATALOGUE, chosen_studies
from softsample.measured.misfits import misfit_table
from softsample.measured.readers import READERS
from softsample.report.html import download, picture, render_report
from softsample.report.measured import overview_table, summary_table
from softsample.report.page import render_page
from softsample.study import ROOT, TABLE

FIGURE = "figures/measured/held_out.png"
TEMPLATES = ROOT / "workflow/report"


def write_summary(results: Path) -> None:
    """Write `summary.csv`, `misfits.csv`, `report.html`, and a page with its tables in `docs/`.

    Parameters
    ----------
    results
        Folder with `studies/{study}/samples.tsv` and the results of each study, `{study}/`.

    Raises
    ------
    InputError
        If a verdict or a table of samples is damaged.
    """
    summary = summary_table(verdicts(results))
    tables = {
        "summary": summary,
        "overview": overview_table(summary),
        "about": about_table(),
        "sources": source_table(read_table(CATALOGUE)),
    }
    write_table(results / "summary.csv", summary)
    write_table(results / "misfits.csv", misfit_table(results))
    figure = results / "docs" / FIGURE
    with written_aside(figure) as aside:
        save(held_out_figure(summary), aside)
    for name, table in tables.items():
        write_table(results / f"docs/data/measured/{name}.csv", table)
    write_text(results / "docs/measured.md", render_page(TEMPLATES / "measured.md.j2", tables))
    page = render_report(
        TEMPLATES / "measured.html.j2",
        overview=tables["overview"],
        summary=summary,
        download=download(results / "summary.csv"),
        figure=picture(figure, "Held-out error of every group, before and after"),
        about=tables["about"].to_dict("records"),
    )
    write_text(results / "report.html", page)


def verdicts(results: Path) -> Iterator[tuple[str, str, Mapping[str, Any] | None]]:
    """Study, group and verdict of every group that the study folders name; None if it failed."""
    for name in chosen_studies():
        table = results / "studies" / name / TABLE
        groups = dict.fromkeys(read_samples(table)["group"]) if table.is_file() else {}
        for group in groups:
            path = results / name / "loop" / group / "verdict.json"
            yield name, group, read_json(path) if path.is_file() else None


def about_table() -> pd.DataFrame:
    """What is known of each set: `set`, `studies`, `about`, `unstated` (joined by ``; ``)."""
    rows: dict[str, dict[str, str]] = {}
    for name, study in chosen_studies().items():
        reader = READERS[study["reader"]]
        row = rows.setdefault(
            reader.about,
            {"set": reader.set, "studies": "", "about": reader.about,
             "unstated": "; ".join(reader.unstated)},
        )  # fmt: skip
        row["studies"] = ", ".join(filter(None, (row["studies"], name)))
    return pd.DataFrame(list(rows.values()))


def source_table(catalogue: pd.DataFrame) -> pd.DataFrame:
    """`set`, `source`, `licence` and the number of `files` of each set of the catalogue."""
    sets = catalogue.groupby("set", sort=False)
    counted = sets["file"].count().rename("files").reset_index()
    sources = catalogue.drop_duplicates("set")[["set", "source", "licence"]]
    return sources.merge(counted, on="set")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; prints the page and returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m softsample.measured.summary", description=__doc__
    )
    parser.add_argument("results", type=Path, help="folder with studies/ and their results")
    given = parser.parse_args(arguments)
    try:
        write_summary(given.results)
    except (SoftsampleError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print(f"Summary: {given.results / 'report.html'}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
