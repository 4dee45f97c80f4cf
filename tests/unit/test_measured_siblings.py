"""Odd zeros among siblings: planted ones are found, and few others are."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from softsample.measured.measurement import Measurement, cylinder, untimed
from softsample.measured.readers import ecoflex
from softsample.measured.siblings import FORCE, TRAVEL, odd_zeros

ROOT = Path(__file__).resolve().parents[2]
MEASURED = Path(os.environ.get("SOFTSAMPLE_MEASURED_ROOT", ROOT / "resources/measured"))
SCATTER_N, SCATTER_MM = 0.006, 0.05


def siblings(seed):
    """190 records that differ by stiffness, zeros and noise as repeats do, of two load cells."""
    random = np.random.default_rng(seed)
    travel = np.linspace(0.0, 10e-3, 400)
    found = []
    for k in range(190):
        group, specimen = f"m{k // 10}", "AB"[k // 5 % 2]
        stiffness = (1.0 + 0.3 * (k // 10)) * (1.0 + 0.02 * random.normal())
        late = 1e-3 * SCATTER_MM * random.normal()
        pushed = np.maximum(travel - late + 3e-4, 0.0)  # all touch a little before zero travel
        force = stiffness * 1e3 * (pushed + 30.0 * pushed**2)
        force += -force[0] + SCATTER_N * random.normal(size=len(travel))
        record = untimed(-travel, -force)
        found.append(
            Measurement(f"{group}_{k}", group, specimen, "compression", cylinder(50, 30), record)
        )
    return found


def planted(tests, chosen, sizes_n=None, sizes_mm=None):
    """The records with an offset [N], or a shift [mm], added to the chosen ones."""
    tests = list(tests)
    for n, k in enumerate(chosen):
        record = tests[k].record
        if sizes_n is not None:
            record = replace(record, force=record.force - sizes_n[n])
        if sizes_mm is not None:
            at = -record.displacement
            moved = np.interp(at - 1e-3 * sizes_mm[n], at, -record.force)
            record = replace(record, force=-moved)
        tests[k] = replace(tests[k], record=record)
    return tests


def judge(tests, cells, effect):
    table = odd_zeros(tests, cells)
    return table[table["effect"] == effect].set_index("record")


def scores(tests, cells, seed):
    """Which records are found of those that got an offset above three sigma of the siblings'
    scatter, and of the rest that was like its siblings before."""
    random = np.random.default_rng(seed)
    plain = judge(tests, cells, FORCE)
    calm = np.flatnonzero(~plain["found"].to_numpy(bool))
    chosen = random.choice(calm, 19, replace=False)
    sigma = (plain["size"] / plain["sigmas"]).to_numpy()[chosen]
    sizes = random.choice([-1.0, 1.0], 19) * random.uniform(3.0, 12.0, 19) * sigma
    after = judge(planted(tests, chosen, sizes_n=sizes), cells, FORCE)["found"].to_numpy()
    return after[chosen], after[np.setdiff1d(calm, chosen)]


def test_planted_zeros_of_force_are_found_and_few_others():
    found, alarms = [], []
    for seed in range(12):
        tests = siblings(seed)
        cells = {test.name: "1kN" if k < 90 else "10kN" for k, test in enumerate(tests)}
        found.append(scores(tests, cells, seed))
        alarms.append(judge(tests, cells, FORCE)["found"])
    assert np.mean([hits for hits, _ in found]) >= 0.95
    assert np.mean(np.concatenate([rest for _, rest in found])) <= 0.05
    assert np.mean(alarms) <= 0.05


@pytest.mark.skipif(
    not MEASURED.is_dir(), reason=f"measured data not at {MEASURED}; set SOFTSAMPLE_MEASURED_ROOT"
)
def test_planted_zeros_of_force_are_found_among_the_real_records():
    folder = MEASURED / "ecoflex-phantoms"
    tests, cells = ecoflex.read(folder), ecoflex.load_cells(folder)
    found = [scores(tests, cells, seed) for seed in range(12)]
    assert np.mean([hits for hits, _ in found]) >= 0.95
    assert np.mean(np.concatenate([alarms for _, alarms in found])) <= 0.05
    plain = judge(tests, cells, FORCE)
    assert plain["found"].sum() < 0.15 * len(tests)


def test_a_zero_is_named_with_its_size_and_reason():
    tests = planted(siblings(3), [7, 40], sizes_n=[-0.2, 0.0], sizes_mm=[0.0, 0.8])
    table = odd_zeros(tests, dict.fromkeys((t.name for t in tests), "1kN"))
    odd = table.set_index(["record", "effect"]).loc
    assert odd[(tests[7].name, FORCE), "size"] == pytest.approx(-0.2, abs=4 * SCATTER_N)
    assert odd[(tests[7].name, FORCE), "found"]
    assert "cell was not at its zero" in odd[(tests[7].name, FORCE), "why"]
    assert odd[(tests[40].name, TRAVEL), "size"] == pytest.approx(0.8, abs=4 * SCATTER_MM)
    assert odd[(tests[40].name, TRAVEL), "class"] == "displacement_zero|late_contact"


def test_records_without_a_load_cell_are_passed_over():
    table = odd_zeros(siblings(1)[:5], {})
    assert len(table[table["found"]].drop(columns="found")) == 0
