"""Changed samples and cuboids, and the bias they have, against cases worked out by hand."""

import numpy as np
import pandas as pd
import pytest

from softsample.calibration.slsqp import CalibrationSettings
from softsample.errors import MeshError, SimulationError
from softsample.fem.boundary import ContactSettings
from softsample.geometry_effects.bias import experiments, families, group_bias
from softsample.geometry_effects.prescribed import as_far_as_it_goes
from softsample.geometry_effects.shapes import Shape, section_areas
from softsample.geometry_effects.variants import EffectSettings, Variant, variants
from softsample.meshing.bond import top_quads
from softsample.meshing.cuboid import mesh_cuboid
from softsample.meshing.mesh import HexMesh
from softsample.report.geometry_effects import (
    crossing,
    effects_table,
    needed_table,
    shares_table,
    spoken,
)
from softsample.report.prescribed import agreement, prescribed_table
from softsample.response.curves import ResponseCurves
from softsample.shapes import IdealShape

EDGES = (12e-3, 10e-3, 8e-3)
IDEAL = IdealShape("cuboid", *EDGES)
SLOPE = 0.05


def moved(mesh, change):
    """A mesh with `change(x, y, z)`, relative coordinates in and out, applied to its points."""
    points = np.stack(change(*mesh.points.T), axis=1)
    return HexMesh(points, mesh.hexes)


@pytest.fixture(scope="module")
def tilted():
    """A block that narrows upwards, its top a tilted plane of mean height H."""
    cuboid = mesh_cuboid(*EDGES, 1e-3)

    def change(x, y, z):
        side = 1.1 - 0.2 * z / EDGES[2]
        return side * x, side * y, z * (1.0 + SLOPE * side * x / EDGES[2])

    return Shape(moved(cuboid, change), cuboid, IDEAL, 30.0)


def test_sections_of_a_frustum():
    cuboid = mesh_cuboid(*EDGES, 1e-3)
    frustum = moved(cuboid, lambda x, y, z: (x * (1 - z / 20e-3), y * (1 - z / 20e-3), z))
    heights = np.array([0.05e-3, 2e-3, 4.3e-3, 8e-3])
    exact = EDGES[0] * EDGES[1] * (1.0 - heights / 20e-3) ** 2
    np.testing.assert_allclose(section_areas(frustum, heights), exact, rtol=2e-3)
    np.testing.assert_allclose(section_areas(frustum, heights[-1:]), exact[-1:], rtol=1e-5)


def test_the_top_is_what_looks_up_in_the_upper_half(tilted):
    assert len(top_quads(tilted.real, 30.0)) == 12 * 10
    assert len(top_quads(tilted.real, 1.0)) == 0
    with pytest.raises(MeshError, match=r"0 nodes within 1 degrees .* raise measurement"):
        _ = Shape(tilted.real, tilted.cuboid, IDEAL, 1.0).top


def test_a_levelled_sample_has_its_whole_top_at_the_height_of_the_cuboid(tilted):
    assert np.ptp(tilted.real.points[tilted.top, 2]) > 0.4e-3
    np.testing.assert_allclose(tilted.levelled.points[tilted.top, 2], EDGES[2], rtol=1e-9)
    np.testing.assert_array_equal(tilted.levelled.points[:, :2], tilted.real.points[:, :2])


def test_the_tapered_cuboid_has_the_areas_of_the_levelled_sample(tilted):
    heights = np.array([1.0, 4.0, 8.0]) * 1e-3
    expected = EDGES[0] * EDGES[1] * (1.1 - 0.2 * heights / EDGES[2]) ** 2
    np.testing.assert_allclose(section_areas(tilted.levelled, heights), expected, rtol=2e-3)
    np.testing.assert_allclose(section_areas(tilted.tapered, heights), expected, rtol=2e-3)


def test_relief_is_the_plane_that_was_cut_and_can_be_scaled(tilted):
    places = tilted.cuboid.points[::17, :2]
    cut = EDGES[2] + SLOPE * places[:, 0]
    np.testing.assert_allclose(tilted.relief(places), cut, atol=1e-8)
    np.testing.assert_allclose(tilted.tilt_alone(places), cut, atol=1e-8)
    np.testing.assert_allclose(tilted.without_tilt(places), EDGES[2], atol=1e-8)
    np.testing.assert_allclose(
        tilted.scaled_relief(0.5)(places), EDGES[2] + 0.5 * SLOPE * places[:, 0], atol=1e-8
    )
    same = tilted.with_top(tilted.scaled_relief(1.0))
    np.testing.assert_allclose(same.points, tilted.real.points, atol=1e-9)
    top = tilted.cuboid_with_relief.points[tilted.cuboid.glued(0.0)]
    np.testing.assert_allclose(top[:, 2], EDGES[2] + SLOPE * top[:, 0], atol=1e-8)


def test_variants_of_each_mode(tilted):
    pressed, sheared = (
        variants(tilted, mode, 1e-3, EffectSettings()) for mode in ("compression", "shear")
    )
    assert set(pressed) - set(sheared) == {"gap_times_0.5", "gap_times_1"}
    assert set(sheared) - set(pressed) == {"bond_depth_0.5_mm", "bond_depth_2_mm"}
    summit = tilted.real.highest - EDGES[2]
    assert pressed["gap_times_1"].gap == pytest.approx(summit)
    assert pressed["gap_times_0.5"].gap == pytest.approx(0.5 * summit)
    edges = {name: np.ptp(sheared[name].mesh.points, axis=0) for name in sheared}
    assert edges["cuboid_to_highest_point"] == pytest.approx((*EDGES[:2], EDGES[2] + summit))
    assert edges["cuboid_of_top_area"] == pytest.approx((0.9 * 12e-3, 0.9 * 10e-3, 8e-3))
    volume = np.prod(edges["cuboid_of_volume"])
    heights = tilted.real.highest * (np.arange(50) + 0.5) / 50
    exact = section_areas(tilted.real, heights).mean() * tilted.real.highest
    assert volume == pytest.approx(exact, rel=2e-3)


def test_a_sample_lower_than_its_cuboid_leaves_no_gap():
    """As with a flat top whose boundary is shifted inwards."""
    cuboid = mesh_cuboid(*EDGES, 1e-3)
    lower = moved(cuboid, lambda x, y, z: (x, y, 0.99 * z))
    found = variants(Shape(lower, cuboid, IDEAL, 30.0), "compression", 1e-3, EffectSettings())
    assert found["gap_times_1"].gap == 0.0
    boundary = found["gap_times_1"].boundary("compression", ContactSettings())
    assert boundary.planes[1, 3] == pytest.approx(EDGES[2])


def test_a_platen_with_a_gap_meets_the_cuboid_late_and_glue_reaches_as_deep_as_it_is_told(tilted):
    contact = ContactSettings()
    late = Variant(tilted.cuboid, 0.0, gap=0.3e-3).boundary("compression", contact)
    assert late.planes[1, 3] == pytest.approx(EDGES[2] + 0.3e-3)
    held = [
        np.sum(Variant(tilted.cuboid, depth).boundary("shear", contact).held == 2)
        for depth in (0.0, 1.1e-3)
    ]
    assert held == [13 * 11, 13 * 11 + 2 * (12 + 10)]


TRAVEL = np.linspace(0.0, 1e-3, 11)


def family(scale):
    """Two modulus fractions whose curves differ in form, all forces scaled."""
    curves = np.stack([TRAVEL, TRAVEL * (1.0 + 400.0 * TRAVEL)])
    return ResponseCurves(np.array([0.2, 0.8]), TRAVEL, scale * curves)


FIT = {"mu_pa": 1000.0, "mu1_fraction": 0.6}


def test_bias_is_the_inverse_of_the_stiffness_of_the_model():
    found = {
        "real": family(1.0), "levelled": family(1.6), "tapered": family(1.8), "cuboid": family(2.0),
        "cuboid_with_relief": family(1.25), "relief_times_0.5": family(1.4),
    }  # fmt: skip
    table = group_bias({"S1": found}, {}, FIT, CalibrationSettings())
    assert (table["terms"] == 2).all()
    assert table["trusted"].all()
    bias = table.set_index(["sample_variant", "model_variant"])["bias_percent"]
    assert bias["real", "cuboid"] == pytest.approx(-50.0, abs=0.01)
    assert bias["real", "cuboid_with_relief"] == pytest.approx(-20.0, abs=0.01)
    assert bias["relief_times_0.5", "cuboid"] == pytest.approx(-30.0, abs=0.01)
    shares = shares_table(table.assign(group="S1", mode="shear")).iloc[0]
    assert shares["late_contact"] == pytest.approx(-37.5, abs=0.01)
    assert shares["late_contact_on_cuboid"] == pytest.approx(-30.0, abs=0.02)
    parts = shares[["late_contact", "outline", "areas"]].sum()
    assert parts == pytest.approx(shares["bias_percent"])


def test_a_test_without_a_variant_keeps_its_plain_one():
    pressed = {"real": family(1.0), "cuboid": family(2.0), "gap_times_1": family(1.0)}
    pulled = {"real": family(1.0), "cuboid": family(1.0)}
    table = group_bias({"T1": pulled, "C1": pressed}, {"C1": pressed}, FIT, CalibrationSettings())
    bias = table.set_index(["terms", "model_variant"])["bias_percent"]
    assert bias[2, "gap_times_1"] == pytest.approx(0.0, abs=0.01)
    assert bias[1, "cuboid"] == pytest.approx(-50.0, abs=0.01)
    assert -50.01 < bias[2, "cuboid"] < -1.0


def test_experiments_start_with_the_study_and_change_one_side():
    pairs = experiments(["real", "levelled", "tapered", "cuboid", "gap_times_1", "tilt_alone"])
    assert pairs == [
        ("real", "cuboid"), ("real", "levelled"), ("real", "tapered"), ("real", "gap_times_1"),
        ("levelled", "cuboid"), ("tilt_alone", "cuboid"),
    ]  # fmt: skip
    assert spoken("relief_times_0.75", "cuboid") == "sample: relief times 0.75"
    assert all(spoken(*pair) for pair in pairs)


def test_families_of_a_table_are_split_by_their_terms():
    rows = [
        {"variant": "real", "mu1_fraction": r, "displacement": d, "force_per_mu": r * d}
        for r in (0.2, 0.8, 1.0)
        for d in (0.0, 1.0)
    ]
    two_term, one_term = families(pd.DataFrame(rows))
    # the first term alone is the end of the two-term range too
    assert two_term["real"].bounds == (0.2, 1.0)
    assert one_term["real"].bounds == (1.0, 1.0)
    assert one_term["real"].force_per_mu(1.0, np.array([0.5])) == pytest.approx(0.5)


def biases():
    plain = [("S1", -4.0), ("S2", -8.0)]
    rows = [(group, "real", "cuboid", bias) for group, bias in plain]
    rows += [(group, "levelled", "cuboid", 0.0) for group, _ in plain]
    rows += [(group, "relief_times_2", "cuboid", 2.0 * bias) for group, bias in plain]
    columns = ["group", "sample_variant", "model_variant", "bias_percent"]
    return pd.DataFrame(rows, columns=columns).assign(terms=2, mode="shear", trusted=True)


def test_effects_are_means_over_groups_and_changes_against_the_study():
    table = effects_table(biases()).set_index("sample_variant")
    assert table.loc["real", "bias_percent"] == -6.0
    assert table.loc["real", "change_percent_of_mu"] == 0.0
    assert table.loc["relief_times_2", "change_percent_of_mu"] == -6.0
    assert table.loc["relief_times_2", "change_sd_percent_of_mu"] == pytest.approx(np.sqrt(8.0))
    assert table["count"].tolist() == [2, 2, 2]


def test_the_cohort_needed_lies_between_the_reliefs_tried():
    paper = pd.DataFrame(
        {"quantity": ["modulus_two_term"], "mode": ["shear"], "mean_percent": [-9.0]}
    )
    needed = needed_table(effects_table(biases()), 1.0, {"shear": [0.4, 0.6]}, paper).iloc[0]
    assert needed["relief_factor"] == pytest.approx(1.5)
    assert needed["summit_needed_mm"] == pytest.approx(0.75)
    assert np.isnan(needed["bond_depth_needed_mm"])  # no other depth was tried
    nothing = needed_table(effects_table(biases()), 1.0, {}, paper.iloc[:0])
    assert nothing.empty
    assert list(nothing) == list(needed.index)  # so that its file can be read again


def test_a_target_out_of_reach_has_no_crossing():
    assert np.isnan(crossing({0.0: 0.0, 1.0: -1.0, 2.0: -2.0}, -3.0))
    assert crossing({0.0: 0.0, 1.0: -1.0, 2.0: -2.0}, -0.5) == pytest.approx(0.5)


def test_a_run_that_fails_is_tried_with_less_travel():
    def simulate(way):
        if way > 0.87:
            raise SimulationError("inverted")
        return way

    assert as_far_as_it_goes(simulate, 1.0) == pytest.approx(0.85)
    with pytest.raises(SimulationError, match="inverted"):
        as_far_as_it_goes(simulate, 2.0)


def test_agreement_ends_where_the_curves_part():
    strain = np.linspace(0.0, 0.3, 31)
    contact = 10.0 * strain
    prescribed = contact * (1.0 - 0.5 * np.clip(strain - 0.2, 0.0, None))
    assert agreement(strain, contact, prescribed, 0.02) == pytest.approx(0.24, abs=1e-6)
    assert agreement(strain, contact, contact, 0.02) == pytest.approx(0.3)
    assert agreement(strain, contact, 1.1 * contact, 0.02) == 0.0
    curve = pd.DataFrame({"strain": strain, "contact_N": contact, "prescribed_N": prescribed})
    row = prescribed_table({("C1", "ideal"): curve}).iloc[0]
    assert row["agrees_5_percent_strain"] == pytest.approx(0.3)
    assert row["at_paper_strain_percent"] == pytest.approx(0.0, abs=1e-9)
    assert row["at_end_percent"] == pytest.approx(-5.0)
