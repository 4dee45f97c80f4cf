"""Causes of errors against the sealed truth, from records whose fault is known."""

import numpy as np
import pandas as pd
import pytest

from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings
from softsample.response.curves import ResponseCurves
from softsample.scoring import (
    against_truth_mesh,
    contact_zero_error,
    contact_zero_part,
    noise_part,
    recovery_table,
)

TRAVEL = np.linspace(0.0, 4e-3, 81)
FAMILY = ResponseCurves(np.array([1.0]), TRAVEL, (TRAVEL**2)[None, :])
SETTINGS = CalibrationSettings()


def test_height_above_the_true_start():
    truth = {"mesh": {"highest_point_mm": 12.95}}
    assert contact_zero_error(truth, {"highest_point_mm": 13.05}) == pytest.approx(1e-4)


def test_a_misplaced_start_explains_the_error_that_it_makes():
    late = 1e-4
    displacement = TRAVEL[:-4]
    true = MeasuredCurve(displacement, 1000.0 * (displacement + late) ** 2)
    fitted = 1000.0 * float(np.interp(3e-3, displacement, true.force) / (1000.0 * 3e-3**2))
    part = contact_zero_part({"C1": FAMILY}, {"C1": true}, {"C1": late}, fitted, SETTINGS)
    # 2 % of travel and a squared law: the modulus is 6.8 % too high at 3 mm
    assert part == pytest.approx(100.0 * (fitted / 1000.0 - 1.0), abs=0.05)
    assert contact_zero_part({"C1": FAMILY}, {"C1": true}, {}, 1000.0, SETTINGS) < -5.0


def test_noise_moves_the_modulus_by_its_norm():
    rng = np.random.default_rng(3)
    force = np.linspace(0.0, 1.0, 1001)
    moduli = [
        MeasuredCurve(force, force + rng.normal(0.0, 0.02, 1001)).scale_of(force)
        for _ in range(400)
    ]
    noisy = MeasuredCurve(force, force + rng.normal(0.0, 0.02, 1001))
    assert noise_part(noisy) == pytest.approx(100.0 * np.std(moduli), rel=0.15)


def test_row_of_the_recovery_by_hand():
    score = pd.DataFrame(
        {"sample": ["T1", "C1"], "group": "TC1", "mu_true_pa": 1000.0, "mu_real_pa": 1080.0,
         "mu_real_error_percent": 8.0, "volume_error_percent": 0.5}
    )  # fmt: skip
    sensitivity = pd.DataFrame(
        {"sample": ["T1", "C1", "C1"], "end_force_percent": [-3.0, -1.0, 0.1],
         "change": ["elements of twice the size"] * 2 + ["double precision"]}
    )  # fmt: skip
    band = pd.DataFrame({"sample": ["T1", "C1"], "low_percent": -0.2, "high_percent": 0.1})
    noise = {"T1": 0.01, "C1": 0.02}
    truth = {"volume_mm3": 5000.0, "glued_top_area_projected_mm2": 200.0}
    cuboid = {"volume_real_mm3": 5050.0, "glued_area_mm2": 190.0}
    modes = {"T1": "tension", "C1": "compression"}
    meshes = {
        sample: against_truth_mesh({"mode": mode, "mesh": truth}, cuboid)
        for sample, mode in modes.items()
    }
    table = recovery_table(score, {"TC1": 5.0}, {"C1": 0.1}, noise, meshes, sensitivity, band)
    np.testing.assert_allclose(table["mesh_volume_percent"], 1.0)
    np.testing.assert_allclose(table["mesh_glued_percent"], [-5.0, np.nan])
    assert table["twice_the_size_percent"].tolist() == [-3.0, -1.0]
    assert table["contact_zero_mm"].isna().tolist() == [True, False]
    assert table["rest_percent"].tolist() == [pytest.approx(100.0 * (1.08 / 1.05 - 1.0))] * 2
    assert table.loc[1, "noise_percent"] == 0.02
