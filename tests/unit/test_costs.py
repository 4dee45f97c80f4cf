import pytest

from softsample.costs import (
    cost_table,
    diagnosis_runtime_min,
    job_costs,
    mesh_memory_mb,
    mesh_runtime_min,
    pool_memory_mb,
    pool_runtime_min,
)
from softsample.errors import InputError
from softsample.workflow import FINISHED


def log(path, cpu_s, mb):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"... {FINISHED}{cpu_s} s of CPU, at most {mb} MB of memory\n")


def test_costs_are_summed_by_kind_and_failed_jobs_left_out(tmp_path):
    log(tmp_path / "mesh/T1_real.log", 12.0, 300)
    log(tmp_path / "mesh/C1_real.log", 20.0, 400)
    log(tmp_path / "figure2.log", 8.0, 200)
    (tmp_path / "mesh/S1_real.log").write_text("failed")
    assert job_costs(tmp_path)["own"].tolist() == [False, True, True]
    rows = cost_table(tmp_path).set_index("kind")
    assert rows.index.tolist() == ["mesh", "figure2", "all"]
    assert rows.loc["mesh"].tolist() == [2, 32.0, 20.0, 80.0, 400]
    assert rows.loc["all"].tolist() == [3, 40.0, 20.0, 100.0, 400]


def test_a_study_that_has_not_run_is_refused(tmp_path):
    with pytest.raises(InputError, match="no costs of jobs; run the study first"):
        job_costs(tmp_path)


@pytest.mark.parametrize(
    ("size", "memory", "minutes"), [(1.0, 800, 5), (0.5, 800, 5), (0.25, 400 + 3200, 80)]
)
def test_smaller_elements_and_a_second_attempt_ask_for_more(size, memory, minutes):
    for attempt in (1, 2):
        assert mesh_memory_mb(size, attempt) == attempt * memory
        assert mesh_runtime_min(size, attempt) == attempt * minutes


def test_verdicts_ask_for_more_than_the_default_and_more_by_tests_folds_and_groups():
    assert diagnosis_runtime_min(3, 0, 1) == 10
    assert diagnosis_runtime_min(12, 9, 2) == 2 * diagnosis_runtime_min(12, 9, 1) > 400
    assert pool_runtime_min(6, 1) > 3 * 13  # measured, beside other work
    assert pool_runtime_min(6, 2) == 2 * pool_runtime_min(6, 1)
    assert 530 < pool_memory_mb(6, 1) == 0.5 * pool_memory_mb(6, 2)
