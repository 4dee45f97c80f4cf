"""Known effects on top of measured records: `python -m softsample.measured.known RESULTS TARGET`.

Does the diagnosis name them? `write` makes study folders like those of the measured sets whose
records have one effect each, so large that the diagnosis of the records as they are said it would
see it, and withholds the ground truth. The forms of the effects are this file's own. `score`
compares the verdicts with the ground truth.
"""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from softsample.errors import InputError, SoftsampleError
from softsample.files import sha256
from softsample.io import read_json, read_samples, read_table, write_json, write_table, write_text
from softsample.study import SETTINGS, TABLE

MULTIPLE = 2.5
"""Size of an effect over its detection limit in the records as they are."""

TRUTH, SEAL, SCORE = "ground_truth.json", "seal.json", "score.csv"

Record = pd.DataFrame
Change = Callable[[Record, float], Record]


def _offset(record: Record, size: float) -> Record:
    """A force reading that is off by `size` [mN]."""
    return record.assign(force_N=record["force_N"] + 1e-3 * size)


def _drift(record: Record, size: float) -> Record:
    """A force reading that drifts by `size` [mN/s], less and less over an hour."""
    time = record["time_s"] - record["time_s"].iloc[0]
    return record.assign(force_N=record["force_N"] + 3.6 * size * -np.expm1(-time / 3600.0))


def _compliance(record: Record, size: float) -> Record:
    """A machine that gives way by `size` [mm/N]."""
    return record.assign(displacement_mm=record["displacement_mm"] + size * record["force_N"])


def _gap(record: Record, size: float) -> Record:
    """A platen that starts `size` [mm] above the sample, at the speed of the record's beginning."""
    way = record["displacement_mm"].to_numpy()
    moves = np.abs(np.diff(way))
    sign, step = np.sign(way[np.argmax(np.abs(way))]), np.median(moves[moves > 0.0][:20])
    count = max(2, round(size / step))
    resting = np.random.default_rng(count).choice(record["force_N"].to_numpy()[:5], count)
    before = pd.DataFrame(0.0, index=range(count), columns=record.columns)
    before["displacement_mm"] = sign * np.linspace(0.0, size, count, endpoint=False)
    before["force_N"] = resting - resting.mean() + record["force_N"].iloc[0]
    after = record.assign(displacement_mm=way + sign * size)
    if "time_s" in record:
        time = record["time_s"].to_numpy()
        interval = float(np.median(np.diff(time)))
        before["time_s"] = time[0] + interval * np.arange(count)
        after["time_s"] = time + interval * count
    return pd.concat([before, after], ignore_index=True)


def _lag(record: Record, size: float) -> Record:
    """A force that is written `size` [s] late."""
    time = record["time_s"]
    return record.assign(force_N=np.interp(time - size, time, record["force_N"]))


def _crosstalk(record: Record, size: float) -> Record:
    """A normal force that reads a part `size` of the force along the displacement."""
    return record.assign(force_normal_N=record["force_normal_N"] + size * record["force_N"])


EFFECTS: dict[str, tuple[Change, tuple[str, ...], tuple[str, ...]]] = {
    "force_offset": (_offset, (), ()),
    "force_drift": (_drift, ("time_s",), ()),
    "machine_compliance": (_compliance, (), ()),
    "late_contact": (_gap, (), ("compression",)),
    "channel_lag": (_lag, ("time_s",), ()),
    "channel_crosstalk": (_crosstalk, ("force_normal_N",), ()),
}  # fmt: skip
"""By the name of the effect that it is: what it does, to which columns, in which modes (or all)."""


def write(results: Path, target: Path, studies: Sequence[str]) -> list[Path]:
    """Write study folders with one effect each, `{target}/{study}-{effect}/`, and the ground truth.

    Parameters
    ----------
    results
        Results of the measured sets: `studies/{study}/` and `{study}/loop/{group}/verdict.json`.
    target
        Folder of the study folders, of `ground_truth.json` and of `seal.json`.
    studies
        Names of the studies whose records are changed.

    Returns
    -------
    list of Path
        The study folders.

    Raises
    ------
    InputError
        If a study has no verdict.
    """
    found, folders = [], []
    for study in studies:
        limits = {
            group: verdict
            for group, verdict in _verdicts(results, study).items()
            if verdict["verdict"] in ("explained", "none")
        }
        for effect in EFFECTS:
            sizes = {
                group: MULTIPLE * verdict["detection_limits"][effect]["value"]
                for group, verdict in limits.items()
                if effect in verdict["detection_limits"] and effect not in _named(verdict)
            }
            folder = target / f"{study}-{effect}"
            if rows := _written(results / "studies" / study, folder, effect, sizes):
                folders.append(folder)
                found += [{"study": study, "effect": effect, **row} for row in rows]
    write_json(target / TRUTH, {"experiments": found})
    write_json(target / SEAL, {"sha256": sha256(target / TRUTH)})
    return folders


def score(results: Path, target: Path) -> pd.DataFrame:
    """What the verdicts made of the ground truth, one row a group.

    Parameters
    ----------
    results
        Results of the measured sets as they are.
    target
        Folder of `ground_truth.json`; results of its studies are below `results/`.

    Returns
    -------
    DataFrame
        `study`, `effect`, `group`, `size`, `verdict`, `effects`, and `answer`: `right` if a class
        holds the effect; `wrong` if not, but one is named that the unchanged records did not have;
        `missed`.

    Raises
    ------
    InputError
        If the ground truth has changed since.
    """
    if sha256(target / TRUTH) != read_json(target / SEAL)["sha256"]:
        raise InputError(
            f"{target / TRUTH}: not the ground truth that was withheld; make the studies again"
        )
    rows = []
    for case in read_json(target / TRUTH)["experiments"]:
        before = read_json(_verdict(results, case["study"], case["group"]))
        study = f"{case['study']}-{case['effect']}"
        path = _verdict(target / "results", study, case["group"])
        after = read_json(path) if path.is_file() else {"verdict": "failed", "effects": []}
        rows.append({**case, **_answer(case["effect"], before, after)})
    return pd.DataFrame(rows)


def _answer(effect: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, str]:
    """Verdict, its classes, and what they are worth."""
    classes = [one["class"] for one in after["effects"]]
    right = any(effect in names for names in classes)
    foreign = any(not set(names) & _named(before) for names in classes)
    return {
        "verdict": after["verdict"],
        "effects": "; ".join("|".join(names) for names in classes),
        "answer": "right" if right else "wrong" if foreign else "missed",
    }


def _verdicts(results: Path, study: str) -> dict[str, Mapping[str, Any]]:
    """Verdicts of a study by group."""
    groups = dict.fromkeys(read_samples(results / "studies" / study / TABLE)["group"])
    paths = {group: _verdict(results, study, group) for group in groups}
    if absent := [str(path) for path in paths.values() if not path.is_file()]:
        raise InputError(f"{absent[0]}: there is none; run `make measured` first")
    return {group: read_json(path) for group, path in paths.items()}


def _verdict(results: Path, study: str, group: str) -> Path:
    return results / study / "loop" / group / "verdict.json"


def _named(verdict: Mapping[str, Any]) -> set[str]:
    return {name for one in verdict["effects"] for name in one["class"]}


def _written(
    study: Path, folder: Path, effect: str, sizes: Mapping[str, float]
) -> list[dict[str, Any]]:
    """Write a study with an effect in groups of some sizes; its ground truth.

    A group whose records lack a column or a mode that the effect needs is left out.
    """
    change, columns, modes = EFFECTS[effect]
    table = read_samples(study / TABLE)
    records = {row["record"]: read_table(study / row["record"]) for _, row in table.iterrows()}
    able = [
        group
        for group, of in ((str(name), rows) for name, rows in table.groupby("group"))
        if group in sizes
        and (not modes or set(of["mode"]) & set(modes))
        and all(set(columns) <= set(records[path]) for path in of["record"])
    ]
    kept = table[table["group"].isin(able)]
    for _, row in kept.iterrows():
        record = records[row["record"]]
        if not modes or row["mode"] in modes:
            record = change(record, sizes[row["group"]])
        write_table(folder / row["record"], record)
    if able:
        write_text(folder / SETTINGS, (study / SETTINGS).read_text(encoding="utf-8"))
        write_text(folder / TABLE, kept.to_csv(None, sep="\t", index=False))
    return [{"group": group, "size": sizes[group]} for group in able]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; prints the study folders, or the score, and returns the status."""
    parser = argparse.ArgumentParser(
        prog="python -m softsample.measured.known", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("results", type=Path, help="results of the measured sets")
    parser.add_argument("target", type=Path, help="folder of the changed studies")
    parser.add_argument("studies", nargs="*", help="studies to change; none: score the verdicts")
    given = parser.parse_args(arguments)
    try:
        if given.studies:
            print(*write(given.results, given.target, given.studies), sep="\n")
        else:
            table = score(given.results, given.target)
            write_table(given.target / SCORE, table)
            print(pd.crosstab([table["study"], table["effect"]], table["answer"]).to_string())
    except (SoftsampleError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
