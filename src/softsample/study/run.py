"""A study from its table to its report, by Snakemake: one run at a time in a folder."""

import fcntl
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TextIO

from softsample.errors import SoftsampleError
from softsample.io import PathLike, read_yaml
from softsample.study import ROOT, SETTINGS, table_of

STATE = Path(".snakemake")
"""What Snakemake notes of the runs of a folder, below the working folder."""

STOPPED = "The run was stopped; what is finished is kept, the same command goes on from there."

REPORTING = {"all", "reported"}
"""Targets that end with the report."""

BUSY = "Another run is working in this folder; wait for it, or stop it."


def run_study(
    folder: PathLike | None,
    settings: Sequence[PathLike] = (),
    results: PathLike | None = None,
    targets: Sequence[str] = (),
    cores: int = 2,
) -> int:
    """Run a study; if samples fail, report the others.

    Parameters
    ----------
    folder
        Of the study, with its `samples.tsv` and `study.yaml`; None for the samples that come with
        softsample.
    settings
        Files of settings that come before `study.yaml`.
    results
        Where results go; by default `results` in the study's folder, or what the settings say.
    targets
        Rules or files to make, everything by default.
    cores
        Jobs that run side by side.

    Returns
    -------
    int
        Status of the run: 0 if all of it came through.

    Raises
    ------
    InputError
        If the folder has no table.
    SoftsampleError
        If another run works in the present folder.
    """
    files = [str(path) for path in settings]
    entries: dict[str, PathLike] = {}
    if folder is not None:
        own = Path(folder) / SETTINGS
        files += [str(own)] if own.is_file() and read_yaml(own) else []
        entries = {"samples": table_of(Path(folder)), "results": results or Path(folder, "results")}
    elif results is not None:
        entries = {"results": results}
    options = [
        *(["--configfile", *files] if files else []),
        *(["--config", *(f"{key}={value}" for key, value in entries.items())] if entries else []),
    ]
    snakemake = [
        *(sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")),
        *("--cores", str(cores)),
    ]
    with _alone([*snakemake, *options]):
        status = _call([*snakemake, *targets, *options])
        if status < 0 or status >= 128:
            print(STOPPED, file=sys.stderr)
            return status if status > 0 else 128 - status
        if status:
            finished = [*options, *([] if entries else ["--config"]), "report={groups: finished}"]
            reported = _call([*snakemake, "reported", *finished])
            if reported:
                return reported
    of_all = status or not targets or REPORTING.intersection(targets)
    place = _results(files, entries)
    print(f"Report: {place}/report.html" if of_all else f"Results: {place}")
    return status


def _results(files: Sequence[str], entries: dict[str, PathLike]) -> PathLike:
    """Where the results of a run are, the last of its settings first."""
    if "results" in entries:
        return entries["results"]
    paths: list[PathLike] = [ROOT / "config/config.yaml", *files]
    settings = [read_yaml(path) for path in reversed(paths)]
    return next(str(own["results"]) for own in settings if own.get("results"))


@contextmanager
def _alone(snakemake: Sequence[str]) -> Iterator[None]:
    """Hold the working folder for one run, and remove the lock of a killed one.

    The operating system releases these locks with the processes that hold them; every Snakemake
    process, and every job on a cluster, holds the second one.
    """
    STATE.mkdir(exist_ok=True)
    with (STATE / "run.lock").open("w") as own:
        _hold(own)
        locks = STATE / "locks"
        if locks.is_dir() and any(locks.iterdir()):
            with (STATE / "alive.lock").open("w") as alive:
                _hold(alive)
            unlock = [*snakemake, "--unlock", "--quiet", "all"]
            subprocess.call(unlock, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        yield


def _hold(file: TextIO) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise SoftsampleError(BUSY) from None


def _call(command: Sequence[str]) -> int:
    """Status of a command; what stops this process stops it, and is waited for."""
    process = subprocess.Popen(command)
    stopped: list[int] = []

    def pass_on(number: int, _: FrameType | None) -> None:
        stopped.append(number)
        if number == signal.SIGTERM:  # the terminal sends an interrupt to both
            process.send_signal(number)

    before = {number: signal.signal(number, pass_on) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        status = process.wait()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    return -stopped[0] if stopped else status
