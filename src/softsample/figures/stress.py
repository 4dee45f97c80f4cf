"""Figure 4: nominal stress against nominal strain."""

import pandas as pd
from matplotlib.figure import Figure

from softsample.figures.style import MODE_COLOURS, page_figure, styled
from softsample.wording import spoken


@styled
def stress_strain_figure(table: pd.DataFrame) -> Figure:
    """Mean nominal stress of each loading mode with a band of one standard deviation.

    Parameters
    ----------
    table
        `softsample.report.stress.stress_strain_table`: `mode`, `strain`, `mean_stress_pa`,
        `sd_stress_pa`, `count`; absolute values.
    """
    figure = page_figure(height_mm=85.0, width_mm=120.0)
    ax = figure.add_subplot()
    for mode in (name for name in MODE_COLOURS if name in set(table["mode"])):
        curve = table[table["mode"] == mode]
        strain, stress = curve["strain"], 1e-3 * curve["mean_stress_pa"]
        band = 1e-3 * curve["sd_stress_pa"].fillna(0.0)
        label = f"{spoken(mode).capitalize()} (n = {curve['count'].iloc[0]})"
        ax.fill_between(
            strain, stress - band, stress + band, color=MODE_COLOURS[mode], alpha=0.22, lw=0
        )
        ax.plot(strain, stress, color=MODE_COLOURS[mode], label=label)
    ax.set(xlabel="Nominal strain, absolute [–]", ylabel="Nominal stress, absolute [kPa]")
    ax.set_xlim(left=0.0)
    ax.set_ylim(bottom=0.0)
    ax.legend(
        loc="upper left", title="Line: mean, band: ± 1 SD", title_fontsize=7.5, alignment="left"
    )
    return figure
