"""What every rule's script shares: logging to the rule's log and the record of provenance."""

import ctypes
import gc
import hashlib
import json
import logging
import os
import platform
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import metadata
from pathlib import Path
from typing import Any, Protocol

from softsample import __version__
from softsample.errors import SoftsampleError
from softsample.files import ReadFiles, disk_is_full, sha256, write_checksum
from softsample.progress import spoken_duration

PROGRESS = "softsample.progress"
"""Logger whose records are also shown on the terminal, for work of more than a few seconds."""

LEAST_DONE = 0.05
"""Fraction of the work after which its speed is known well enough to tell the time left."""

STARTED = "STARTED"
"""Marks the beginning of a job in its log."""

FAILED = "FAILED: "
"""Marks the reason of a failure in a log."""

PR_SET_PDEATHSIG = 1
"""Of prctl(2): the signal that a process gets when its parent ends."""

PACKAGES = ("numpy", "scipy", "numba", "scikit-image", "snakemake")


FINISHED = "FINISHED: "
"""Marks the end of a job that came through in a log; a log with neither is of a killed job."""

KILLED = (
    "terminated unexpectedly: killed by hand or by the system, often for lack of memory (then give "
    "it more, or run fewer jobs side by side); run the same command again"
)
"""Reason that is given for a job that could not tell its own."""


class Job(Protocol):
    """The part of Snakemake's `snakemake` object that this module needs."""

    input: Any
    output: Any
    log: Any
    params: Any
    rule: str


@contextmanager
def logged_to(job: Job) -> Iterator[None]:
    """Run the body of a rule's script: told in the rule's log, whole or not at all.

    On the terminal appear only progress (logger `softsample.progress`), warnings, and one clear
    message if the job fails; its traceback is in the log and the process ends with status 1.
    Inputs are compared with the checksums they were written with, and must not change meanwhile;
    the results' checksums are written beside them. The process does not outlive Snakemake.

    Parameters
    ----------
    job
        Snakemake's `snakemake` object.
    """
    path = Path(job.log[0])
    try:
        with _logging_to(path), _dying_with_parent(), _of_whole_files(job):
            yield
            gc.freeze()  # the process ends: what it holds need not be searched for cycles first
    except Exception as error:
        print(f"{path.stem}: {_reason(error)}\n  (details: {path})", file=sys.stderr)
        raise SystemExit(1) from error


@contextmanager
def _logging_to(path: Path) -> Iterator[None]:
    """Send log records, and the traceback of a failure, to `path`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    root = logging.getLogger()
    level = root.level
    handlers = [_LogFile(path, mode="w", encoding="utf-8"), _terminal_handler(path.stem)]
    root.setLevel(logging.INFO)
    for handler in handlers:
        root.addHandler(handler)
    log = logging.getLogger(__name__)
    log.info(STARTED)
    try:
        yield
        log.info(f"{FINISHED}{_cost()}")
    except Exception as error:
        log.exception(f"{FAILED}{_reason(error)}")
        raise
    finally:
        for handler in handlers:
            root.removeHandler(handler)
            handler.close()
        root.setLevel(level)


@contextmanager
def _of_whole_files(job: Job) -> Iterator[None]:
    """Check a job's inputs before and after, and write the checksums of its results."""
    inputs = ReadFiles(name for name in job.input if not Path(name).is_dir())
    yield
    inputs.check_unchanged()
    for name in job.output:
        if Path(name).is_file():
            write_checksum(name)


@contextmanager
def _dying_with_parent() -> Iterator[None]:
    """Have the kernel kill this process when Snakemake is killed (Linux).

    Otherwise it would work on unseen, and could write results of old inputs over those of the
    next run.
    """
    set_signal = getattr(ctypes.CDLL(None), "prctl", lambda *_: None)
    set_signal(PR_SET_PDEATHSIG, signal.SIGKILL)
    try:
        yield
    finally:
        set_signal(PR_SET_PDEATHSIG, 0)


def _reason(error: Exception) -> str:
    """What is wrong and, if known, what to do about it."""
    kind = "" if isinstance(error, SoftsampleError) else f"{type(error).__name__}: "
    cure = "; make room there and run the same command again, what is finished is kept"
    return f"{kind}{error}{cure if disk_is_full(error) else ''}"


def _cost() -> str:
    """CPU time and peak memory of this process, to plan a larger study with."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    peak = used.ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    return f"{used.ru_utime + used.ru_stime:.1f} s of CPU, at most {peak:.0f} MB of memory"


def failed_jobs(logs: str | os.PathLike[str]) -> list[tuple[str, str]]:
    """Name and reason of every job whose last run failed, from the logs below a folder.

    To be called when no job is running. A log is overwritten when its job runs again, so what
    was cured is not listed.
    """
    found = []
    for path in sorted(Path(logs).rglob("*.log")):
        text = path.read_text(encoding="utf-8", errors="replace")
        name = str(path.relative_to(logs).with_suffix(""))
        if FAILED in text:
            reason = text.split(FAILED, 1)[1].split("\nTraceback", 1)[0]
            found.append((name, reason.strip()))
        elif STARTED in text and FINISHED not in text:
            found.append((name, KILLED))
    return found


class _LogFile(logging.FileHandler):
    """A log file that stays silent when the disk is full: the job itself tells of that."""

    def __init__(self, path: Path, mode: str, encoding: str) -> None:
        super().__init__(path, mode=mode, encoding=encoding)
        self.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802
        if not disk_is_full(sys.exc_info()[1] or Exception()):
            super().handleError(record)

    def close(self) -> None:
        with suppress(OSError):
            super().close()


def _terminal_handler(label: str) -> logging.Handler:
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter(f"{label}: %(message)s"))
    handler.addFilter(
        lambda record: (
            record.name.startswith(PROGRESS)
            or (record.levelno >= logging.WARNING and record.exc_info is None)
        )
    )
    return handler


def progress_bar(interval_s: float = 15.0) -> Callable[[str, float], None]:
    """Callback ``(what, finished fraction)`` that logs a bar and the time left now and then.

    The time left is told after a twentieth of the work, and counted from the first call: what was
    compiled before it is not done again.
    """
    last = time.monotonic()
    begin: tuple[float, float] | None = None

    def tell(what: str, fraction: float) -> None:
        nonlocal last, begin
        now = time.monotonic()
        if begin is None or fraction < begin[1]:
            begin = now, fraction
        if now - last < interval_s:
            return
        last = now
        done, told = fraction - begin[1], ""
        if done >= LEAST_DONE:
            told = f", {spoken_duration((now - begin[0]) * (1.0 - fraction) / done)} left"
        logging.getLogger(PROGRESS).info("[%-20s] %s%s", "#" * round(20 * fraction), what, told)

    return tell


def provenance(job: Job) -> dict[str, Any]:
    """Where a result comes from: versions, settings, and hashes of inputs and code.

    Parameters
    ----------
    job
        Snakemake's `snakemake` object; inputs that end in `.py` or `.j2` (templates) are counted as
        code. A folder stands for its files, which are inputs as well.

    Returns
    -------
    dict
        `rule`, `versions`, `settings` (the rule's params), `settings_sha256`, `inputs`
        (file: sha256), `code_sha256`. Equal inputs give equal records: no time, no host.
    """
    files = sorted({str(name) for name in job.input if not Path(name).is_dir()})
    code = [name for name in files if name.endswith((".py", ".j2"))]
    settings = json.loads(json.dumps(dict(job.params.items()), sort_keys=True, default=str))
    return {
        "rule": job.rule,
        "versions": versions(),
        "settings": settings,
        "settings_sha256": _sha256_of_text(json.dumps(settings, sort_keys=True)),
        "inputs": {name: sha256(name) for name in files if name not in code},
        "code_sha256": sha256_of_files(code),
    }


def versions() -> Mapping[str, str]:
    """Versions of this package, Python and the packages that numbers depend on."""
    found = {name: metadata.version(name) for name in PACKAGES}
    return {"softsample": __version__, "python": platform.python_version(), **found}


def sha256_of_files(paths: Iterable[str | os.PathLike[str]]) -> str:
    """One SHA-256 of the contents of several files, in the order given."""
    return _sha256_of_text("".join(sha256(path) for path in paths))


def _sha256_of_text(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
