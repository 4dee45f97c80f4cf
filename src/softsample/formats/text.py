"""Text files from anywhere: their encoding is found out, and what is no text is refused."""

import codecs
import re
from pathlib import Path

from softsample.errors import InputError
from softsample.files import PathLike

LARGEST_BYTES = 2**28

NOT_UTF8 = "not UTF-8, so read as Windows-1252; if words look wrong, save the file as UTF-8"

NO_TEXT = re.compile(r"[\x00-\x08\x0b\x0e-\x1f\x7f\ufffd]")


def read_lines(path: PathLike, cure: str) -> tuple[list[str], list[str]]:
    """Read the lines of a text file.

    Parameters
    ----------
    path
        UTF-8, UTF-16 with its mark, or Windows-1252; lines end as on any system.
    cure
        What to do about a file that is no text, for the message.

    Returns
    -------
    lines : list of str
        Without their ends; the first is line 1 of the file.
    notes : list of str
        What had to be done to get them, in words.

    Raises
    ------
    InputError
        If the file is no text, or too large for what it should be.
    FileNotFoundError
        If there is no such file.
    """
    try:
        if Path(path).stat().st_size > LARGEST_BYTES:
            raise InputError(f"{path}: larger than {LARGEST_BYTES >> 20} MiB; {cure}")
        raw = Path(path).read_bytes()
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read ({error}); {cure}") from error
    text, notes = _decoded(raw)
    if NO_TEXT.search(text):
        raise InputError(f"{path}: not a text file, or one that is not UTF-8; {cure}, as UTF-8")
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), notes


def _decoded(raw: bytes) -> tuple[str, list[str]]:
    """Text of a file and what had to be done to get it."""
    if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return raw.decode("utf-16", errors="replace"), []
    zeros = raw.count(b"\0")
    notes = [f"NUL characters left out: {zeros}"] if zeros else []
    raw = raw.replace(b"\0", b"")
    try:
        return raw.decode("utf-8-sig"), notes
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace"), [*notes, NOT_UTF8]
