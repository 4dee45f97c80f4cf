"""What a run of the workflow tells while it works: one line a job, with a bar and the time left."""

import logging
import re
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from typing import Any

BAR = 20
"""Characters of the bar."""

CHATTER = (
    "Select jobs to execute",
    "Execute ",
    "Exiting because a job execution failed",
    "RuleException:\nCalledProcessError",
    "WorkflowError:\nAt least one job did not complete",
)
"""Beginnings of what the scheduler says of itself, and of what a failed job has said already."""

OF_SNAKEMAKE = re.compile(r"^(WorkflowError in file .*:|  File \".*\", line \d+, in .*)\n?", re.M)
"""Lines of an error that tell where in the workflow's own files it was raised."""


class JobLines(logging.Formatter):
    """Words one line for each job that starts; the rest is left to Snakemake, or not shown.

    The work that is left is estimated from how long jobs of the same rule took so far, of rules
    not seen yet from the mean of all, and shared by as many jobs as ran side by side. As these may
    take far longer, the bar then says `more than`.

    Parameters
    ----------
    otherwise
        Formatter of all other records.
    dry
        Whether the run only plans; everything is then left to Snakemake.
    """

    def __init__(self, otherwise: logging.Formatter | None, dry: Callable[[], bool]) -> None:
        super().__init__()
        self._dry = dry
        self._otherwise = otherwise or logging.Formatter()
        self._left: Counter[str] = Counter()
        self._total = 0
        self._running: dict[int, tuple[str, float]] = {}
        self._taken: dict[str, list[float]] = defaultdict(list)
        self._start = time.monotonic()

    def shows(self, record: logging.LogRecord) -> bool:
        """Take note of a record; whether it is shown."""
        event = _event(record)
        if event == "RUN_INFO":
            self._plan(getattr(record, "stats", {}))
        elif event == "JOB_FINISHED":
            self._finished(getattr(record, "job_id", -1))
        dropped = event in ("JOB_FINISHED", "JOB_STARTED", "PROGRESS")
        return self._dry() or not (dropped or str(record.msg).startswith(CHATTER))

    def format(self, record: logging.LogRecord) -> str:
        """The line of a job that starts, in Snakemake's own words what is something else."""
        if _event(record) == "JOB_INFO" and not self._dry():
            return self._started(record)
        if _event(record) == "JOB_ERROR" and not self._dry():
            return _failed(record)
        return OF_SNAKEMAKE.sub("", self._otherwise.format(record)).rstrip("\n")

    def _plan(self, stats: dict[str, Any]) -> None:
        self._left = Counter({rule: count for rule, count in stats.items() if rule != "total"})
        self._total = sum(self._left.values())
        self._start = time.monotonic()

    def _started(self, record: Any) -> str:
        self._running[record.jobid] = record.rule_name, time.monotonic()
        done = self._total - sum(self._left.values())
        share = done / max(self._total, 1)
        bar = "#" * round(BAR * share)
        left, known = self._time_left(), self._left.keys() <= self._taken.keys()
        least = "" if known else "more than "
        told = f", {least}{spoken_duration(left)} left" if left is not None else ""
        return f"[{bar:<{BAR}}] {100 * share:3.0f} %{told}: {record.rule_msg or record.rule_name}"

    def _finished(self, job: int) -> None:
        rule, start = self._running.pop(job, ("", time.monotonic()))
        self._taken[rule].append(time.monotonic() - start)
        self._left[rule] -= 1

    def _time_left(self) -> float | None:
        """Estimate [s]; None before the first job is done."""
        spent = [duration for taken in self._taken.values() for duration in taken]
        elapsed = time.monotonic() - self._start
        if not spent or sum(spent) <= 0.0 or elapsed <= 0.0:
            return None
        overall = sum(spent) / len(spent)
        mean = {rule: sum(taken) / len(taken) for rule, taken in self._taken.items()}
        work = sum(count * mean.get(rule, overall) for rule, count in (+self._left).items())
        side_by_side = max(1.0, sum(spent) / elapsed)
        return work / side_by_side


def spoken_duration(seconds: float) -> str:
    """A duration for people: `40 s`, `12 min`, `1 h 20 min`."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    if minutes < 90:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60} min"


def show_jobs_in_lines(dry: Callable[[], bool]) -> None:
    """Have Snakemake's terminal show one line a job, unless the run turns out to be a `dry` one.

    Snakemake knows that only after it has read its rules, hence the callable.
    """
    for handler in logging.getLogger("snakemake.logging").handlers:
        if handler.name == "DefaultStreamHandler":
            lines = JobLines(handler.formatter, dry)
            handler.addFilter(lines.shows)
            handler.setFormatter(lines)


def _failed(record: Any) -> str:
    """One line for a job that failed: its own message stands above, or in its log."""
    logs = ", ".join(map(str, getattr(record, "log", None) or []))
    return f"Failed: {getattr(record, 'rule_name', 'a job')}" + (f" (log: {logs})" if logs else "")


def _event(record: logging.LogRecord) -> str | None:
    """Name of the event that Snakemake gave a record."""
    return getattr(getattr(record, "event", None), "name", None)
