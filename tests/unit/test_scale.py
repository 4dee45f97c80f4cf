import json

import pytest

import scale_page
from scale import CORES, Planning, Study, hours
from softsample.errors import InputError
from softsample.workflow import FINISHED

GROUPS = {"T1": "TC1", "C1": "TC1", "S1": "S1"}
PLANNING = Planning(jobs=1000, fixed_s=2.0, per_job_s=0.004, start_s=2.5, start_s_per_sample=0.001)


def log(path, cpu_s, mb):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"... {FINISHED}{cpu_s} s of CPU, at most {mb} MB of memory\n")


@pytest.fixture
def study(tmp_path):
    logs = tmp_path / "logs"
    log(logs / "mesh/T1_real.log", 12.0, 300)
    log(logs / "mesh/C1_real.log", 20.0, 400)
    log(logs / "segment/S1.log", 4.0, 600)
    log(logs / "figure2.log", 3.0, 200)
    log(logs / "table1.log", 0.5, 100)
    (logs / "mesh/S1_real.log").write_text("failed")
    samples = {name: {"group": group} for name, group in GROUPS.items()}
    (tmp_path / "results.json").write_text(json.dumps({"samples": samples}))
    (tmp_path / "mesh/T1").mkdir(parents=True)
    settings = {"mesh": {"element_size_mm": 0.5}}
    report = json.dumps({"provenance": {"settings": settings}})
    (tmp_path / "mesh/T1/real.json").write_text(report)
    return Study.of_results(tmp_path)


def test_costs_of_samples_and_of_tables_are_told_apart(study):
    assert study.cpu_s_per_sample == pytest.approx(36.0 / 3.0)
    assert (study.cpu_s_of_tables, study.start_s_of_tables) == (3.5, 2 * 0.5)
    assert (study.samples, study.element_size_mm) == (3, 0.5)
    assert (study.jobs_per_sample, study.samples_per_animal) == (1.0, 1.5)
    assert list(study.largest_mb.items()) == [
        ("segment", 600),
        ("mesh", 400),
        ("figure2", 200),
        ("table1", 100),
    ]


def test_one_machine_shares_the_work_and_a_cluster_also_starts_each_job(study):
    two, many, most = (hours(study, PLANNING, cores) for cores in CORES)
    assert two["samples_h"] == pytest.approx(1000 * 12.0 / 2 / 3600.0)
    assert two["last_animal_h"] == 0.0
    assert many["samples_h"] == pytest.approx(1000 * (12.0 + 3.5) / 64 / 3600.0)
    assert many["last_animal_h"] == pytest.approx(1.5 * (12.0 + 3.5) / 4 / 3600.0)
    assert most["planning_h"] == two["planning_h"] == pytest.approx((2.0 + 4.0) / 3600.0)
    assert most["tables_h"] == pytest.approx((1.0 + 2.5 * 1000 / 3) / 3600.0)
    for found in (two, many, most):
        parts = [value for name, value in found.items() if name not in ("cores", "total_h")]
        assert found["total_h"] == pytest.approx(sum(parts))


def test_a_study_that_has_not_run_is_refused(tmp_path):
    with pytest.raises(InputError, match="no costs of jobs; run the study first"):
        Study.of_results(tmp_path)


def test_the_page_shows_what_was_measured():
    written = scale_page.PAGE.read_text(encoding="utf-8")
    assert written == scale_page.page(), "stale: run python benchmarks/scale_page.py"


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("SCALE", ("estimates", 2, "total_h")),
        ("SCALE", ("study", "cpu_s_per_sample")),
        ("SCALE", ("study", "largest_mb", "segment")),
        ("SCALE", ("planning", "fixed_s")),
        ("SLURM", ("equal",)),
        ("SLURM", ("cpu_s_of_slurm_jobs",)),
    ],
    ids=str,
)
def test_the_page_reads_its_numbers_from_the_measurements(name, place, tmp_path, monkeypatch):
    before = scale_page.page()
    part = found = json.loads(getattr(scale_page, name).read_text(encoding="utf-8"))
    for step in place[:-1]:
        part = part[step]
    part[place[-1]] *= 7
    other = tmp_path / "other.json"
    other.write_text(json.dumps(found))
    monkeypatch.setattr(scale_page, name, other)
    assert scale_page.page() != before
