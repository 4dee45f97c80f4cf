"""Figures 5 and 6: fitted curves and moduli (rules `figure5`, `figure6`)."""

from softsample.figures.moduli import GroupCurves, limits_of, moduli_figure
from softsample.figures.style import write
from softsample.io import read_json, read_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given, shown = snakemake.input, snakemake.params
    moduli, intervals = read_table(given.table), read_table(given.intervals)
    files = {
        (group, geometry): pair
        for geometry, groups in shown.groups.items()
        for group, *pair in zip(groups, given[geometry], given[f"{geometry}_fit"], strict=True)
    }
    groups = []
    for group, row in zip(shown.groups["ideal"], moduli.itertuples(), strict=True):
        there = {name: files[group, name] for name in shown.groups if (group, name) in files}
        curves = {name: read_table(curve) for name, (curve, _) in there.items()}
        trusted = all(read_json(fit)["success"] for _, fit in there.values())
        limits = limits_of(intervals, group, shown.model)
        groups.append(GroupCurves(row.group, row.mode, curves, trusted, limits))
    figure = moduli_figure(groups, moduli, shown.ideal)
    write(figure, *snakemake.output)
