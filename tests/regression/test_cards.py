"""Material cards: a cube of each is deformed, or read, and has the stress of the closed form."""

import shutil
import subprocess
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from softsample.constitutive.material import stress as ogden_stress
from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import InputError
from softsample.export.abaqus import read_calculix_forces
from softsample.export.cards import write_card

MATERIALS = {
    "two terms": OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49),
    "one term": OgdenMaterial((900.0,), (-8.0,), 0.49),
}
DEFORMATIONS = {
    "compression": np.diag([1.15, 1.12, 0.75]),
    "tension": np.diag([0.9, 0.93, 1.25]),
    "shear": np.array([[1.0, 0.0, 0.3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}
CUBE = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)


def cube_input(deformation):
    """One cube of 1 mm whose corners all follow a gradient; forces of its top are printed."""
    moved = CUBE @ (deformation - np.eye(3)).T
    return "\n".join(
        [
            "*NODE, NSET=ALL",
            *(f"{n}, {x:g}, {y:g}, {z:g}" for n, (x, y, z) in enumerate(CUBE, start=1)),
            "*ELEMENT, TYPE=C3D8, ELSET=CUBE",
            "1, 1, 2, 3, 4, 5, 6, 7, 8",
            "*NSET, NSET=TOP",
            "5, 6, 7, 8",
            "*INCLUDE, INPUT=card.inp",
            "*SOLID SECTION, ELSET=CUBE, MATERIAL=TISSUE",
            "*STEP, NLGEOM=YES",
            "*STATIC",
            "0.25, 1.0",
            "*BOUNDARY",
            *(f"{n}, {i}, {i}, {u:.10g}" for n, row in enumerate(moved, start=1)
              for i, u in enumerate(row, start=1)),
            "*NODE PRINT, NSET=TOP, TOTALS=ONLY",
            "RF",
            "*END STEP",
        ]
    )  # fmt: skip


@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX")
@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("mode", DEFORMATIONS)
def test_calculix_meets_the_closed_form_with_the_card(tmp_path, name, mode):
    material, deformation = MATERIALS[name], DEFORMATIONS[mode]
    write_card(tmp_path / "card.inp", material, "calculix", "a test")
    (tmp_path / "cube.inp").write_text(cube_input(deformation) + "\n")
    run = subprocess.run(["ccx", "cube"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout[-2000:]
    _, force = read_calculix_forces(tmp_path / "cube.dat")
    traction = 1e-6 * ogden_stress(deformation, material)[:, 2]  # N on 1 mm2 of normal z
    np.testing.assert_allclose(force[-1], traction, atol=1e-5 * np.abs(traction).max())


def test_abaqus_gets_the_same_numbers_as_calculix(tmp_path):
    texts = []
    for program in ("abaqus", "calculix"):
        write_card(tmp_path / "card.inp", MATERIALS["two terms"], program, "a test")
        texts.append((tmp_path / "card.inp").read_text().splitlines())
        assert program in texts[-1][0]
        assert "0.0013099 MPa" in texts[-1][2]
    assert texts[0][3:] == texts[1][3:]


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("mode", DEFORMATIONS)
def test_febio_has_the_same_stress_by_its_own_formula(tmp_path, name, mode):
    """Principal stresses of FEBio's uncoupled Ogden solid, as its manual writes them."""
    material, deformation = MATERIALS[name], DEFORMATIONS[mode]
    write_card(tmp_path / "card.xml", material, "febio", "a test")
    card = ET.parse(tmp_path / "card.xml").getroot()
    assert card.get("type") == "Ogden"
    assert card.findtext("pressure_model") == "2"
    left, stretches, _ = np.linalg.svd(deformation)
    volume = np.prod(stretches)
    isochoric = stretches * volume ** (-1.0 / 3.0)
    stress = np.full(3, float(card.findtext("k")) * (volume - 1.0))
    for term in range(1, len(material.mu) + 1):
        c, m = (float(card.findtext(f"{letter}{term}")) for letter in "cm")
        power = isochoric**m
        stress += c / m * (power - power.mean()) / volume
    cauchy = left @ np.diag(stress) @ left.T
    nominal = volume * cauchy @ np.linalg.inv(deformation).T
    expected = 1e-6 * ogden_stress(deformation, material)
    np.testing.assert_allclose(nominal, expected, atol=1e-9 * np.abs(expected).max())


def test_a_card_for_an_unknown_program_is_refused(tmp_path):
    with pytest.raises(InputError, match="no program 'ansys'; there are abaqus, calculix, febio"):
        write_card(tmp_path / "a", MATERIALS["one term"], "ansys", "a test")
