"""The calibrated material alone, for models of a user's own: mm, N and MPa."""

import xml.etree.ElementTree as ET

from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.export.abaqus import material_lines
from softsample.export.febio import fill_tissue
from softsample.export.laws import family
from softsample.io import PathLike, write_text

ABAQUS = {
    "ogden": "W = sum 2 mu_i/alpha_i^2 (sum lbar^alpha_i - 3) + sum (J - 1)^(2i)/D_i",
    "polynomial": "W = C10 (I1 - 3) + C01 (I2 - 3) + C20 (I1 - 3)^2 + C30 (I1 - 3)^3 + "
    "sum (J - 1)^(2i)/D_i, so that mu = 2 (C10 + C01)",
    "foam": "W = sum 2 mu_i/alpha_i^2 (sum l^alpha_i - 3 + (J^(-alpha_i beta_i) - 1)/beta_i), "
    "beta_i = nu_i/(1 - 2 nu_i)",
}

CONVENTIONS = {
    "abaqus": ABAQUS,
    "calculix": ABAQUS,
    "febio": {
        "ogden": "W = sum c_i/m_i^2 (sum lbar^m_i - 3) + k/2 (J - 1)^2, so that c_i = 2 mu_i",
        "polynomial": "W = c1 (I1 - 3) + c2 (I2 - 3) + k/2 (J - 1)^2; in Yeoh's solid c2 and c3 "
        "are of (I1 - 3)^2 and ^3",
        "foam": "W = sum c_i/m_i^2 (sum l^m_i - 3 - m_i ln J), so that c_i = 2 mu_i",
        "gent": "W = -G Jm/2 ln(1 - (I1 - 3)/Jm) + k/2 (J - 1)^2",
        "fibre": "W = c/2 (I1 - 3) + k/2 (J - 1)^2 + two equal families of fibres with "
        "k1/(2 k2) (exp(k2 E^2) - 1) where E = kappa (I1 - 3) + (1 - 3 kappa)(I4 - 1) > 0",
    },
}
"""Strain energy of each program, in terms of what its card holds."""


def write_card(path: PathLike, material: Material, program: str, origin: str) -> None:
    """Write a material as a part of a program's input, atomically.

    Parameters
    ----------
    path
        Target; `.inp` to be included by `*INCLUDE` (Abaqus, CalculiX), `.xml` for the section
        `Material` of FEBio.
    material : Material
        Moduli [Pa]; the card has MPa. Its name is TISSUE, the number in FEBio 1.
    program : str
        `abaqus`, `calculix` or `febio`.
    origin : str
        One line that says where the moduli are from.

    Raises
    ------
    InputError
        On an unknown program, a law that it does not have, or a material that relaxes.

    Notes
    -----
    ``tests/regression/test_cards.py`` deforms an element of the card in CalculiX and meets the
    closed form; the card of FEBio was checked against its manual, not run.
    """
    if program not in CONVENTIONS:
        raise InputError(f"no program {program!r}; there are {', '.join(CONVENTIONS)}")
    names = " + ".join(term.rule.title for term in material.terms)
    convention = CONVENTIONS[program].get(family(material, program) or "", "")
    mu, bulk = material.shear_modulus, material.bulk_modulus
    head = [
        f"{names} for {program}: {origin}.",
        f"Units: mm, N, MPa. {convention}.",
        f"Initial shear modulus {1e-6 * mu:.6g} MPa, "
        f"Poisson's ratio {(1.5 * bulk - mu) / (3.0 * bulk + mu):.6g}.",
    ]
    if program == "febio":
        tissue = ET.Element("material", id="1", name="tissue")
        fill_tissue(tissue, material)
        ET.indent(tissue)
        comments = "".join(f"<!-- {line} -->\n" for line in head)
        write_text(path, f"{comments}{ET.tostring(tissue, 'unicode')}\n")
    else:
        lines = [*(f"** {line}" for line in head), *material_lines(material, program)]
        write_text(path, "\n".join(lines) + "\n")
