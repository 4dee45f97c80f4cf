"""Figures 5 and 6: fitted curves and moduli (rules `figure5`, `figure6`)."""

from softsample.figures.moduli import GroupCurves, moduli_figure
from softsample.figures.style import save
from softsample.io import read_table, written_aside
from softsample.workflow import logged_to

with logged_to(snakemake.log[0]):
    given = snakemake.input
    moduli = read_table(given.table, text_columns=("group",))
    groups = [
        GroupCurves(row.group, row.mode, {"real": read_table(real), "ideal": read_table(ideal)})
        for row, real, ideal in zip(moduli.itertuples(), given.real, given.ideal, strict=True)
    ]
    figure = moduli_figure(groups, moduli, snakemake.params.title)
    for path in snakemake.output:
        with written_aside(path) as aside:
            save(figure, aside)
