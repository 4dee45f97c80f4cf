"""What a large study takes on few and on many cores; writes results/bench/scale.json.

python benchmarks/scale.py RESULTS OUTPUT: costs of jobs from the logs of a finished study, costs of
Snakemake from dry runs of studies made of copies of its table. CPU seconds, of one thread.
"""

import re
import resource
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import pandas as pd

from softsample.costs import job_costs
from softsample.io import read_json, read_samples, write_json
from softsample.workflow import versions

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "resources/cohort/samples.tsv"
COPIES = (1, 30)
"""Sizes of the studies that are planned, in times the cohort; the larger has about 10,000 jobs."""

SAMPLES = 1000
CORES = (2, 64, 1024)
CORES_OF_ANIMAL = 4
"""Cores that the cluster's profile gives to the jobs of one animal."""


@dataclass(frozen=True)
class Study:
    """Costs of a finished study; jobs of samples log in folders, those of the whole beside them.

    What the cheapest of the latter takes is taken for the start of each, whatever it then does.
    """

    samples: int
    element_size_mm: float
    samples_per_animal: float
    jobs_per_sample: float
    cpu_s_per_sample: float
    cpu_s_of_tables: float
    start_s_of_tables: float
    largest_mb: dict[str, int]

    @classmethod
    def of_results(cls, results: Path) -> "Study":
        """Costs that the jobs of a finished study noted at the end of their logs."""
        found = job_costs(results / "logs")
        table = pd.DataFrame(read_json(results / "results.json")["samples"]).T
        mesh = read_json(next(results.glob("mesh/*/real.json")))
        own, of_all, samples = found[found["own"]], found[~found["own"]], len(table)
        return cls(
            samples,
            mesh["provenance"]["settings"]["mesh"]["element_size_mm"],
            samples / table["group"].nunique(),
            len(own) / samples,
            own["cpu_s"].sum() / samples,
            of_all["cpu_s"].sum(),
            len(of_all) * of_all["cpu_s"].min(),
            found.groupby("kind")["peak_mb"].max().sort_values(ascending=False).to_dict(),
        )


@dataclass(frozen=True)
class Planning:
    """CPU seconds that Snakemake takes to read and to plan a study, linear in its size."""

    jobs: int
    fixed_s: float
    per_job_s: float
    start_s: float
    start_s_per_sample: float

    @classmethod
    def measured(cls) -> "Planning":
        """From dry runs of two sizes: the whole study, and one job of it."""
        sizes = [len(read_samples(TABLE)) * copies for copies in COPIES]
        with tempfile.TemporaryDirectory() as folder:
            tables = [_copies(TABLE, copies, Path(folder, str(copies))) for copies in COPIES]
            (few, short), (many, long) = (_dry_run(table) for table in tables)
            first = read_samples(tables[0])["sample"].iloc[0]
            (_, start), (_, late_start) = (
                _dry_run(table, f"inputs/{first}.json") for table in tables
            )
        per_job = (long - short) / (many - few)
        per_sample = (late_start - start) / (sizes[1] - sizes[0])
        return cls(many, short - few * per_job, per_job, start, per_sample)


def _copies(table: Path, copies: int, folder: Path) -> Path:
    """A study of so many copies of each animal of a table, with links to its files."""
    folder.mkdir()
    rows = read_samples(table)
    for part in {Path(name).parts[0] for name in pd.concat([rows["image"], rows["record"]])}:
        (folder / part).symlink_to(table.parent / part)
    again = [
        rows.assign(sample=rows["sample"] + f"_{k}", group=rows["group"] + f"_{k}")
        for k in range(copies)
    ]
    target = folder / "samples.tsv"
    pd.concat(again).to_csv(target, sep="\t", index=False)
    return target


def _dry_run(table: Path, *results: str) -> tuple[int, float]:
    """Number of jobs and CPU seconds of a dry run, of some results or of the whole study."""
    before = _cpu_of_children()
    folder = table.parent / "results"
    targets = [f"{folder}/{name}" for name in results]
    run = subprocess.run(
        [
            *(sys.executable, "-m", "snakemake", "-n", "--cores", "1", *targets),
            *("--config", f"samples={table}", f"results={folder}"),
        ],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    total = re.findall(r"^total\s+(\d+)$", run.stdout + run.stderr, re.M)
    return int(total[-1]), _cpu_of_children() - before


def _cpu_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def hours(study: Study, planning: Planning, cores: int) -> dict[str, float]:
    """Hours that `SAMPLES` samples take on so many cores, and what they are made of.

    On one machine the jobs share the cores. On a cluster each job starts a Snakemake of its own
    first, and the last animal may begin when all others end. Planning and the tables are serial;
    all that the tables take beyond their start is taken to grow with the samples.
    """
    cluster = cores > CORES[0]
    start = planning.start_s + SAMPLES * planning.start_s_per_sample if cluster else 0.0
    per_sample = study.cpu_s_per_sample + start * study.jobs_per_sample
    growing = study.cpu_s_of_tables - study.start_s_of_tables
    seconds = {
        "planning": planning.fixed_s + planning.per_job_s * SAMPLES * study.jobs_per_sample,
        "samples": SAMPLES * per_sample / cores,
        "last_animal": cluster * study.samples_per_animal * per_sample / CORES_OF_ANIMAL,
        "tables": study.start_s_of_tables + growing * SAMPLES / study.samples,
    }
    parts = {f"{name}_h": value / 3600.0 for name, value in seconds.items()}
    return {"cores": cores, "total_h": sum(parts.values()), **parts}


def main() -> None:
    """Measure, print and write."""
    results, target = sys.argv[1:]
    study = Study.of_results(Path(results))
    planning = Planning.measured()
    estimates = [hours(study, planning, cores) for cores in CORES]
    print(pd.Series(asdict(study)).drop("largest_mb").to_string())
    print(pd.Series(asdict(planning)).to_string())
    print(f"{SAMPLES} samples:\n{pd.DataFrame(estimates).round(2).to_string(index=False)}")
    found = {"study": asdict(study), "planning": asdict(planning), "samples": SAMPLES}
    write_json(target, {**found, "estimates": estimates, "versions": versions()})


if __name__ == "__main__":
    main()
