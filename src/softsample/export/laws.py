"""Which elastic laws a program has, and what its constants are."""

from typing import NoReturn

from softsample.constitutive.material import Material, Term
from softsample.errors import InputError

FAMILIES = {
    "ogden": {"ogden"},
    "polynomial": {"neo_hooke", "mooney_rivlin", "yeoh"},
    "foam": {"foam"},
    "gent": {"gent"},
    "fibre": {"neo_hooke", "fibre"},
}
"""Laws whose sums programs have as one material."""


def refuse(material: Material, program: str, why: str) -> NoReturn:
    """Say which laws a program does not have.

    Raises
    ------
    InputError
        Always.
    """
    names = " + ".join(term.rule.title for term in material.terms)
    raise InputError(
        f"{names} cannot be written for {program}: {why}; export another law that fits as well"
    )


def family(material: Material, program: str) -> str | None:
    """Which of `FAMILIES` a sum of laws belongs to, if any.

    Raises
    ------
    InputError
        If the material relaxes: what is written is elastic.
    """
    if material.relaxation:
        refuse(material, program, "what is written is elastic, and this solid relaxes")
    laws = {term.law for term in material.terms}
    return next((name for name, members in FAMILIES.items() if laws <= members), None)


def powers(material: Material, program: str, law: str, most: int) -> tuple[Term, ...]:
    """Terms with exponents, of which a program takes some, none zero.

    Raises
    ------
    InputError
        If there are more terms, or an exponent is zero.
    """
    terms = material.of_law(law)
    if len(terms) > most:
        refuse(material, program, f"it has up to {most} terms")
    if any(term.shape[0] == 0.0 for term in terms):
        refuse(material, program, "it has no exponent 0")
    return terms


def polynomial(material: Material) -> tuple[float, float, float, float]:
    """C10, C01, C20 and C30 [Pa] of a sum of the laws of the family `polynomial`."""
    c10 = c01 = c20 = c30 = 0.0
    for term in material.terms:
        half = 0.5 * term.modulus
        if term.law == "mooney_rivlin":
            c10, c01 = c10 + half * (1.0 - term.shape[0]), c01 + half * term.shape[0]
        else:
            c10 += half
        if term.law == "yeoh":
            c20, c30 = c20 + half * term.shape[0], c30 + half * term.shape[1]
    return c10, c01, c20, c30
