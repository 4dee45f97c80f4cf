"""A study through Slurm, where there is one (`.ci/slurm` sets up a Slurm of one node)."""

import re
import subprocess

import pytest
import toy

from conftest import contents
from softsample.workflow import FINISHED

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


@pytest.mark.long
@pytest.mark.skipif(not running(), reason="no Slurm is running here; .ci/slurm starts one")
def test_a_study_through_slurm_has_the_results_of_a_local_run(project):
    toy.write_study(project.study, toy.SHEAR_ALONE)
    project.cores = "1"  # of a group; more than a node has would wait for ever
    names = ("checks/passed.json", "tables/table1.csv", "loop/D/verdict.json")
    targets = [str(project.results / name) for name in names]
    status, text = project.run(*targets, *SLURM)
    assert status == 0, text
    submitted = re.findall(r"submitted with SLURM jobid (\d+)", text)
    assert len(submitted) == 2  # the animal, and the tables
    logs = list((project.results / "logs").rglob("*.log"))
    costs = [path.read_text().split(FINISHED)[1] for path in logs]
    assert (
        max(float(cost.split("at most ")[1].split()[0]) for cost in costs) < 800.0
    )  # MB asked for
    through_slurm = contents(project.results)

    project.results.rename(project.folder / "through Slurm")
    status, text = project.run(*targets)
    assert status == 0, text
    assert contents(project.results) == through_slurm
