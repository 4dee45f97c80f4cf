"""Who is at work on a folder of results: one run at a time, wherever it was started.

The operating system releases these locks with the processes that hold them, so that a killed run
leaves none. On a file system without locks nothing is held.
"""

import fcntl
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from softsample.errors import SoftsampleError
from softsample.files import PathLike

LED = "SOFTSAMPLE_RUN"
"""Environment variable with the results whose run `softsample run` leads, for its processes."""

_FOR_LIFE = ExitStack()
"""Locks that this process holds until it ends."""


@contextmanager
def leading_run(results: PathLike) -> Iterator[None]:
    """Hold the results for one run, which processes started meanwhile are part of.

    Raises
    ------
    SoftsampleError
        If another run leads there, or processes of a killed one still work there.
    """
    with _locked(results, "run", fcntl.LOCK_EX), _locked(results, "alive", fcntl.LOCK_EX) as alive:
        if alive is not None:
            fcntl.flock(alive, fcntl.LOCK_SH)
        before = os.environ.get(LED)
        os.environ[LED] = os.path.realpath(results)
        try:
            yield
        finally:
            os.environ.pop(LED)
            os.environ.update({} if before is None else {LED: before})


def lead_run(results: PathLike) -> None:
    """Hold the results until this process ends, unless it is part of their run already.

    Raises
    ------
    SoftsampleError
        As of `leading_run`.
    """
    if not is_led(results):
        _FOR_LIFE.enter_context(leading_run(results))


def show_presence(results: PathLike) -> None:
    """Show until this process ends that it works on the results, beside others of its run."""
    with suppress(SoftsampleError):
        _FOR_LIFE.enter_context(_locked(results, "alive", fcntl.LOCK_SH))


def is_led(results: PathLike) -> bool:
    """Whether this process is part of a run of these results."""
    return os.environ.get(LED) == os.path.realpath(results)


@contextmanager
def _locked(results: PathLike, name: str, kind: int) -> Iterator[int | None]:
    """Lock a hidden file in the results: its descriptor, or None where files cannot be locked."""
    with ExitStack() as stack:
        file = None
        with suppress(OSError):
            Path(results).mkdir(parents=True, exist_ok=True)
            path = Path(results, f".{name}.lock")
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            stack.callback(os.close, file)
            try:
                fcntl.flock(file, kind | fcntl.LOCK_NB)
            except BlockingIOError:
                raise SoftsampleError(
                    f"Another run is working on {results}; wait for it, or stop it, or give this "
                    "one another folder for its results."
                ) from None
        yield file
