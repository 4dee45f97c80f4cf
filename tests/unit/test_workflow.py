import errno
import logging
import os
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from softsample.errors import InputError
from softsample.files import checksum_of, sha256
from softsample.workflow import KILLED, PROGRESS, failed_jobs, logged_to, progress_bar, provenance


def job(log, files=(), results=(), **params):
    """What a script knows of its job."""
    return SimpleNamespace(input=files, output=results, log=[log], params=params, rule="mesh")


def test_a_failure_is_one_message_on_the_terminal_and_a_traceback_in_the_log(tmp_path, capsys):
    log = tmp_path / "logs" / "mesh" / "C1.log"
    with pytest.raises(SystemExit) as stopped, logged_to(job(log)):
        raise InputError("C1.csv, line 3: wrong; delete the line")
    assert stopped.value.code == 1
    shown = capsys.readouterr().err
    assert shown.startswith("C1: C1.csv, line 3: wrong; delete the line\n")
    assert "Traceback" not in shown
    assert "Traceback" in log.read_text()
    assert failed_jobs(tmp_path / "logs") == [("mesh/C1", "C1.csv, line 3: wrong; delete the line")]


def test_an_unforeseen_error_is_named_with_its_type(tmp_path, capsys):
    with pytest.raises(SystemExit), logged_to(job(tmp_path / "a.log")):
        raise KeyError("length_mm")
    assert "a: KeyError: 'length_mm'" in capsys.readouterr().err


def test_a_job_that_runs_again_is_no_longer_listed_as_failed(tmp_path):
    with pytest.raises(SystemExit), logged_to(job(tmp_path / "a.log")):
        raise InputError("wrong")
    with logged_to(job(tmp_path / "a.log")):
        logging.getLogger("softsample.x").info("fine now")
    assert failed_jobs(tmp_path) == []
    assert "fine now" in (tmp_path / "a.log").read_text()


def test_a_finished_job_tells_what_it_cost(tmp_path):
    with logged_to(job(tmp_path / "a.log")):
        pass
    last = (tmp_path / "a.log").read_text().splitlines()[-1]
    assert "FINISHED: " in last
    assert float(last.split("at most ")[1].split(" MB")[0]) > 10.0


ORPHAN = """
import sys, time
from types import SimpleNamespace
from softsample.workflow import logged_to
log = sys.argv[1]
with logged_to(SimpleNamespace(input=[], output=[], log=[log], params={}, rule="mesh")):
    print("at work", flush=True)
    time.sleep(60.0)
"""
PARENT = "import subprocess, sys; subprocess.run([sys.executable, *sys.argv[1:]])"


def test_a_job_dies_with_its_parent_and_is_listed_as_killed(tmp_path):
    command = [sys.executable, "-c", PARENT, "-c", ORPHAN, str(tmp_path / "a.log")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as parent:
        assert parent.stdout.readline() == b"at work\n"
        began = time.monotonic()
        parent.kill()
        assert parent.stdout.read() == b""  # the pipe closes when the job has gone, too
        assert time.monotonic() - began < 30.0
    assert failed_jobs(tmp_path) == [("a", KILLED)]


def test_results_of_an_input_that_changed_meanwhile_are_refused(tmp_path, capsys):
    data = tmp_path / "a.csv"
    data.write_text("1\n")
    with logged_to(job(tmp_path / "a.log", [str(data)])):
        os.utime(data, (0, 0))  # only touched
    with pytest.raises(SystemExit), logged_to(job(tmp_path / "a.log", [str(data)])):
        data.write_text("2\n")
    assert "a.csv: changed while this job was using it" in capsys.readouterr().err
    with pytest.raises(SystemExit), logged_to(job(tmp_path / "a.log", [str(data)])):
        data.unlink()
    assert "run the same command again" in capsys.readouterr().err


def test_a_damaged_result_is_refused_and_deleting_it_is_the_cure(tmp_path, capsys):
    curve = tmp_path / "curve.csv"
    rows = [f"{x},{x}" for x in range(100)]
    with logged_to(job(tmp_path / "a.log", results=[str(curve)])):
        curve.write_text("\n".join(["x,y", *rows, ""]))
    checked = subprocess.run(
        ["sha256sum", "-c", checksum_of(curve).name], cwd=tmp_path, capture_output=True, check=True
    )
    assert checked.stdout == b"curve.csv: OK\n"
    curve.write_text("\n".join(["x,y", *rows[:50], ""]))  # a sound table, but half of it
    with pytest.raises(SystemExit), logged_to(job(tmp_path / "b.log", [str(curve)])):
        pytest.fail("the job began")
    assert "curve.csv: not as it was written" in capsys.readouterr().err
    assert "delete it and run the same command again" in (tmp_path / "b.log").read_text()


def test_a_full_disk_is_told_with_its_cure(tmp_path, capsys):
    with pytest.raises(SystemExit), logged_to(job(tmp_path / "a.log")):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "mesh.vtu")
    shown = capsys.readouterr().err
    assert "No space left on device: 'mesh.vtu'; make room there and run the same command" in shown


def test_only_progress_and_warnings_reach_the_terminal(tmp_path, capsys):
    with logged_to(job(tmp_path / "C1_real.log")):
        logging.getLogger("softsample.mesh").info("detail")
        logging.getLogger(PROGRESS).info("half way")
        logging.getLogger("softsample.mesh").warning("thin wall")
    assert capsys.readouterr().err == "C1_real: half way\nC1_real: thin wall\n"


def test_provenance_names_inputs_settings_and_code(tmp_path):
    data, code = tmp_path / "a.csv", tmp_path / "a.py"
    words = tmp_path / "a.md.j2"
    data.write_text("1\n")
    code.write_text("x = 1\n")
    words.write_text("one\n")
    first = provenance(job(None, [str(data), str(code)], size=0.5))
    worded = provenance(job(None, [str(data), str(code), str(words)], size=0.5))
    assert worded["inputs"] == first["inputs"]
    assert worded["code_sha256"] != first["code_sha256"]
    assert first["inputs"] == {str(data): sha256(data)}
    assert first["settings"] == {"size": 0.5}
    assert {"softsample", "python", "numpy", "numba"} <= set(first["versions"])
    assert provenance(job(None, [str(code), str(data)], size=0.5)) == first
    code.write_text("x = 2\n")
    changed = provenance(job(None, [str(data), str(code)], size=0.6))
    assert changed["code_sha256"] != first["code_sha256"]
    assert changed["settings_sha256"] != first["settings_sha256"]


def test_time_left_is_told_once_the_speed_is_known(monkeypatch, caplog):
    """An hour of compiling before the first call is not work that is still to come."""
    clock = iter([0.0, 3600.0, 3610.0, 3700.0])
    monkeypatch.setattr("softsample.workflow.time.monotonic", lambda: next(clock))
    tell = progress_bar(interval_s=5.0)
    with caplog.at_level("INFO", logger=PROGRESS):
        for fraction in (0.0, 0.01, 0.5):
            tell("runs", fraction)
    told = [record.getMessage() for record in caplog.records]
    assert ["left" in line for line in told] == [False, False, True]
    assert told[-1].endswith("runs, 2 min left")
