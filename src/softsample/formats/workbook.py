"""Workbooks (.xlsx, .xls): their sheets as lines of text, so that one reader takes both."""

import csv
import io
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from datetime import timedelta
from pathlib import Path
from typing import Any

from softsample.errors import InputError
from softsample.files import PathLike
from softsample.formats import damage_refused
from softsample.formats.text import LARGEST_BYTES

XLSX, XLS = b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
"""How files of both kinds begin: their endings do not tell, since text may be named .xls too."""

MOST_CELLS = 10**7
"""A sheet with more is refused: few bytes can stand for many empty cells."""

Rows = Iterable[Sequence[Any]]

Sheets = dict[str, tuple[bool, Rows]]
"""Whether each sheet can be seen, and its rows, by name."""


def is_workbook(path: PathLike) -> bool:
    """Whether a file is a workbook, by its first bytes."""
    try:
        with open(path, "rb") as stream:
            first = stream.read(len(XLS))
    except (OSError, ValueError):
        return False
    return first.startswith((XLSX, XLS))


def read_sheets(path: PathLike, sheet: str | None = None) -> Iterator[tuple[str, list[str]]]:
    """Read the sheets of a workbook one by one.

    Parameters
    ----------
    path
        Workbook; of formulas the values are taken that were saved with them.
    sheet
        Name of the only sheet that is wanted; without it hidden ones are ignored.

    Yields
    ------
    name : str
    lines : list of str
        Cells of a row with tabs between them; the first is row 1.

    Raises
    ------
    InputError
        If there is no such sheet, or the file is damaged or too large; names file and cure.
    """
    with damage_refused(path):
        with open(path, "rb") as stream:
            old = stream.read(len(XLS)) == XLS
        sheets = _old_sheets(path) if old else _sheets(path)
        if sheet is not None and sheet not in sheets:
            raise InputError(f"{path}: no sheet {sheet!r}; there are {', '.join(sheets)}")
        shown = [name for name, (visible, _) in sheets.items() if visible]
        for name in [sheet] if sheet is not None else shown:
            yield name, _lines(sheets[name][1], path)


def _sheets(path: PathLike) -> Sheets:
    import openpyxl

    with zipfile.ZipFile(path) as archive:
        size = sum(part.file_size for part in archive.infolist())
    if size > LARGEST_BYTES:
        raise InputError(f"{path}: unpacks to more than {LARGEST_BYTES >> 20} MiB; export as CSV")
    book = openpyxl.load_workbook(
        io.BytesIO(Path(path).read_bytes()), read_only=True, data_only=True, keep_links=False
    )
    found = {}
    for sheet in book.worksheets:
        sheet.reset_dimensions()  # files of machines tell wrong ones
        visible = sheet.sheet_state == "visible"
        found[sheet.title] = visible, sheet.iter_rows(values_only=True)
    return found


def _old_sheets(path: PathLike) -> Sheets:
    import xlrd

    if Path(path).stat().st_size > LARGEST_BYTES:
        raise InputError(f"{path}: larger than {LARGEST_BYTES >> 20} MiB; export as CSV")
    book = xlrd.open_workbook(path, logfile=io.StringIO())

    def cell(kind: int, value: Any) -> Any:
        """What a cell shows: dates and errors are numbers in the file."""
        if kind == xlrd.XL_CELL_ERROR:
            return xlrd.error_text_from_code.get(value, "#ERROR")
        return xlrd.xldate_as_datetime(value, book.datemode) if kind == xlrd.XL_CELL_DATE else value

    return {
        sheet.name: (
            sheet.visibility == 0,
            [
                list(map(cell, sheet.row_types(number), sheet.row_values(number)))
                for number in range(sheet.nrows)
            ],
        )
        for sheet in book.sheets()
    }


def _lines(rows: Rows, path: PathLike) -> list[str]:
    """Rows as lines of text with tabs."""
    lines, cells = [], 0
    for row in rows:
        stream = io.StringIO()
        csv.writer(stream, delimiter="\t", lineterminator="").writerow(map(_text, row))
        lines.append(stream.getvalue())
        cells += len(row)
        if cells > MOST_CELLS:
            raise InputError(f"{path}: a sheet of more than {MOST_CELLS} cells; export as CSV")
    return lines


def _text(cell: Any) -> str:
    """A cell as text in one line; a number with a decimal point, elapsed time in hours."""
    if isinstance(cell, timedelta):  # whose own text counts days
        minutes, seconds = divmod(cell.total_seconds(), 60.0)
        return f"{minutes // 60.0:.0f}:{minutes % 60.0:02.0f}:{seconds:09.6f}"
    return "" if cell is None else " ".join(str(cell).split())
