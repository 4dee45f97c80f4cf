"""The calibrated material alone, for models of a user's own: mm, N and MPa."""

import xml.etree.ElementTree as ET

from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.export.abaqus import material_lines
from softsample.export.febio import fill_tissue
from softsample.io import PathLike, write_text

CONVENTIONS = {
    "abaqus": "W = sum 2 mu_i/alpha_i^2 (sum lbar^alpha_i - 3) + sum (J - 1)^(2i)/D_i",
    "calculix": "W = sum 2 mu_i/alpha_i^2 (sum lbar^alpha_i - 3) + sum (J - 1)^(2i)/D_i",
    "febio": "W = sum c_i/m_i^2 (sum lbar^m_i - 3) + k/2 (J - 1)^2, so that c_i = 2 mu_i",
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
        On an unknown program.

    Notes
    -----
    ``tests/regression/test_cards.py`` deforms an element of the card in CalculiX and meets the
    closed form; the card of FEBio was checked against its manual, not run.
    """
    if program not in CONVENTIONS:
        raise InputError(f"no program {program!r}; there are {', '.join(CONVENTIONS)}")
    head = [
        f"Ogden material for {program}: {origin}.",
        f"Units: mm, N, MPa. {CONVENTIONS[program]}.",
        f"Initial shear modulus {1e-6 * material.shear_modulus:.6g} MPa, "
        f"Poisson's ratio {material.poisson_ratio:g}.",
    ]
    if program == "febio":
        tissue = ET.Element("material", id="1", name="tissue", type="Ogden")
        fill_tissue(tissue, material)
        ET.indent(tissue)
        comments = "".join(f"<!-- {line} -->\n" for line in head)
        write_text(path, f"{comments}{ET.tostring(tissue, 'unicode')}\n")
    else:
        lines = [*(f"** {line}" for line in head), *material_lines(material)]
        write_text(path, "\n".join(lines) + "\n")
