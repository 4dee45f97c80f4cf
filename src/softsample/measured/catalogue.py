"""Where the measured files come from, whose they are, and whether they are there unchanged."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from softsample.errors import InputError
from softsample.workflow import sha256

COLUMNS = ("set", "file", "source", "licence", "sha256")


def check_folder(root: Path, catalogue: pd.DataFrame) -> None:
    """Say plainly that the measured files are not there, and where to get them.

    Raises
    ------
    InputError
        If a folder of a set of the catalogue is absent.
    """
    absent = [name for name in catalogue["set"].unique() if not (root / name).is_dir()]
    if absent:
        sources = catalogue.drop_duplicates(["set", "source"])
        places = "\n".join(
            f"  {row.set}/ from {row.source} ({row.licence})"
            for row in sources.itertuples()
            if row.set in absent
        )
        raise InputError(
            f"the measured data are not in {root}: no folder {', '.join(absent)}. They are others' "
            f"files and do not come with softsample; fetch\n{places}\nand name the folder that "
            "holds these with the variable SOFTSAMPLE_MEASURED_ROOT or the config key measured_root"
        )


def check_files(root: Path, rows: pd.DataFrame) -> None:
    """Check that files of the catalogue are as they were published.

    Raises
    ------
    InputError
        If one is absent or differs; names it and its source.
    """
    for row in rows.itertuples():
        path = root / str(row.set) / str(row.file)
        if not path.is_file():
            raise InputError(f"{path}: not there; fetch it from {row.source}")
        if sha256(path) != row.sha256:
            raise InputError(
                f"{path}: its content is not that of the published file; fetch it again from "
                f"{row.source}, or give its new sha256 in config/measured.tsv"
            )


def set_files(root: Path, catalogue: pd.DataFrame, name: str) -> Sequence[str]:
    """Paths of the files of one set."""
    files = catalogue.loc[catalogue["set"] == name, "file"]
    return [str(root / name / file) for file in files]
