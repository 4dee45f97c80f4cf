"""docs/second_cohort.md from the scores of both virtual cohorts."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

import templates
from softsample.io import read_json
from softsample.scoring import percent

ROOT = Path(__file__).parents[1]
COHORTS = {"first": ("cohort", "results"), "second": ("second-cohort", "results/second-cohort")}
"""Folder below resources/, and results, by name."""

ROWS = (
    ("recommended μ in its 90 % interval", "groups_inside_recommended", " of {groups}"),
    ("calibrated μ in its 90 % interval", "groups_inside_interval", " of {groups}"),
    ("calibrated, without floor", "groups_inside_interval_without_floor", " of {groups}"),
    ("calibrated, without bonded area", "groups_inside_interval_without_bond", " of {groups}"),
    ("error of the recommended μ, median", "recommended_error_percent_median", " %"),
    ("error of the recommended μ, largest", "recommended_error_percent_worst", " %"),
    ("error of the calibrated μ, largest", "mu_error_percent_worst", " %"),
    ("bias in shear, mean", "bias_shear", " %"),
    ("bias in tension and compression, mean", "bias_axial", " %"),
)
"""Label, key of a cohort's summary, what follows the number."""

FREE = "ogden+ogden"
"""The law of the truth, with exponents that are fitted."""


def groups_of(name: str) -> pd.DataFrame:
    """One row a group of a cohort: its score and diagnosis."""
    results = ROOT / COHORTS[name][1]
    scores = pd.read_csv(results / "scoring" / "score.csv").drop_duplicates("group")
    verdicts = pd.read_csv(results / "tables" / "loop.csv", keep_default_na=False)
    real = verdicts[verdicts["geometry"] == "real"].set_index("group")
    found = [", ".join(filter(None, real.loc[g, ["verdict", "classes"]])) for g in scores["group"]]
    return scores.assign(found=[words.replace("|", " or ") for words in found])


def law_of(name: str, group: Mapping[str, Any]) -> dict[str, Any]:
    """What the choice of law says of a group, beside the true exponents."""
    folder, results = COHORTS[name]
    laws = ROOT / results / "laws"
    choice = read_json(laws / "choice.json")["groups"][group["group"]]
    free = read_json(laws / f"{group['group']}.json")["laws"][FREE]
    truth = read_json(ROOT / "resources" / folder / "truth" / f"{group['sample']}.json")
    by_name = ((free["shape"][key], free["intervals"][key]) for key in ("alpha1", "alpha2"))
    fitted = sorted(by_name, key=lambda pair: pair[0])
    return {
        "chosen": FREE in choice["equal"],
        "free_error_percent": percent(free["mu_pa"], group["mu_true_pa"]),
        "exponents": [
            templates.recovered(exact, value, interval["low"], interval["high"])
            for exact, (value, interval) in zip(truth["material"]["alpha"], fitted, strict=True)
        ],
    }


def summary_of(name: str, groups: pd.DataFrame) -> dict[str, Any]:
    """Summary of a cohort, numbers rounded to one decimal."""
    found = read_json(ROOT / COHORTS[name][1] / "scoring" / "score.json")
    shear = groups["group"].str.startswith("S")
    found |= {"bias_shear": groups["bias_percent"][shear].mean()}
    found |= {"bias_axial": groups["bias_percent"][~shear].mean()}
    return {k: f"{v:.1f}" if isinstance(v, float) else v for k, v in found.items()}


def main() -> None:
    """Write the page."""
    groups = {name: groups_of(name) for name in COHORTS}
    summaries = [summary_of(name, found) for name, found in groups.items()]
    second = [{**group, **law_of("second", group)} for group in groups["second"].to_dict("records")]
    templates.write_page(
        "second_cohort",
        rows=[
            (label, *(f"{found[key]}{unit.format(**found)}" for found in summaries))
            for label, key, unit in ROWS
        ],
        groups=second,
        axial=[group for group in second if group["group"].startswith("TC")],
    )


if __name__ == "__main__":
    main()
