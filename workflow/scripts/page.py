"""The report of the study in one file (rule `page`)."""

from softsample.from_files.page import report_page
from softsample.io import write_text
from softsample.workflow import logged_to, provenance

with logged_to(snakemake):
    page = report_page(snakemake.input, snakemake.params, provenance(snakemake))
    write_text(snakemake.output.page, page)
