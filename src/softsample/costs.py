"""What jobs cost: as they noted at the end of their logs, and to ask a cluster for."""

import os
import re
from pathlib import Path

import pandas as pd

from softsample.errors import InputError
from softsample.workflow import FINISHED

COST = re.compile(re.escape(FINISHED) + r"([\d.]+) s of CPU, at most (\d+) MB")


def mesh_memory_mb(element_size_mm: float, attempt: int) -> int:
    """Memory [MB] to ask a cluster for, for a job on a mesh; a second attempt gets twice.

    With room to spare: measured with elements of 0.5 mm; smaller ones are more.
    """
    return round(attempt * (400 + 400 * max(1.0, 0.5 / element_size_mm) ** 3))


def mesh_runtime_min(element_size_mm: float, attempt: int) -> int:
    """Time [min] to ask for; smaller elements need more steps, too."""
    return round(attempt * 5 * max(1.0, 0.5 / element_size_mm) ** 4)


def diagnosis_runtime_min(tests: int, folds: int, attempt: int) -> int:
    """Time [min] to ask for, for a verdict on tests of which so many parts are left out in turn.

    Measured: 2.5 min for one test of open ends, 2 min for three tests and as many folds.
    """
    return attempt * (4 + 2 * tests * (1 + folds))


def pool_runtime_min(groups: int, attempt: int) -> int:
    """Time [min] to ask for, for what groups tell of each other; measured: 13 min for six."""
    return attempt * (10 + groups**2)


def pool_memory_mb(groups: int, attempt: int) -> int:
    """Memory [MB] to ask for, for the same; measured: 530 MB for six groups of one test."""
    return attempt * (600 + 60 * groups)


def job_costs(logs: str | os.PathLike[str]) -> pd.DataFrame:
    """Costs of all jobs of a study that came through.

    Parameters
    ----------
    logs
        Folder of the logs; jobs of one sample or animal log in folders, those of the whole study
        beside them.

    Returns
    -------
    pandas.DataFrame
        Columns `kind` (of job), `own` (whether it is of one sample or animal), `cpu_s`, `peak_mb`.

    Raises
    ------
    InputError
        If no log tells a cost.
    """
    rows = [
        (
            path.relative_to(logs).with_suffix("").parts[0],
            path.parent != Path(logs),
            *found.groups(),
        )
        for path in sorted(Path(logs).rglob("*.log"))
        if (found := COST.search(path.read_text(encoding="utf-8", errors="replace")))
    ]
    if not rows:
        raise InputError(f"{logs}: no costs of jobs; run the study first (make run)")
    table = pd.DataFrame(rows, columns=["kind", "own", "cpu_s", "peak_mb"])
    return table.astype({"cpu_s": float, "peak_mb": int})


def cost_table(logs: str | os.PathLike[str]) -> pd.DataFrame:
    """CPU time and memory by kind of job, most costly first, with their sum in the last row.

    Snakemake's own time is not in it. Columns: `kind`, `jobs`, `cpu_s` (all jobs together),
    `cpu_s_largest` (of one job), `share_percent` (of all), `peak_mb`. Errors as in `job_costs`.
    """
    jobs = job_costs(logs)
    table, total = (
        of.groupby("kind", as_index=False).agg(
            jobs=("cpu_s", "size"),
            cpu_s=("cpu_s", "sum"),
            cpu_s_largest=("cpu_s", "max"),
            peak_mb=("peak_mb", "max"),
        )
        for of in (jobs, jobs.assign(kind="all"))
    )
    table = pd.concat([table.sort_values("cpu_s", ascending=False), total], ignore_index=True)
    table.insert(4, "share_percent", 100.0 * table["cpu_s"] / total["cpu_s"][0])
    return table
