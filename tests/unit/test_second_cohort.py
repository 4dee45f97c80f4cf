"""The generator of the second virtual cohort, and what it made."""

import json

import nibabel
import numpy as np
import pandas as pd
import pytest

import second_cohort
from phantom.sizes import measured
from templates import recovered

COHORT = second_cohort.COHORT
SAMPLES = {sample.name: sample for sample in second_cohort.samples()}


def truth(name):
    return json.loads((COHORT / "truth" / f"{name}.json").read_text(encoding="utf-8"))


def test_images_are_those_of_the_seeds():
    sample = SAMPLES["S3"]
    made, affine = sample.scan.image(sample.shape)
    kept = nibabel.load(COHORT / "images" / "S3.nii.gz")
    np.testing.assert_array_equal(np.asanyarray(kept.dataobj), made)
    np.testing.assert_allclose(kept.affine, affine, atol=1e-5)


@pytest.mark.parametrize("name", SAMPLES)
def test_truth_is_that_of_the_seeds(name):
    sample, found = SAMPLES[name], truth(name)
    assert found["mode"] == sample.mode
    assert found["shape"]["edge"] == sample.shape.edge
    assert (found["material"]["mu1_Pa"], found["material"]["mu2_Pa"]) == sample.moduli
    assert tuple(found["material"]["alpha"]) == sample.exponents


@pytest.mark.parametrize("name", SAMPLES)
def test_records_stay_within_the_load_cell(name):
    record = pd.read_csv(COHORT / "records" / f"{name}.csv")
    assert record["force_N"].abs().max() < second_cohort.CELL_N
    least = second_cohort.LEAST * second_cohort.TRAVEL_MM[SAMPLES[name].mode]
    assert truth(name)["max_travel_mm"] == record["displacement_mm"].abs().max() > least
    assert np.sign(record["force_N"].iloc[-1]) == (-1 if name.startswith("C") else 1)


def test_animals_differ_and_every_mode_has_sharp_and_round_rims():
    assert len({sample.exponents for sample in SAMPLES.values()}) == 10
    for mode in "STC":
        rims = sorted(s.shape.edge for name, s in SAMPLES.items() if name.startswith(mode))
        assert rims == sorted(second_cohort.EDGES_MM)


@pytest.fixture(scope="module")
def mesh():
    return second_cohort.mesh_of(SAMPLES["C1"].shape)


def test_grid_fills_the_shape(mesh):
    sizes = measured(SAMPLES["C1"].shape, 0.2)
    assert second_cohort.volume(mesh) == pytest.approx(sizes.volume, rel=5e-3)
    assert mesh.points[:, 2].max() == pytest.approx(sizes.highest, abs=0.02)
    skin = mesh.points[np.setdiff1d(mesh.skin, mesh.base)]
    assert np.abs(SAMPLES["C1"].shape.value(*skin.T)).max() < 1e-3


def test_no_corner_is_turned_inside_out(mesh):
    corners = mesh.points[mesh.elements]
    for k, ends in enumerate(
        [(1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)]
    ):
        sides = np.stack([corners[:, end] - corners[:, k] for end in ends], axis=1)
        assert np.linalg.det(sides).min() > 0.0


def test_a_closed_skin_projects_onto_its_base(mesh):
    everything = np.ones(len(mesh.points), dtype=bool)
    base = measured(SAMPLES["C1"].shape, 0.2).bottom_area
    assert second_cohort.projected_area(mesh, everything) == pytest.approx(base, rel=5e-3)


def test_an_interval_may_be_open():
    assert recovered(-7.26, -7.352, -7.461, None) == "-7.26, -7.35 (-7.46 to open)"
