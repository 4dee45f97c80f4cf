"""A study through Slurm, where there is one (`.ci/slurm` sets up a Slurm of one node)."""

import re
import subprocess
from pathlib import Path

import pytest
import toy

from conftest import contents
from softsample.costs import job_costs

COHORT = Path(__file__).resolve().parents[2] / "resources/cohort"
ANIMALS = ("S1", "S2", "TC1")
"""Groups of the cohort: all loading modes, and both sizes of a group."""

SLURM = (
    *("--workflow-profile", "workflow/profiles/slurm", "--slurm-no-account"),
    *("--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "5"),
)


def running():
    """Whether a Slurm answers here."""
    try:
        return subprocess.run(["sinfo"], capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False


pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not running(), reason="no Slurm is running here; .ci/slurm starts one"),
]


def the_same_both_ways(project, *targets):
    """Compare what a run through Slurm makes with what a local one does.

    Returns the number of jobs that were submitted, and the costs that all jobs noted.
    """
    project.cores = "1"  # of a group; more than a node has would wait for ever
    status, text = project.run(*targets, *SLURM)
    assert status == 0, text
    costs = job_costs(project.results / "logs")
    through_slurm = contents(project.results)

    project.results.rename(project.folder / "through Slurm")
    status, text_of_local_run = project.run(*targets)
    assert status == 0, text_of_local_run
    local = contents(project.results)
    assert local.keys() == through_slurm.keys()
    assert [name for name in local if local[name] != through_slurm[name]] == []
    return len(re.findall(r"submitted with SLURM jobid (\d+)", text)), costs


def test_a_study_through_slurm_has_the_results_of_a_local_run(project):
    toy.write_study(project.study, toy.SHEAR_ALONE)
    names = ("checks/passed.json", "tables/table1.csv", "loop/D/verdict.json")
    submitted, costs = the_same_both_ways(project, *(str(project.results / n) for n in names))
    assert submitted == 2  # the animal, and the tables
    assert costs["peak_mb"].max() < 800  # asked for


def test_animals_of_the_cohort_through_slurm_from_image_to_report(project):
    for part in ("images", "records"):
        (project.study / part).symlink_to(COHORT / part)
    rows = (COHORT / "samples.tsv").read_text().splitlines(keepends=True)
    chosen = [row for row in rows[1:] if row.split("\t")[1] in ANIMALS]
    project.table.write_text("".join([rows[0], *chosen]))
    project.config_file = "config/quick.yaml"
    submitted, _ = the_same_both_ways(project)
    assert submitted == len(ANIMALS) + 1
