"""Where the files of the measured sets come from, and whether they are there unchanged."""

from pathlib import Path

import pandas as pd

from softsample.errors import InputError
from softsample.files import sha256


def check_folder(root: Path, catalogue: pd.DataFrame) -> None:
    """Refuse a root that lacks the folder of a set.

    Parameters
    ----------
    root
        Folder with one folder a set.
    catalogue
        Columns `set`, `file`, `source`, `licence`, `sha256` of the sets that are wanted.

    Raises
    ------
    InputError
        Names the absent sets, and the source and licence of each.
    """
    absent = [name for name in catalogue["set"].unique() if not (root / name).is_dir()]
    if absent:
        sources = catalogue[catalogue["set"].isin(absent)].drop_duplicates(["set", "source"])
        places = "\n".join(
            f"  {row.set}/ from {row.source} (licence: {row.licence})"
            for row in sources.itertuples()
        )
        raise InputError(
            f"the measured data are not in {root}: no folder {', '.join(absent)}. The files are "
            f"third-party data and do not come with softsample; fetch\n{places}\nand name the "
            "folder that holds them with the variable SOFTSAMPLE_MEASURED_ROOT"
        )


def check_files(root: Path, catalogue: pd.DataFrame) -> None:
    """Refuse files that are absent or not as they were published.

    Parameters
    ----------
    root, catalogue
        As of `check_folder`.

    Raises
    ------
    InputError
        Names the first such file and its source.
    """
    for row in catalogue.itertuples():
        path = root / str(row.set) / str(row.file)
        if not path.is_file():
            raise InputError(f"{path}: not there; fetch it from {row.source}")
        if sha256(path) != row.sha256:
            raise InputError(
                f"{path}: its content is not that of the published file; fetch it again from "
                f"{row.source}, or correct its sha256 in config/measured.tsv"
            )
