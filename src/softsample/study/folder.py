"""A new study folder with a worked sample, and samples added to it."""

import shutil
from pathlib import Path

from softsample.errors import InputError
from softsample.io import PathLike, read_lines, read_samples, write_text
from softsample.study import ROOT, SETTINGS, TABLE, table_of

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


def add_sample(
    folder: PathLike,
    mode: str,
    image: PathLike,
    record: PathLike,
    sample: str = "",
    group: str = "",
) -> str:
    """Copy the files of a sample into a study and add its row; the worked sample makes way.

    Parameters
    ----------
    folder
        Of the study.
    mode
        `tension`, `compression` or `shear`.
    image, record
        Files from anywhere; the image may be a folder of DICOM files.
    sample, group
        Ids; the image's name without its ending, and the sample's id, if empty.

    Returns
    -------
    str
        The sample's id.

    Raises
    ------
    InputError
        If a file or the study is not there, or a name is taken.
    """
    table = table_of(Path(folder))
    name = sample or Path(image).name.split(".")[0]
    columns = list(read_samples(table).columns)
    sources = {"image": Path(image), "record": Path(record)}
    targets = {column: table.parent / source.name for column, source in sources.items()}
    for column, source in sources.items():
        _check_source(column, source, targets[column])
    for column, source in sources.items():
        if source.is_dir() and not targets[column].exists():
            shutil.copytree(source, targets[column], symlinks=True)
        elif not targets[column].exists():
            shutil.copyfile(source, targets[column])
    cells = {"sample": name, "group": group or name, "mode": mode}
    for column, source in sources.items():
        cells[column] = source.name + "/" * source.is_dir()
    lines, _ = read_lines(table, "save the table as tab-separated text")
    kept = [f"# {line}" if line.startswith(f"{EXAMPLE}\t") else line for line in lines]
    row = "\t".join(cells.get(column, "") for column in columns)
    write_text(table, "\n".join([*kept, row]).replace(f"\n\n{row}", f"\n{row}") + "\n")
    return name


def _check_source(column: str, source: Path, target: Path) -> None:
    """Refuse a file that is not there, not alone, or whose name is taken in the study."""
    if not source.exists():
        raise InputError(f"{source}: no such {column}; correct its path")
    if source.suffix.lower() == ".nhdr":
        raise InputError(f"{source}: copy it and its data file into the study, and add the row")
    if target.exists() and source.resolve() != target.resolve():
        raise InputError(f"{target} is there already; rename {source}, or add the row yourself")
