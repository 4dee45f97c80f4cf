"""Files that are whole: written aside and renamed, checked against their checksum when read."""

import errno
import glob
import hashlib
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from softsample.errors import InputError

PathLike = str | os.PathLike[str]


@contextmanager
def written_aside(path: PathLike) -> Iterator[Path]:
    """Give a temporary name beside `path` and rename it to `path` when the block succeeds.

    A process killed inside the block leaves the old file, or none, never half of a new one; what
    it leaves under the temporary name goes when the file is next written. Of two processes that
    write the same file, the one that began later wins and the other fails. The temporary name
    starts with a dot and keeps the suffix, which some writers look at.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    for left in target.parent.glob(f".partial-*-{glob.escape(target.name)}"):
        left.unlink(missing_ok=True)
    aside = target.with_name(f".partial-{os.getpid()}-{target.name}")
    try:
        yield aside
        _flush_to_disk(aside)
        os.replace(aside, target)
    finally:
        aside.unlink(missing_ok=True)


def copy(source: PathLike, target: PathLike) -> None:
    """Copy a file, whole or not at all."""
    with written_aside(target) as aside:
        shutil.copyfile(source, aside)


def _flush_to_disk(path: Path) -> None:
    """Wait until the disk has the content, so that a full or lost disk shows before the rename."""
    with open(path, "rb") as stream:
        os.fsync(stream.fileno())


def sha256(path: PathLike) -> str:
    """SHA-256 of a file's content, in hexadecimal."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def checksum_of(path: PathLike) -> Path:
    """The hidden file beside `path` that holds its checksum, in the format of `sha256sum`."""
    return Path(path).with_name(f".{Path(path).name}.sha256")


def write_checksum(path: PathLike) -> None:
    """Write the checksum of a finished result beside it; `sha256sum -c` reads it too."""
    with written_aside(checksum_of(path)) as aside:
        aside.write_text(f"{sha256(path)}  {Path(path).name}\n", encoding="utf-8")


class ReadFiles:
    """Files as they were when a job began to read them.

    Parameters
    ----------
    paths
        Files; each is compared with its checksum (`write_checksum`) if it has one.

    Raises
    ------
    InputError
        Naming every file that is not the one that was written.
    """

    def __init__(self, paths: Iterable[PathLike]) -> None:
        self._state = {Path(path): _state(path) for path in paths}
        self._sums = {path: sha256(path) for path in self._state}
        damaged = [path for path, digest in self._sums.items() if _differs(path, digest)]
        if damaged:
            raise InputError(
                f"{', '.join(map(str, damaged))}: not as it was written, but damaged or edited "
                "since; delete it and run the same command again, and it is recomputed"
            )

    def check_unchanged(self) -> None:
        """Refuse results of files that changed while the job read them (`InputError`)."""
        changed = [
            str(path)
            for path, state in self._state.items()
            if _state(path) != state and (not path.is_file() or sha256(path) != self._sums[path])
        ]
        if changed:
            raise InputError(
                f"{', '.join(changed)}: changed while this job was using it, so the job's results "
                "are not kept; run the same command again"
            )


def _state(path: PathLike) -> tuple[int, int, int] | None:
    """What tells cheaply that a file may have changed; None if there is none."""
    try:
        status = os.stat(path)
    except FileNotFoundError:
        return None
    return status.st_ino, status.st_mtime_ns, status.st_size


def _differs(path: Path, digest: str) -> bool:
    """Whether a file has a checksum that is another than this."""
    try:
        written = checksum_of(path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return written.split(" ", 1)[0] != digest


def refuse_missing(files: Mapping[str, PathLike]) -> None:
    """Refuse files that a row of the table names and that are not there (`InputError`).

    Parameters
    ----------
    files : mapping
        Their paths by column.
    """
    cure = "correct its path in the table"
    if missing := [f"{path}: no such {column}; {cure}" for column, path in files.items()]:
        raise InputError("\n".join(missing))


def disk_is_full(error: BaseException) -> bool:
    """Whether an error is that of a full disk, or of a quota that is used up."""
    return isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT)
