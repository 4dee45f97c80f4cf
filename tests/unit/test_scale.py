import pandas as pd
import pytest

from scale import CORES, Planning, Study, hours
from softsample.errors import InputError
from softsample.workflow import FINISHED

ANIMALS = pd.DataFrame({"sample": ["T1", "C1", "S1"], "group": ["TC1", "TC1", "S1"]})
PLANNING = Planning(jobs=1000, fixed_s=2.0, per_job_s=0.004, start_s=2.5, start_s_per_sample=0.001)


def log(path, cpu_s, mb):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"... {FINISHED}{cpu_s} s of CPU, at most {mb} MB of memory\n")


@pytest.fixture
def study(tmp_path):
    log(tmp_path / "mesh/T1_real.log", 12.0, 300)
    log(tmp_path / "mesh/C1_real.log", 20.0, 400)
    log(tmp_path / "segment/S1.log", 4.0, 600)
    log(tmp_path / "figure2.log", 3.0, 200)
    (tmp_path / "mesh/S1_real.log").write_text("failed")
    return Study.of_logs(tmp_path, ANIMALS)


def test_costs_of_samples_and_of_tables_are_told_apart(study):
    assert study.cpu_s_per_sample == pytest.approx(36.0 / 3.0)
    assert study.cpu_s_of_tables == 3.0
    assert (study.jobs_per_sample, study.samples_per_animal) == (1.0, 1.5)
    assert list(study.largest_mb.items()) == [("segment", 600), ("mesh", 400), ("figure2", 200)]


def test_one_machine_shares_the_work_and_a_cluster_also_starts_each_job(study):
    two, many, most = (hours(study, PLANNING, cores) for cores in CORES)
    assert two["samples_h"] == pytest.approx(1000 * 12.0 / 2 / 3600.0)
    assert two["last_animal_h"] == 0.0
    assert many["samples_h"] == pytest.approx(1000 * (12.0 + 3.5) / 64 / 3600.0)
    assert many["last_animal_h"] == pytest.approx(1.5 * (12.0 + 3.5) / 4 / 3600.0)
    assert most["planning_h"] == two["planning_h"] == pytest.approx((2.0 + 4.0) / 3600.0)
    for found in (two, many, most):
        parts = [value for name, value in found.items() if name not in ("cores", "total_h")]
        assert found["total_h"] == pytest.approx(sum(parts))


def test_a_study_that_has_not_run_is_refused(tmp_path):
    with pytest.raises(InputError, match="no costs of jobs; run the study first"):
        Study.of_logs(tmp_path, ANIMALS)
