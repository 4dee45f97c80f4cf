"""Study folders of measured sets: table of samples, records and settings."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from softsample.errors import InputError
from softsample.files import written_aside
from softsample.io import read_table, read_yaml
from softsample.measured.catalogue import check_files, check_folder
from softsample.measured.readers import READERS
from softsample.measured.sample import Sample
from softsample.study import ROOT, SETTINGS, TABLE

COLUMNS = (
    "sample", "group", "mode", "record", "shape", "length_mm", "width_mm", "height_mm",
    "diameter_mm", "specimen", "ends", "cycle", "material_z", "material_x",
)  # fmt: skip
"""Of the table of samples that is written."""

CATALOGUE = ROOT / "config/measured.tsv"
STUDIES = ROOT / "config/measured.yaml"


def write_studies(root: Path, target: Path, wanted: Sequence[str] = ()) -> list[Path]:
    """Write the study folders of the measured sets, `{target}/{study}/`.

    A file whose content is that of before is left alone, so that nothing that rests on it is made
    again.

    Parameters
    ----------
    root
        Folder with one folder a set.
    target
        Folder of the study folders.
    wanted
        Names of studies or of sets; all if there are none.

    Returns
    -------
    list of Path
        The study folders, in the order of config/measured.yaml.

    Raises
    ------
    InputError
        If there is no such study, or a file is absent, another one, or not of its set's form.
    """
    studies = chosen_studies(wanted)
    catalogue = read_table(CATALOGUE)
    readers = {name: READERS[name] for name in (study["reader"] for study in studies.values())}
    catalogue = catalogue[catalogue["set"].isin({reader.set for reader in readers.values()})]
    check_folder(root, catalogue)
    check_files(root, catalogue)
    samples = {name: reader.read(root / reader.set) for name, reader in readers.items()}
    for name, study in studies.items():
        kept = within(samples[study["reader"]], study.get("strain_max"))
        write_study(target / name, kept, study)
    return [target / name for name in studies]


def chosen_studies(wanted: Sequence[str] = ()) -> dict[str, Any]:
    """Entries of config/measured.yaml by the name of the study.

    Raises
    ------
    InputError
        If a wanted name is neither that of a study nor that of a set.
    """
    studies = read_yaml(STUDIES)["studies"]
    sets = {name: READERS[study["reader"]].set for name, study in studies.items()}
    unknown = set(wanted) - set(sets) - set(sets.values())
    if unknown:
        raise InputError(
            f"no measured study or set {', '.join(sorted(unknown))}; there are {', '.join(studies)}"
        )
    return {
        name: study
        for name, study in studies.items()
        if not wanted or {name, sets[name]} & set(wanted)
    }


def within(samples: Sequence[Sample], strain_max: float | None) -> list[Sample]:
    """Samples with the rows of their records up to a nominal strain, if there is a limit."""
    if strain_max is None:
        return list(samples)
    return [replace(s, record=s.record[np.abs(s.strain) <= strain_max]) for s in samples]


def write_study(folder: Path, samples: Sequence[Sample], study: Mapping[str, Any]) -> None:
    """Write a study folder; the table last, as with it the study is there.

    Parameters
    ----------
    folder
        Its name is that of the study.
    samples
        As the reader gives them.
    study
        `ends` of all samples, and `settings` that differ from config/config.yaml.
    """
    for sample in samples:
        _write(folder / record_path(sample), _csv(sample.record, ","))
    settings = yaml.safe_dump(study["settings"], sort_keys=False, width=100)
    _write(folder / SETTINGS, f"# Made by `make measured` of config/measured.yaml\n{settings}")
    _write(folder / TABLE, _csv(sample_table(samples, study["ends"]), "\t"))


def record_path(sample: Sample) -> str:
    """Path of a sample's record, relative to the table."""
    return f"records/{sample.name}.csv"


def sample_table(samples: Sequence[Sample], ends: str) -> pd.DataFrame:
    """Table of samples with the columns `COLUMNS`; cells that do not apply are empty."""
    rows = [
        {
            "sample": sample.name,
            "group": sample.group,
            "mode": sample.mode,
            "record": record_path(sample),
            **sample.shape,
            "specimen": sample.specimen or sample.name,
            "ends": ends,
            "cycle": sample.cycle,
            "material_z": sample.material_z,
            "material_x": sample.material_x,
        }
        for sample in samples
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _csv(table: pd.DataFrame, separator: str) -> str:
    """A table as text, eight significant digits, the same every time."""
    return table.to_csv(None, sep=separator, index=False, float_format="%.8g", lineterminator="\n")


def _write(path: Path, text: str) -> None:
    """Write a file aside and rename it, unless it holds the text already."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        with written_aside(path) as aside:
            aside.write_text(text, encoding="utf-8", newline="\n")
