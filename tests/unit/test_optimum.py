"""The run at the optimum, and what stands in its place where it crushes elements."""

import numpy as np
import pytest

from softsample.checks import simulation_checks
from softsample.constitutive.homogeneous import homogeneous_force
from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import CrushedError
from softsample.response.optimum import optimum
from softsample.shapes import IdealShape

SHAPE = IdealShape("cuboid", 4e-3, 3.3e-3, 2.7e-3)
SECTIONS = {"solver": {"curve_points": 20}, "contact": {}, "material": {}}
RUBBER = OgdenMaterial((296.0,), (16.0,), 0.49)


def pulled(block, method, travel):
    """Of a block between sliding ends; the corner of `mesh_cuboid` lies in the origin."""
    top = block.points[:, 2] > SHAPE.height - 1e-9
    sample = block, {"glued": top}, {}
    response = {"method": method, "loading_time_s": 0.05}
    test = "tension", SECTIONS, "sliding"
    return optimum(sample, SHAPE, test, RUBBER, travel, response, lambda *_: None)


def test_a_run_that_crushes_elements_leaves_the_closed_form_and_a_check_that_fails(block):
    travel = 6.0 * SHAPE.height
    with pytest.raises(CrushedError):
        pulled(block, "simulated", travel)
    found = pulled(block, "closed form", travel)
    strain = found.displacement / SHAPE.height
    expected = SHAPE.area * homogeneous_force("tension", strain, RUBBER)
    np.testing.assert_allclose(found.force, expected, rtol=1e-12)
    np.testing.assert_allclose(found.field[:, 2], 6.0 * block.points[:, 2])
    assert found.field[:, 0].min() < 0.0  # it is thinner
    assert found.report["crushed_runs"] == 1


def test_a_run_that_comes_through_is_no_closed_form(block):
    assert "crushed_runs" not in pulled(block, "closed form", 0.1 * SHAPE.height).report


@pytest.mark.parametrize("crushed", [{}, {"crushed_runs": 0}, {"crushed_runs": 1}])
def test_crushed_runs_fail_a_check_of_their_own(block, crushed):
    run = {"energy_imbalance": 0.0, "hourglass_ratio": 0.0, "platen_against_base_percent": 0.0}
    direct = run | {"against_calibrated_curve_percent": 0.0} | crushed
    quality = {"inverted": 0, "min_scaled_jacobian": 1.0, "volume_difference_percent": 0.0}
    limits = {
        "volume_difference_percent_max": 1.0, "hourglass_ratio_max": 1.0,
        "hourglass_ratio_warning": 1.0, "platen_against_base_percent_max": 1.0,
        "direct_difference_percent_max": 1.0,
    }  # fmt: skip
    found = simulation_checks(block, quality, [{"error_bound_percent": 0.0}], direct, limits)
    failed = [item["name"] for item in found if not item["passed"]]
    assert failed == ["runs at the optimum that crushed elements"] * crushed.get("crushed_runs", 0)
