"""Contact area in compression: means over samples and curves (rule `contact_area`)."""

from softsample.figures.contact import contact_figure
from softsample.figures.style import write
from softsample.io import read_json, read_table, write_table
from softsample.report.contact import contact_share, contact_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, files = snakemake.params, snakemake.input
    pairs = zip(map(read_table, files.contacts), map(read_json, files.cuboids), strict=True)
    shares = {tuple(run): contact_share(*pair) for run, pair in zip(given.runs, pairs, strict=True)}
    write_table(snakemake.output.table, contact_table(shares))
    figure = contact_figure(shares, given.ideal)
    write(figure, snakemake.output.png, snakemake.output.pdf)
