"""Reading others' files: tables of numbers with a known header, and cells of a workbook."""

import re
import zipfile
from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsample.errors import InputError

Array = NDArray[np.float64]

SPREADSHEET = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"


def lines_of(path: Path) -> list[str]:
    """Lines of a text file.

    Raises
    ------
    InputError
        If there is no such file, or it is no text.
    """
    try:
        return path.read_text(encoding="utf-8-sig").splitlines()
    except (FileNotFoundError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not there or not text ({error}); fetch it again") from error


def numbers(
    path: Path, lines: Sequence[str], columns: Sequence[str], separator: str = ","
) -> pd.DataFrame:
    """Table of finite numbers below a header that must hold the named columns, units included.

    Raises
    ------
    InputError
        If a column is absent (another unit, another export) or a cell is no finite number.
    """
    try:
        table = pd.read_csv(StringIO("\n".join(lines)), sep=separator, skipinitialspace=True)
    except (pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise InputError(f"{path}: not a table with a header: {error}") from error
    table.columns = table.columns.str.strip()
    absent = [name for name in columns if name not in table]
    if absent:
        raise InputError(
            f"{path}: no column {absent[0]!r} but {', '.join(map(repr, table.columns))}; "
            "another unit or another export than this reader is made for"
        )
    found = table[list(columns)].apply(pd.to_numeric, errors="coerce")
    if len(found) == 0 or not np.isfinite(found.to_numpy(float)).all():
        raise InputError(f"{path}: empty, or a cell is no finite number; fetch the file again")
    return found.astype(float)


def workbook_rows(path: Path) -> list[dict[str, str]]:
    """Cells of a workbook's first sheet (.xlsx), by letter of the column, row by row as text.

    Raises
    ------
    InputError
        If the file is no such workbook.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
            shared = "xl/sharedStrings.xml"
            texts = _items(archive.read(shared)) if shared in names else []
            sheet = ElementTree.fromstring(archive.read("xl/worksheets/sheet1.xml"))
    except (OSError, KeyError, zipfile.BadZipFile, ElementTree.ParseError) as error:
        raise InputError(f"{path}: not a readable workbook ({error}); fetch it again") from error
    rows = []
    for row in sheet.iter(f"{SPREADSHEET}row"):
        cells = {}
        for cell in row.iter(f"{SPREADSHEET}c"):
            value = cell.find(f"{SPREADSHEET}v")
            if value is not None and value.text is not None:
                column = re.sub(r"\d", "", cell.get("r", ""))
                is_text = cell.get("t") == "s"
                cells[column] = texts[int(value.text)] if is_text else value.text
        rows.append(cells)
    return rows


def _items(content: bytes) -> list[str]:
    """Shared texts of a workbook."""
    root = ElementTree.fromstring(content)
    return [
        "".join(part.text or "" for part in item.iter(f"{SPREADSHEET}t"))
        for item in root.iter(f"{SPREADSHEET}si")
    ]
