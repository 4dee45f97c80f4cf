"""Grain of simulated curves, for `loop: noise: grain_percent`.

    python benchmarks/curve_grain.py SAMPLES.tsv RESULTS [SAMPLES.tsv RESULTS ...]

From the fourth differences of a curve at its group's optimum: their variance is 70 times that of an
error that each point has of its own. In parts of the peak, by mode and geometry.
"""

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
import pandas as pd

from softsample.calibration.curves import CurveFamily
from softsample.io import read_json, read_table


def grain_percent(results: Path, test: pd.Series, geometry: str) -> float:
    """Grain of the curve of one test [% of its peak]."""
    fit = read_json(results / f"calibration/{test['group']}/{geometry}/ogden2.json")
    table = read_table(results / f"curves/{test['sample']}/{geometry}/ogden2.csv")
    curve = CurveFamily.of_table(table, test["mode"]).curve(fit["mu1_fraction"])
    return float(100.0 * np.sqrt(np.mean(np.diff(curve, 4) ** 2) / 70.0) / curve[-1])


def main() -> None:
    """Print range and median by mode and geometry."""
    grains = defaultdict(list)
    for samples, results in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
        for _, test in pd.read_csv(samples, sep="\t").iterrows():
            for geometry in ("real", "ideal"):
                grain = grain_percent(Path(results), test, geometry)
                grains[test["mode"], geometry].append(grain)
    for (mode, geometry), of in sorted(grains.items()):
        spread = f"{min(of):.3f} to {max(of):.3f} %, median {np.median(of):.3f} %"
        print(f"{mode}, {geometry}: {spread} of {len(of)}")


if __name__ == "__main__":
    main()
