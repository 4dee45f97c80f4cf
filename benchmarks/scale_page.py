"""docs/cluster.md from docs/data/scale.json, which scale.py writes, and slurm.json beside it.

python benchmarks/scale_page.py [RESULT OF scale.py, which is then the one that is shown].
"""

import shutil
import sys
from pathlib import Path

import pandas as pd

from softsample.io import read_json, write_text
from softsample.report.page import render_page

DOCS = Path(__file__).parents[1] / "docs"
PAGE = DOCS / "cluster.md"
SCALE, SLURM = DOCS / "data/scale.json", DOCS / "data/slurm.json"
TEMPLATE = Path(__file__).with_name("cluster.md.j2")


def page() -> str:
    """The whole page."""
    found = read_json(SCALE)
    memory = found["study"].pop("largest_mb")
    tables = {
        "study": [found["study"] | {"asked": found["samples"]}],
        "memory": [{"kind": kind, "largest_mb": value} for kind, value in memory.items()],
        "planning": [found["planning"]],
        "estimates": found["estimates"],
        "slurm": [read_json(SLURM)],
    }
    return render_page(TEMPLATE, {name: pd.DataFrame(rows) for name, rows in tables.items()})


def main(source: str | None = None) -> None:
    """Take over a newer measurement, if one is given, and write the page."""
    if source:
        shutil.copy(source, SCALE)
    write_text(PAGE, page())


if __name__ == "__main__":
    main(*sys.argv[1:])
