"""Reading foreign files: tables of numbers with a known header, and workbooks."""

from collections.abc import Sequence
from io import StringIO
from pathlib import Path

import numpy as np
import pandas as pd
import xlrd

from softsample.errors import InputError


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
    """Finite numbers below a header that holds the named columns, units included.

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
    return finite(path, table, columns)


def finite(path: Path, table: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """Named columns of a table as finite numbers.

    Raises
    ------
    InputError
        If a column is absent (another unit, another export) or a cell is no finite number.
    """
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


def check_stress(path: Path, stress: pd.Series, expected: pd.Series, what: str) -> None:
    """Refuse a file whose derived stress is not that of its force within 1 % of its peak.

    Raises
    ------
    InputError
        If unit or size of the sample is not what it is taken for.
    """
    apart = (stress - expected).abs().max() / expected.abs().max()
    if not apart < 0.01:
        raise InputError(f"{path}: {what.format(100 * apart)}")


def sheets(path: Path) -> dict[str, pd.DataFrame]:
    """Cells of every sheet of a workbook (.xls, .xlsx) by the sheet's name, without a header.

    Raises
    ------
    InputError
        If the file is no such workbook.
    """
    try:
        if path.suffix == ".xls":
            book = xlrd.open_workbook(path).sheets()
            rows = {sheet.name: map(sheet.row_values, range(sheet.nrows)) for sheet in book}
            return {name: pd.DataFrame(cells) for name, cells in rows.items()}
        return pd.read_excel(path, sheet_name=None, header=None, engine="openpyxl")
    except Exception as error:  # each library raises errors of its own
        raise InputError(f"{path}: not a readable workbook ({error}); fetch it again") from error


def headed(sheet: pd.DataFrame, rows: int = 1) -> pd.DataFrame:
    """A sheet below its header; of a header of several rows, cells of a column are joined."""
    head = sheet.iloc[:rows].map(lambda cell: "" if pd.isna(cell) else str(cell).strip())
    names = [" ".join(filter(None, head[column])) for column in head]
    return sheet.iloc[rows:].set_axis(names, axis="columns").reset_index(drop=True)
