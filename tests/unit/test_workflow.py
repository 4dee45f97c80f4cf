import logging
from types import SimpleNamespace

import pytest

from softsample.errors import InputError
from softsample.workflow import PROGRESS, failed_jobs, logged_to, provenance, sha256


def test_a_failure_is_one_message_on_the_terminal_and_a_traceback_in_the_log(tmp_path, capsys):
    log = tmp_path / "logs" / "mesh" / "C1.log"
    with pytest.raises(SystemExit) as stopped, logged_to(log):
        raise InputError("C1.csv, line 3: wrong; delete the line")
    assert stopped.value.code == 1
    shown = capsys.readouterr().err
    assert shown.startswith("C1: C1.csv, line 3: wrong; delete the line\n")
    assert "Traceback" not in shown
    assert "Traceback" in log.read_text()
    assert failed_jobs(tmp_path / "logs") == [("mesh/C1", "C1.csv, line 3: wrong; delete the line")]


def test_an_unforeseen_error_is_named_with_its_type(tmp_path, capsys):
    with pytest.raises(SystemExit), logged_to(tmp_path / "a.log"):
        raise KeyError("length_mm")
    assert "a: KeyError: 'length_mm'" in capsys.readouterr().err


def test_a_job_that_runs_again_is_no_longer_listed_as_failed(tmp_path):
    with pytest.raises(SystemExit), logged_to(tmp_path / "a.log"):
        raise InputError("wrong")
    with logged_to(tmp_path / "a.log"):
        logging.getLogger("softsample.x").info("fine now")
    assert failed_jobs(tmp_path) == []
    assert "fine now" in (tmp_path / "a.log").read_text()


def test_only_progress_and_warnings_reach_the_terminal(tmp_path, capsys):
    with logged_to(tmp_path / "C1_real.log"):
        logging.getLogger("softsample.mesh").info("detail")
        logging.getLogger(PROGRESS).info("half way")
        logging.getLogger("softsample.mesh").warning("thin wall")
    assert capsys.readouterr().err == "C1_real: half way\nC1_real: thin wall\n"


def job(files, **params):
    return SimpleNamespace(input=files, params=params, rule="mesh")


def test_provenance_names_inputs_settings_and_code(tmp_path):
    data, code = tmp_path / "a.csv", tmp_path / "a.py"
    data.write_text("1\n")
    code.write_text("x = 1\n")
    first = provenance(job([str(data), str(code)], size=0.5))
    assert first["inputs"] == {str(data): sha256(data)}
    assert first["settings"] == {"size": 0.5}
    assert {"softsample", "python", "numpy", "numba"} <= set(first["versions"])
    assert provenance(job([str(code), str(data)], size=0.5)) == first
    code.write_text("x = 2\n")
    changed = provenance(job([str(data), str(code)], size=0.6))
    assert changed["code_sha256"] != first["code_sha256"]
    assert changed["settings_sha256"] != first["settings_sha256"]
