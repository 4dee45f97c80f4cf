"""A new study folder with a worked sample, and samples added to it."""

import filecmp
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from softsample.errors import InputError
from softsample.io import PathLike, read_lines, read_samples, write_text
from softsample.study import ROOT, SETTINGS, TABLE, schema, table_of
from softsample.validation import FILE_COLUMNS, sample_faults, sample_rows

NAMING = ("image", "surface", "record")
"""Columns of files, of which the first one that is given names the sample."""

WORKED = {"image": "images/C3.nii.gz", "record": "records/C3.csv"}
"""Files of the cohort that make the worked sample."""

EXAMPLE = "example"


def new_study(folder: PathLike) -> Path:
    """Make a study folder: commented table, settings, and a worked sample.

    Raises
    ------
    InputError
        If the folder has a table already.
    """
    target = Path(folder)
    if (target / TABLE).exists():
        raise InputError(f"{target / TABLE} is there already; choose another folder, or edit it")
    target.mkdir(parents=True, exist_ok=True)
    for source in WORKED.values():
        name = "".join([EXAMPLE, *Path(source).suffixes])
        shutil.copyfile(ROOT / "resources/cohort" / source, target / name)
    for name in (SETTINGS, TABLE):  # the table last: with it the study is there
        write_text(target / name, (ROOT / "resources/new-study" / name).read_text("utf-8"))
    return target


def add_sample(folder: PathLike, cells: Mapping[str, str]) -> str:
    """Copy the files of a sample into a study and add its row; the worked sample makes way.

    Parameters
    ----------
    folder
        Of the study.
    cells
        Of the row by column, empty ones may be absent; columns that the table lacks are added to
        it. Files are named from where they are; the image may be a folder of DICOM files, and
        one that the study has, of a piece that is tested again. `sample` is by default the name of
        the first of image, surface and record, beside a `specimen` that of the record; `group` is
        by default the specimen, or the sample.

    Returns
    -------
    str
        The sample's id.

    Raises
    ------
    InputError
        If a file or the study is not there, a name is taken, or the row is wrong; nothing is
        copied then.
    """
    table = table_of(Path(folder))
    files = {name: Path(cells[name]) for name in FILE_COLUMNS if cells.get(name)}
    row = {name: cell for name, cell in cells.items() if cell}
    if "record" not in files:
        raise InputError(f"{table}: a sample needs a record; name its file")
    naming = ("record",) if "specimen" in row else NAMING
    row.setdefault("sample", _name_of(next(files[c] for c in naming if c in files)))
    row.setdefault("group", row.get("specimen", row["sample"]))
    targets = {column: table.parent / source.name for column, source in files.items()}
    taken: dict[Path, str] = {}
    for column, source in files.items():
        _check_source(column, source)
        first = taken.setdefault(targets[column], column)
        if source.resolve() != files[first].resolve():
            raise InputError(f"{source}: the file of column {first} has this name too; rename one")
        row[column] = source.name + "/" * source.is_dir()
    text = _with_row(table, row)
    _check_row(text, row["sample"], table)
    for column, source in files.items():
        _check_free(source, targets[column])
    for column, source in files.items():
        if source.is_dir() and not targets[column].exists():
            shutil.copytree(source, targets[column], symlinks=True)
        elif not targets[column].exists():
            shutil.copyfile(source, targets[column])
    write_text(table, text)
    return row["sample"]


def _name_of(source: Path) -> str:
    """Id of a sample after one of its files."""
    name = source.name.split(".")[0]
    if not re.search(schema("samples")["properties"]["sample"]["pattern"], name):
        raise InputError(
            f"{source}: {name!r} cannot be a sample's id, which has letters a to z, digits, _ and "
            "- only; give another one (--sample)"
        )
    return name


def _with_row(table: Path, row: Mapping[str, str]) -> str:
    """Text of a table with one row more, and with the columns that it needs."""
    columns = list(read_samples(table).columns)
    wanted = [*columns, *(name for name in row if name not in columns)]
    lines, _ = read_lines(table, "save the table as tab-separated text")
    kept = [f"# {line}" if line.startswith(f"{EXAMPLE}\t") else line for line in lines]
    head = next(n for n, line in enumerate(kept) if line.strip() and line.lstrip()[0] != "#")
    kept[head] = "\t".join([kept[head].rstrip("\t"), *wanted[len(columns) :]])
    new = "\t".join(row.get(column, "") for column in wanted).rstrip("\t")
    return "\n".join([*kept, new]).replace(f"\n\n{new}", f"\n{new}") + "\n"


def _check_row(text: str, sample: str, table: Path) -> None:
    """Refuse the last row of a table if it is wrong; other rows are left to the check."""
    with TemporaryDirectory() as folder:
        aside = Path(folder) / TABLE
        aside.write_text(text, encoding="utf-8")
        cells = read_samples(aside)
    rows = sample_rows(cells, str(table))
    faults = sample_faults(cells, rows, schema("samples"))
    wrong = [str(fault) for fault in faults if fault.line == max(rows)]
    if wrong:
        lines = "\n".join(f"  {fault}" for fault in wrong)
        raise InputError(f"sample {sample} is not added to {table}:\n{lines}")


def _check_source(column: str, source: Path) -> None:
    """Refuse a file that is not there, or not alone."""
    if not source.exists():
        raise InputError(f"{source}: no such {column}; correct its path")
    if source.suffix.lower() == ".nhdr":
        raise InputError(f"{source}: copy it and its data file into the study, and add the row")


def _check_free(source: Path, target: Path) -> None:
    """Refuse a file whose name is taken in the study by another one."""
    if not target.exists() or source.resolve() == target.resolve():
        return
    if source.is_dir() or target.is_dir() or not filecmp.cmp(source, target, shallow=False):
        raise InputError(f"{target} is there already; rename {source}, or add the row yourself")
