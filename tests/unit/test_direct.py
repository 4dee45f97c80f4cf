"""Calibration with a simulation per evaluation, on closed-form bars."""

from types import SimpleNamespace

import numpy as np
import pytest

from softsample.calibration.direct import SimulatedCurves, simulated_curves
from softsample.calibration.group import GroupCurves
from softsample.calibration.measured import MeasuredCurve
from softsample.calibration.slsqp import CalibrationSettings, fit_ogden
from softsample.meshing.cuboid import mesh_cuboid
from softsample.response.curves import ResponseCurves

HEIGHT, AREA = 13e-3, 4.6e-4  # of a bar [m], [m2]
TRAVEL = {"T1": 0.25 * HEIGHT, "C1": 0.3 * HEIGHT}
MODES = {"T1": "tension", "C1": "compression"}


def bar(sample, travel, fraction, alpha):
    """Force per modulus along the travel [m2] of an incompressible two-term Ogden bar."""
    sign = 1.0 if sample.startswith("T") else -1.0
    stretch = 1.0 + sign * np.asarray(travel) / HEIGHT
    nominal = sum(
        2.0 * share / a * (stretch ** (a - 1.0) - stretch ** (-0.5 * a - 1.0))
        for share, a in zip((fraction, 1.0 - fraction), alpha, strict=True)
    )
    return sign * AREA * nominal


def record_of(sample, mu, fraction, alpha, seed=0, noise=0.0):
    travel = np.linspace(0.0, TRAVEL[sample], 200)
    rng = np.random.default_rng(seed)
    return MeasuredCurve(
        travel, mu * bar(sample, travel, fraction, alpha) + noise * rng.normal(size=200)
    )


class Bar:
    """Stands for a model: its run is the bar's closed form."""

    def __init__(self, sample):
        self.sample, self.runs = sample, 0

    def run(self, material, boundary, travel, loading_time):
        self.runs += 1
        displacement = np.linspace(0.0, travel, 60)
        fraction = material.mu[0] / material.shear_modulus
        force = material.shear_modulus * bar(self.sample, displacement, fraction, material.alpha)
        return SimpleNamespace(displacement=displacement, force=force)


def test_direct_simulations_end_at_the_optimum_of_the_families():
    alpha, fractions = (-8.0, 16.0), np.linspace(0.0, 1.0, 6)
    measured = {s: record_of(s, 1300.0, 0.8, (-7.0, 15.0), noise=2e-3) for s in TRAVEL}
    travel = {s: np.linspace(0.0, TRAVEL[s], 60) for s in TRAVEL}
    families = {
        s: ResponseCurves(fractions, d, np.array([bar(s, d, r, alpha) for r in fractions]))
        for s, d in travel.items()
    }
    bars = {sample: Bar(sample) for sample in TRAVEL}
    simulated = {
        s: SimulatedCurves(model, None, TRAVEL[s], 0.04, alpha, 0.49, (0.05, 0.95))
        for s, model in bars.items()
    }
    direct = fit_ogden(simulated, measured, CalibrationSettings(method="direct"))
    family = fit_ogden(families, measured, CalibrationSettings())
    assert direct.mu == pytest.approx(family.mu, rel=5e-3)
    assert direct.mu1_fraction == pytest.approx(family.mu1_fraction, abs=5e-3)
    for sample, curves in simulated.items():
        assert curves.simulations == bars[sample].runs > 10
        assert curves.cpu_s > 0.0


def test_a_sample_that_is_held_out_is_not_simulated():
    mesh = mesh_cuboid(4e-3, 4e-3, 4e-3, 2e-3)
    sample = mesh, {"glued": np.zeros(len(mesh.points), bool)}, {}
    law = {"alpha": (-8.0, 16.0), "poisson_ratio": 0.49}
    travel = np.linspace(0.0, TRAVEL["C1"], 60)
    response = ResponseCurves(np.array([0.0, 1.0]), travel, np.ones((2, 60)))
    group = GroupCurves(MODES, {"C1": response}, {"C1": MeasuredCurve(travel, travel)})
    sections = {"solver": {}, "contact": {}, "material": law}
    pairs = [sample] * 2, ["bonded"] * 2, [{"loading_time_s": 0.04}] * 2
    assert set(simulated_curves(group, *pairs, sections)) == {"C1"}
