"""Report on others' records in one file, a page a set (rule `measured_report`)."""

from pathlib import Path

from softsample.figures.measured import held_out_figure
from softsample.figures.style import save
from softsample.io import read_json, read_table, write_text, written_aside
from softsample.report.html import download, markdown, render_report
from softsample.report.measured import set_page, summary_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, pages = snakemake.input, []
    for verdict, figure in zip(
        map(read_json, given.verdicts), snakemake.output.figures, strict=True
    ):
        with written_aside(figure) as aside:
            save(held_out_figure(summary_table([verdict])), aside)
        page = markdown(set_page(verdict), {"errors.png": Path(figure)})
        pages.append({"name": verdict["set"], "page": page})
    page = render_report(
        Path(given.template),
        summary=read_table(given.summary),
        download=download(Path(given.summary)),
        sets=pages,
    )
    write_text(snakemake.output.page, page)
