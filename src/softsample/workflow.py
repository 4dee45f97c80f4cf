"""What every rule's script shares: logging to the rule's log and the record of provenance."""

import hashlib
import json
import logging
import os
import platform
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import Any, Protocol

from softsample import __version__
from softsample.errors import SoftsampleError

PROGRESS = "softsample.progress"
"""Logger whose records are also shown on the terminal, for work of more than a few seconds."""

FAILED = "FAILED: "
"""Marks the reason of a failure in a log."""

PACKAGES = ("numpy", "scipy", "numba", "scikit-image", "snakemake")


class Job(Protocol):
    """The part of Snakemake's `snakemake` object that provenance needs."""

    input: Any
    params: Any
    rule: str


@contextmanager
def logged_to(log: str | os.PathLike[str]) -> Iterator[None]:
    """Send log records, and the traceback of a failure, to `log`.

    On the terminal appear only progress (logger `softsample.progress`), warnings, and one clear
    message if the job fails; the process then ends with status 1.

    Parameters
    ----------
    log
        The rule's log file; its folder is made.
    """
    path = Path(log)
    path.parent.mkdir(parents=True, exist_ok=True)
    root = logging.getLogger()
    level = root.level
    handlers = [_log_handler(path), _terminal_handler(path.stem)]
    root.setLevel(logging.INFO)
    for handler in handlers:
        root.addHandler(handler)
    try:
        yield
    except Exception as error:
        kind = "" if isinstance(error, SoftsampleError) else f"{type(error).__name__}: "
        logging.getLogger(__name__).exception(f"{FAILED}{kind}{error}")
        print(f"{path.stem}: {kind}{error}\n  (details: {path})", file=sys.stderr)
        raise SystemExit(1) from error
    finally:
        for handler in handlers:
            root.removeHandler(handler)
            handler.close()
        root.setLevel(level)


def failed_jobs(logs: str | os.PathLike[str]) -> list[tuple[str, str]]:
    """Name and reason of every job whose last run failed, from the logs below a folder.

    A log is overwritten when its job runs again, so what was cured is not listed.
    """
    found = []
    for path in sorted(Path(logs).rglob("*.log")):
        text = path.read_text(encoding="utf-8", errors="replace")
        if FAILED in text:
            reason = text.split(FAILED, 1)[1].split("\nTraceback", 1)[0]
            found.append((str(path.relative_to(logs).with_suffix("")), reason.strip()))
    return found


def _log_handler(path: Path) -> logging.Handler:
    handler = logging.FileHandler(path, mode="w", encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    return handler


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
    """Callback ``(what, finished fraction)`` that logs a bar and the time left now and then."""
    start = last = time.monotonic()

    def tell(what: str, fraction: float) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last < interval_s:
            return
        last = now
        left = (now - start) * (1.0 - fraction) / max(fraction, 1e-3)
        bar = "#" * round(20 * fraction)
        logging.getLogger(PROGRESS).info("[%-20s] %s, %.0f s left", bar, what, left)

    return tell


def provenance(job: Job) -> dict[str, Any]:
    """Where a result comes from: versions, settings, and hashes of inputs and code.

    Parameters
    ----------
    job
        Snakemake's `snakemake` object; inputs that end in `.py` are counted as code. A folder
        stands for its files, which are inputs as well.

    Returns
    -------
    dict
        `rule`, `versions`, `settings` (the rule's params), `settings_sha256`, `inputs`
        (file: sha256), `code_sha256`. Equal inputs give equal records: no time, no host.
    """
    files = sorted({str(name) for name in job.input if not Path(name).is_dir()})
    code = [name for name in files if name.endswith(".py")]
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


def sha256(path: str | os.PathLike[str]) -> str:
    """SHA-256 of a file's content, in hexadecimal."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def sha256_of_files(paths: Iterable[str | os.PathLike[str]]) -> str:
    """One SHA-256 of the contents of several files, in the order given."""
    return _sha256_of_text("".join(sha256(path) for path in paths))


def _sha256_of_text(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
