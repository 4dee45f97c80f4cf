"""Figures 5 and 6: fitted curves and moduli (rules `figure5`, `figure6`)."""

from softsample.figures.moduli import GroupCurves, moduli_figure
from softsample.figures.style import save
from softsample.io import read_json, read_table, written_aside
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.input
    moduli = read_table(given.table)
    groups = [
        GroupCurves(
            row.group,
            row.mode,
            {"real": read_table(given.real[at]), "ideal": read_table(given.ideal[at])},
            all(read_json(fits[at])["success"] for fits in (given.real_fit, given.ideal_fit)),
        )
        for at, row in enumerate(moduli.itertuples())
    ]
    figure = moduli_figure(groups, moduli, snakemake.params.title)
    for path in snakemake.output:
        with written_aside(path) as aside:
            save(figure, aside)
