"""Material cards: a cube of each is deformed, or read, and has the stress of the closed form."""

import shutil
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from peers import read_calculix_forces
from softsample.constitutive.material import Material, Relaxation, Term
from softsample.constitutive.ogden import OgdenMaterial
from softsample.errors import InputError
from softsample.export.cards import write_card
from spectral import stress


def one(law, *shape, nu=0.45):
    return Material((Term(law, 900.0, shape),), nu)


NEO_HOOKE, FIBRE = one("neo_hooke"), Term("fibre", 400.0, (2.0, 0.1, 0.0), (0.3, -0.5, 0.8))
MATERIALS = {
    "two terms": OgdenMaterial((1196.8, 113.1), (-8.0, 16.0), 0.49),
    "one term": OgdenMaterial((900.0,), (-8.0,), 0.49),
    "neo_hooke": NEO_HOOKE,
    "mooney_rivlin": one("mooney_rivlin", 0.6),
    "yeoh": one("yeoh", 2.0, 5.0),
    "polynomials": NEO_HOOKE.plus(Term("yeoh", 200.0, (3.0, 0.0))),
    "cork": one("foam", 8.0, 0.0),
}
"""What all programs have."""
FOAMS = {
    "foam": one("foam", -8.0, 0.3),
    "foams": one("foam", 8.0, 0.25).plus(Term("foam", 300.0, (-4.0, 0.1))),
}
OF_FEBIO = {"gent": one("gent", 0.8), "fibre": NEO_HOOKE.plus(FIBRE)}
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
@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX")
@pytest.mark.parametrize("name", MATERIALS | FOAMS)
@pytest.mark.parametrize("mode", DEFORMATIONS)
def test_calculix_meets_the_closed_form_with_the_card(tmp_path, name, mode):
    material, deformation = (MATERIALS | FOAMS)[name], DEFORMATIONS[mode]
    write_card(tmp_path / "card.inp", material, "calculix", "a test")
    (tmp_path / "cube.inp").write_text(cube_input(deformation) + "\n")
    run = subprocess.run(["ccx", "cube"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout[-2000:]
    _, force = read_calculix_forces(tmp_path / "cube.dat")
    traction = 1e-6 * stress(deformation, material)[:, 2]  # N on 1 mm2 of normal z
    np.testing.assert_allclose(force[-1], traction, atol=1e-5 * np.abs(traction).max())


def test_abaqus_gets_the_same_numbers_as_calculix(tmp_path):
    texts = []
    for program in ("abaqus", "calculix"):
        write_card(tmp_path / "card.inp", MATERIALS["two terms"], program, "a test")
        texts.append((tmp_path / "card.inp").read_text().splitlines())
        assert program in texts[-1][0]
        assert "0.0013099 MPa" in texts[-1][2]
    assert texts[0][3:] == texts[1][3:]


def test_abaqus_gets_foam_as_one_term(tmp_path):
    write_card(tmp_path / "card.inp", FOAMS["foam"], "abaqus", "a test")
    lines = (tmp_path / "card.inp").read_text().splitlines()
    assert lines[-2:] == ["*HYPERFOAM, N=1", "0.0009, -8, 0.3"]
    assert "Poisson's ratio 0.3." in lines[2]


def of_febio(card, deformation):
    """Cauchy stress [MPa] by the formulas of FEBio's manual and sources, from a card's numbers."""

    def number(name):
        return float(card.findtext(name) or 0.0)

    J = np.linalg.det(deformation)
    left, stretches, _ = np.linalg.svd(deformation)
    dyads = [np.outer(left[:, a], left[:, a]) for a in range(3)]
    if card.get("type") == "Ogden unconstrained":
        assert card.find("k") is None
        principal = number("cp") * (J - 1.0) + sum(
            number(f"c{n}") / number(f"m{n}") * (stretches ** number(f"m{n}") - 1.0) / J
            for n in range(1, 7)
            if number(f"m{n}")
        )
        return sum(s * dyad for s, dyad in zip(principal, dyads, strict=True))
    assert number("pressure_model") == 2
    isochoric = J ** (-1.0 / 3.0) * deformation
    b = isochoric @ isochoric.T
    x = np.trace(b) - 3.0
    match card.get("type"):
        case "Ogden":
            tau = np.zeros((3, 3))
            for n in range(1, 7):
                if number(f"m{n}"):
                    power = (J ** (-1.0 / 3.0) * stretches) ** number(f"m{n}")
                    factor = number(f"c{n}") / number(f"m{n}")
                    tau += sum(factor * q * dyad for q, dyad in zip(power, dyads, strict=True))
        case "Mooney-Rivlin":
            first, second = number("c1"), number("c2")
            tau = 2.0 * ((first + second * (x + 3.0)) * b - second * b @ b)
        case "Yeoh":
            tau = 2.0 * sum((n + 1) * number(f"c{n + 1}") * x**n for n in range(3)) * b
        case "Gent":
            tau = number("G") * number("Jm") / (number("Jm") - x) * b
        case "Holzapfel-Gasser-Ogden":
            tau = number("c") * b + _families(card, number, isochoric, b, x)
    deviator = tau - np.trace(tau) / 3.0 * np.eye(3)
    return deviator / J + number("k") * (J - 1.0) * np.eye(3)


def _families(card, number, isochoric, b, x):
    """Two families in the plane of a and d, at angles of +-gamma to a."""
    a, d = (np.array(card.findtext(f"mat_axis/{v}").split(","), float) for v in "ad")
    first = a / np.linalg.norm(a)
    third = np.cross(first, d)
    second = np.cross(third / np.linalg.norm(third), first)
    angle, kappa, total = np.radians(number("gamma")), number("kappa"), 0.0
    for sign in (1.0, -1.0):
        along = isochoric @ (np.cos(angle) * first + sign * np.sin(angle) * second)
        strain = kappa * x + (1.0 - 3.0 * kappa) * (along @ along - 1.0)
        if strain >= 0.0:
            pull = 2.0 * number("k1") * strain * np.exp(number("k2") * strain**2)
            total = total + pull * (kappa * b + (1.0 - 3.0 * kappa) * np.outer(along, along))
    return total


@pytest.mark.parametrize("name", MATERIALS | OF_FEBIO)
@pytest.mark.parametrize("mode", DEFORMATIONS)
def test_febio_has_the_same_stress_by_its_own_formula(tmp_path, name, mode):
    material, deformation = (MATERIALS | OF_FEBIO)[name], DEFORMATIONS[mode]
    write_card(tmp_path / "card.xml", material, "febio", "a test")
    cauchy = of_febio(ET.parse(tmp_path / "card.xml").getroot(), deformation)
    nominal = np.linalg.det(deformation) * cauchy @ np.linalg.inv(deformation).T
    expected = 1e-6 * stress(deformation, material)
    np.testing.assert_allclose(nominal, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("material", "program", "why"),
    [
        (OF_FEBIO["gent"], "abaqus", r"Gent cannot be written for abaqus: it has Ogden terms"),
        (OF_FEBIO["fibre"], "calculix", r"Neo-Hooke \+ Fibres .* for calculix: it has Ogden terms"),
        (one("exponential_i1", 3.0), "febio", r"Exponential in I1 .* febio: it has Ogden terms"),
        (OgdenMaterial((1.0,) * 4, (2.0, 3.0, 4.0, 5.0)), "calculix", "it has up to 3 terms"),
        (OgdenMaterial((1.0, 1.0), (2.0, 0.0)), "febio", "it has no exponent 0"),
        (one("yeoh", 1.0, 1.0).plus(Term("mooney_rivlin", 1.0, (0.5,))), "abaqus", "no second inv"),
        (one("yeoh", 1.0, 1.0).plus(Term("mooney_rivlin", 1.0, (0.5,))), "febio", "no second inv"),
        (FOAMS["foam"], "febio", "its foam is another one, unless Poisson's ratio is 0"),
        (one("gent", 1.0).plus(Term("gent", 1.0, (2.0,))), "febio", "it has one term of Gent"),
        (OF_FEBIO["fibre"].plus(FIBRE), "febio", "one direction of fibres, which buckle"),
        *(
            (replace(MATERIALS["two terms"], relaxation=Relaxation((0.3,), (5.0,))), program, why)
            for program, why in (("calculix", "this solid relaxes"), ("febio", "solid relaxes"))
        ),
    ],
)
def test_a_law_that_a_program_does_not_have_is_refused(tmp_path, material, program, why):
    with pytest.raises(InputError, match=why):
        write_card(tmp_path / "card", material, program, "a test")
    assert not (tmp_path / "card").exists()


def test_a_card_for_an_unknown_program_is_refused(tmp_path):
    with pytest.raises(InputError, match="no program 'ansys'; there are abaqus, calculix, febio"):
        write_card(tmp_path / "a", MATERIALS["one term"], "ansys", "a test")
