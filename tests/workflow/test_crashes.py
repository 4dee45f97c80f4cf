"""Killed, full, damaged, changed: nothing half-made is used and nothing finished is lost."""

import base64
import os
import random
import re
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import pytest

from conftest import contents, wait_for
from softsample.workflow import KILLED

pytestmark = pytest.mark.study

NOTHING = "Nothing to be done"


def checked(project, sample="A"):
    return project.results / f"inputs/{sample}.json"


def made(path):
    """What tells a file from one that was made anew."""
    return path.stat().st_mtime_ns, path.stat().st_ino


def noted_as_finished(project, sample):
    """Whether Snakemake holds what a check made for complete: notes first, then off the marks."""

    def noted(result):
        name = base64.urlsafe_b64encode(str(project.results / result).encode()).decode()
        notes = project.folder / ".snakemake"
        return (notes / "metadata" / name).exists() and not (notes / "incomplete" / name).exists()

    return noted(f"inputs/{sample}.json") and noted(f"records/{sample}.csv")


def test_a_killed_job_stops_itself_alone_and_is_named(project):
    held = project.hold("check_record", "A")
    targets = [str(checked(project, sample)) for sample in "AB"]
    run = project.start(*targets)
    os.kill(held.pid(), signal.SIGKILL)
    assert run.wait() == 1
    text = project.printed.read_text()
    assert f"check_record/A: {KILLED}" in text
    assert not checked(project, "A").exists()
    finished = made(checked(project, "B"))
    held.release()
    status, text = project.run(*targets)
    assert status == 0, text
    assert made(checked(project, "B")) == finished


def test_after_a_kill_of_snakemake_its_jobs_end_and_the_study_goes_on(project):
    held = project.hold("check_record", "A")
    targets = [str(checked(project, sample)) for sample in "AB"]
    run = project.start(*targets)
    job = held.pid()
    wait_for(lambda: noted_as_finished(project, "B"))
    run.kill()
    run.wait()
    wait_for(lambda: not Path(f"/proc/{job}").exists())
    assert not checked(project, "A").exists()

    finished = made(checked(project, "B"))
    held.release()
    status, text = project.run(*targets)
    assert status != 0
    assert "--unlock" in text  # Snakemake cannot know that the other is dead; `softsample run` can
    status, text = project.run_study(*targets)
    assert status == 0, text
    assert checked(project, "A").exists()
    assert made(checked(project, "B")) == finished


def test_two_runs_in_one_folder_do_not_meet(project):
    held = project.hold("check_record", "A")
    target = str(checked(project, "A"))
    run = project.start(target)
    held.pid()
    status, text = project.run(target)
    assert status != 0
    assert "Directory cannot be locked" in text
    status, text = project.run_study(target)
    assert status != 0
    assert f"Another run is working on {project.results}; wait for it, or stop it" in text
    status, text = project.run("--nolock", target)  # as from another folder
    assert status != 0
    assert f"Another run is working on {project.results}; wait for it, or stop it" in text
    held.release()
    assert run.wait() == 0, project.printed.read_text()
    assert NOTHING in project.run("-n", target)[1]


def test_an_input_that_changes_meanwhile_gives_no_result(project):
    """Snakemake alone would take the result for current: it is newer than the input."""
    held = project.hold("check_record", "A")
    target = checked(project, "A")
    run = project.start(str(target))
    held.pid()
    record = project.study / "A.csv"
    record.write_text("\n".join(record.read_text().splitlines()[:-1]) + "\n")
    held.release()
    assert run.wait() == 1
    text = project.printed.read_text()
    assert re.search(r"check_record/A: .*A\.csv: changed while this job was using it", text)
    assert not target.exists()
    assert project.run(str(target))[0] == 0
    assert NOTHING in project.run("-n", str(target))[1]


def test_a_damaged_intermediate_is_refused_until_it_is_deleted(project):
    """The damage is one that no reader of the file can see: another digit."""
    cuboid, damaged = (project.results / name for name in ("cuboid/A.json", "segmentation/A.json"))
    assert project.run(str(cuboid))[0] == 0
    text = damaged.read_text()
    damaged.write_text(re.sub(r'("grid_spacing_mm": 0\.)\d', r"\g<1>9", text))
    assert damaged.read_text() != text
    status, text = project.run(str(cuboid))
    assert status == 1
    assert re.search(r"measure/A: .*segmentation/A\.json: not as it was written", text)
    assert "delete it and run the same command again" in text
    damaged.unlink()
    status, text = project.run(str(cuboid))
    assert status == 0, text
    assert NOTHING in project.run("-n", str(cuboid))[1]


@pytest.fixture
def small_disk(project):
    """Gives the project's results a disk of their own of some kilobytes; resizes it when called."""

    def resize(options):
        where = str(project.results)
        command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", where]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    project.results.mkdir()
    mounted = resize("size=64k")
    if mounted.returncode != 0:
        pytest.skip(f"a small disk cannot be mounted here: {mounted.stderr.strip()}")
    yield resize
    subprocess.run(["umount", str(project.results)], check=True)


def test_a_full_disk_stops_what_does_not_fit(project, small_disk):
    names = ("inputs/A.json", "inputs/B.json", "mesh/A/ideal.vtu", "cuboid/B.json")
    targets = [str(project.results / name) for name in names]
    status, text = project.run(*targets)
    assert status == 1
    assert "No space left on device" in text
    assert "make room there and run the same command again, what is finished is kept" in text
    there = [path for path in map(Path, targets) if path.exists()]
    assert there
    assert len(there) < len(targets)
    finished = [made(path) for path in there]
    assert not list(project.results.rglob(".partial-*"))

    assert small_disk("remount,size=64m").returncode == 0
    status, text = project.run(*targets)
    assert status == 0, text
    assert [made(path) for path in there] == finished


@pytest.mark.long
@pytest.mark.parametrize(
    ("kills", "names"),
    [
        (5, ("inputs/A.json", "cuboid/B.json", "mesh/A/ideal.vtu")),
        (50, ("checks/passed.json", "tables/table1.csv")),
    ],
)
def test_random_kills_change_no_result(project, kills, names):
    """Snakemake, one of its jobs, or all at once; the results are those of an undisturbed run."""
    targets = [str(project.results / name) for name in names]
    start = seconds_of(lambda: project.run("-n", *targets))
    project.run(*targets)
    expected = contents(project.results)
    project.results.rename(project.folder / "undisturbed")

    chance, hits = random.Random(kills), 0
    for _ in range(kills):
        if all(map(os.path.exists, targets)):
            project.results.rename(project.folder / f"complete {time.monotonic_ns()}")
        project.run("--unlock", *targets)
        run = project.start(*targets)
        while not children(run.pid) and run.poll() is None:
            time.sleep(0.02)
        time.sleep(chance.uniform(0.0, 0.3 * start))
        victim, jobs = chance.choice(["Snakemake", "one job", "all"]), children(run.pid)
        hits += run.poll() is None
        if victim != "one job":
            run.kill()
        for job in {"Snakemake": [], "one job": jobs[:1], "all": jobs}[victim]:
            kill(job)
        if victim == "one job" and chance.random() < 0.5:
            run.terminate()
        run.wait()
    project.run("--unlock", *targets)
    status, text = project.run(*targets)
    assert status == 0, text
    assert contents(project.results) == expected
    assert hits > kills / 2


def seconds_of(work):
    """Time that some work takes."""
    began = time.monotonic()
    work()
    return time.monotonic() - began


def kill(pid):
    """SIGKILL a process, if it has not ended by itself."""
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def children(pid):
    """Processes that a process has started and that are alive."""
    found = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):  # a thread that has ended meanwhile
            found += map(int, path.read_text().split())
    return found
