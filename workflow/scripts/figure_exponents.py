"""Profile likelihood of moduli and exponents (rule `figure_exponents`)."""

from softsample.calibration.profile import normal_quantile
from softsample.figures.profiles import profile_figure
from softsample.figures.style import write
from softsample.io import read_table
from softsample.workflow import logged_to

with logged_to(snakemake):
    given = snakemake.params
    figure = profile_figure(
        read_table(snakemake.input.profiles),
        level=normal_quantile(given.confidence) ** 2,
        study={"alpha1": given.alpha[0], "alpha2": given.alpha[1]},
    )
    write(figure, *snakemake.output)
