"""One run at a time in a folder of results, from wherever it is started."""

import os
import signal
import subprocess
import sys

import pytest

from softsample.errors import SoftsampleError
from softsample.presence import LED, is_led, leading_run
from softsample.study import run

HOLDS = """
import os, sys, time
from softsample.presence import lead_run, leading_run, show_presence
if sys.argv[1] == "leads":
    with leading_run(sys.argv[2]):
        os.system("echo ready")
        time.sleep(60)
{"begins": lead_run, "works": show_presence}[sys.argv[1]](sys.argv[2])
os.system("echo ready")
time.sleep(60)
"""


@pytest.fixture
def at_work(tmp_path):
    """Start a process that works on results, in a working folder of its own."""
    processes = []

    def start(how, results):
        folder = tmp_path / f"cwd{len(processes)}"
        folder.mkdir()
        processes.append(
            subprocess.Popen(
                [sys.executable, "-c", HOLDS, how, os.path.relpath(results, folder)],
                cwd=folder, stdout=subprocess.PIPE, text=True,
            )
        )  # fmt: skip
        assert processes[-1].stdout.readline() == "ready\n"
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.mark.parametrize("how", ["leads", "begins", "works"])
def test_results_that_another_folder_works_on_are_refused_until_it_is_dead(how, at_work, tmp_path):
    results = tmp_path / "lab/results"
    other = at_work(how, results)
    with pytest.raises(SoftsampleError, match=rf"Another run is working on {results}; wait for it"):
        leading_run(results).__enter__()
    other.send_signal(signal.SIGKILL)
    other.wait()
    with leading_run(results):
        pass


def test_two_studies_run_side_by_side_in_one_folder(at_work, tmp_path, monkeypatch):
    at_work("leads", tmp_path / "one/results")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two").mkdir()
    (tmp_path / "two/samples.tsv").touch()
    monkeypatch.setattr(run, "_call", lambda words: 0 if is_led("two/results") else 1)
    assert run.run_study("two") == 0
    (tmp_path / "one/samples.tsv").touch()
    with pytest.raises(SoftsampleError, match="Another run is working on one/results"):
        run.run_study("one")


def test_a_run_that_ended_leaves_nothing_held(tmp_path, monkeypatch):
    monkeypatch.delenv(LED, raising=False)
    for _ in range(2):
        with leading_run(tmp_path), pytest.raises(SoftsampleError, match="Another run"):
            leading_run(tmp_path).__enter__()
        assert not is_led(tmp_path)


def test_processes_of_a_run_work_beside_the_one_that_leads_it(tmp_path, at_work):
    with leading_run(tmp_path):
        at_work("begins", tmp_path)
        at_work("works", tmp_path)
