"""A study from its table to its report, by Snakemake: one run at a time in its results."""

import json
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import FrameType

from softsample.io import PathLike, read_yaml
from softsample.presence import leading_run
from softsample.study import ROOT, SETTINGS, table_of

STOPPED = "The run was stopped; what is finished is kept, the same command goes on from there."

REPORTING = {"all", "reported"}
"""Targets that end with the report."""


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
        Rules or files to make, everything by default; a path that begins with `results/` is one in
        the results of the study.
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
        If another run works on these results.
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
        *(["--config", *(_entry(key, value) for key, value in entries.items())] if entries else []),
    ]
    snakemake = [
        *(sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")),
        *("--cores", str(cores), "--nolock"),  # which holds the working folder, not the results
    ]
    place = _results(files, entries)
    targets = [_in_results(target, place) for target in targets]
    of_all = not targets or bool(REPORTING.intersection(targets))
    with leading_run(place):
        status = _call([*snakemake, *targets, *options])
        if status < 0 or status >= 128:
            print(STOPPED, file=sys.stderr)
            return status if status > 0 else 128 - status
        if status:
            settled = _for_the_others(snakemake, targets, options)
            if settled:
                return settled if of_all else status
    print(f"Report: {place}/report.html" if of_all else f"Results: {place}")
    return status


def _entry(key: str, path: PathLike) -> str:
    """Of `--config`. Snakemake takes quotes off its ends and reads YAML, where # is a comment."""
    return f"{key}= {json.dumps(str(path), ensure_ascii=False)} "


def _for_the_others(snakemake: Sequence[str], targets: Sequence[str], options: list[str]) -> int:
    """After a run in which samples failed, make the report, or other targets, of the others.

    Returns the status; other targets are left if the groups without the failed ones have no such.
    """
    of_all = not targets or bool(REPORTING.intersection(targets))
    groups = "finished" if of_all else "not_failed"
    own = [*options, *([] if "--config" in options else ["--config"])]
    asked = ["reported"] if of_all else targets
    command = [*snakemake, *asked, *own, f"report={{groups: {groups}}}"]
    if not of_all:
        looking = [*command, "--dry-run", "--quiet", "all"]
        silent = subprocess.DEVNULL
        status = subprocess.call(looking, stdout=silent, stderr=silent)
        if status:
            return status
    return _call(command)


def _results(files: Sequence[str], entries: dict[str, PathLike]) -> PathLike:
    """Where the results of a run are, the last of its settings first."""
    if "results" in entries:
        return entries["results"]
    paths: list[PathLike] = [ROOT / "config/config.yaml", *files]
    settings = [own for path in reversed(paths) if isinstance(own := read_yaml(path), dict)]
    return next(str(own["results"]) for own in settings if own.get("results"))


def _in_results(target: str, place: PathLike) -> str:
    """A target, a path in `results/` as one in the results of this study."""
    first, *inside = Path(target).parts or ("",)
    return str(Path(place, *inside)) if first == "results" and inside else target


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
