"""Input of Abaqus and CalculiX for a test."""

from collections.abc import Iterable, Iterator

import numpy as np

from softsample.arrays import Array, Ids
from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.export.laws import family, polynomial, powers, refuse
from softsample.export.model import MPA, Plate, StaticTest
from softsample.fem.boundary import Boundary
from softsample.io import PathLike, write_text
from softsample.meshing.mesh import HexMesh
from softsample.units import MM

MOST_TERMS = {"abaqus": 6, "calculix": 3}
"""Largest N of Ogden solids and foams."""

PROGRAMS = tuple(MOST_TERMS)

ABSENT = 1e12
"""D_i [1/MPa] of an absent volumetric term; CalculiX would replace zero by a default."""

ROUGH = 100.0
"""Coefficient of friction in CalculiX, which has no rough contact: no slip below this ratio."""

TENSION = 1e-10
"""Tension of an open contact in CalculiX, over contact stiffness times 1 mm: none to speak of."""


def write_abaqus(
    path: PathLike,
    mesh: HexMesh,
    material: Material,
    boundary: Boundary,
    travel: float,
    *,
    program: str = "abaqus",
    increments: int = 20,
) -> None:
    """Write a static test as input of Abaqus/Standard or CalculiX, atomically.

    Parameters
    ----------
    path
        Target, ending in `.inp`.
    mesh : HexMesh
        Reference configuration [m].
    material : Material
        Moduli [Pa]; Ogden terms, polynomials in the invariants or foams, ``D_1 = 2/K``.
    boundary : Boundary
        Fixed base; nodes glued to the moving platen, or a platen or ball that free nodes can
        touch, with any friction.
    travel : float
        Travel of the moving platen [m], > 0, in proportion to the step's time from 0 to 1.
    program : str
        `abaqus` or `calculix`, which differ in contact and in requests of output.
    increments : int
        Smallest number of increments.

    Raises
    ------
    InputError
        On an unknown program, a law that it does not have, a travel that is not positive, or if
        nothing moves.

    Notes
    -----
    What moves is the node set BONDED or PLATEN; the sum of its reactions is printed. A platen is
    made of elements with every node prescribed, which needs no rigid body and is the same in both
    programs. In torsion BONDED is a rigid body that turns about its node AXIS; CalculiX takes the
    angle at, and prints the torque of, a node TURN. CalculiX can always let go of a platen. What
    was run: ``docs/export.md``.

    References
    ----------
    Abaqus Analysis User's Guide, *Hyperelastic behavior of rubberlike materials*; G. Dhondt,
    *CalculiX CrunchiX User's Manual*, version 2.20, *Ogden* and *Contact*.
    """
    if program not in PROGRAMS:
        raise InputError(f"no program {program!r}; there are {', '.join(PROGRAMS)}")
    test = StaticTest(mesh, material, boundary, travel)
    lines = [
        *(f"** {line}" for line in test.header),
        f"** Input of {program}; elements C3D8R.",
        *_sample(test, program),
        *_plates(test),
        *_contact(test, program),
        *_turned_body(test, program),
        "*BOUNDARY",
        "BASE, 1, 3",
        *(f"{plate.name}, 1, 3" for plate in test.plates if not plate.moves),
        f"*STEP, NLGEOM=YES, INC={100 * increments}",
        "*STATIC",
        f"{1.0 / increments:.10g}, 1.0, 1e-6, {1.0 / increments:.10g}",
        "*BOUNDARY",
        *_motion(test, program),
        *_output(test, program),
        "*END STEP",
    ]
    write_text(path, "\n".join(lines) + "\n")


def _sample(test: StaticTest, program: str) -> Iterator[str]:
    """Nodes, elements, sets and material of the sample."""
    yield "*NODE, NSET=SAMPLE"
    yield from _nodes(test.points, 0)
    yield "*ELEMENT, TYPE=C3D8R, ELSET=SAMPLE"
    yield from _elements(test.mesh.hexes, 0)
    for name, ids in test.sets.items():
        yield f"*NSET, NSET={name}"
        yield from _rows(ids + 1, 16)
    yield from material_lines(test.material, program)
    yield "*SOLID SECTION, ELSET=SAMPLE, MATERIAL=TISSUE"


def material_lines(material: Material, program: str) -> Iterator[str]:
    """The material TISSUE [MPa].

    Raises
    ------
    InputError
        If the program has no such law.
    """
    cards = {"ogden": _ogden, "polynomial": _polynomial, "foam": _foam}
    card = cards.get(family(material, program) or "")
    if card is None:
        refuse(material, program, "it has Ogden terms, polynomials in I1 and I2, or foams")
    yield "*MATERIAL, NAME=TISSUE"
    yield from card(material, program)


def _compliance(material: Material, terms: int) -> list[float]:
    """D_i [1/MPa] of the volumetric energy sum (J - 1)^(2i) / D_i."""
    return [2.0 * MPA / material.volumetric_modulus] + [ABSENT] * (terms - 1)


def _ogden(material: Material, program: str) -> Iterator[str]:
    terms = powers(material, program, "ogden", MOST_TERMS[program])
    constants = [x for term in terms for x in (term.modulus / MPA, term.shape[0])]
    yield f"*HYPERELASTIC, OGDEN, N={len(terms)}"
    yield from _rows([*constants, *_compliance(material, len(terms))], 8)


def _polynomial(material: Material, program: str) -> Iterator[str]:
    c10, c01, c20, c30 = (c / MPA for c in polynomial(material))
    if c20 == c30 == 0.0:
        yield "*HYPERELASTIC, MOONEY-RIVLIN" if c01 else "*HYPERELASTIC, NEO HOOKE"
        yield from _rows([c10, *([c01] if c01 else []), *_compliance(material, 1)], 8)
    elif c01 == 0.0:
        yield "*HYPERELASTIC, YEOH"
        yield from _rows([c10, c20, c30, *_compliance(material, 3)], 8)
    else:
        refuse(material, program, "its Yeoh solid has no second invariant")


def _foam(material: Material, program: str) -> Iterator[str]:
    """CalculiX 2.20 makes no force of one term: it gets two halves."""
    terms = powers(material, program, "foam", MOST_TERMS[program])
    parts = 2 if program == "calculix" and len(terms) == 1 else 1
    terms = parts * terms
    constants = [x for term in terms for x in (term.modulus / parts / MPA, term.shape[0])]
    yield f"*HYPERFOAM, N={len(terms)}"
    yield from _rows([*constants, *(term.shape[1] for term in terms)], 8)


def _plates(test: StaticTest) -> Iterator[str]:
    """Platens after the nodes and elements of the sample; their stiffness does not matter."""
    nodes, elements = len(test.mesh.points), len(test.mesh.hexes)
    for plate in test.plates:
        yield f"*NODE, NSET={plate.name}"
        yield from _nodes(plate.body.points, nodes)
        yield f"*ELEMENT, TYPE=C3D8, ELSET={plate.name}"
        yield from _elements(nodes + plate.body.hexes, elements)
        yield f"*SURFACE, NAME={plate.name}FACE, TYPE=ELEMENT"
        yield f"{plate.name}, {'S1' if plate.moves else 'S2'}"
        yield f"*SOLID SECTION, ELSET={plate.name}, MATERIAL=PLATE"
        nodes += len(plate.body.points)
        elements += len(plate.body.hexes)
    if test.plates:
        yield "*MATERIAL, NAME=PLATE"
        yield "*ELASTIC"
        yield "1.0, 0.3"


def _contact(test: StaticTest, program: str) -> Iterator[str]:
    """Contact between the free nodes and the platens."""
    if not test.plates:
        return
    yield "*SURFACE, NAME=FREENODES, TYPE=NODE"
    yield "FREE"
    for plate in test.plates:
        yield f"*CONTACT PAIR, INTERACTION={plate.name}CONTACT, TYPE=NODE TO SURFACE"
        yield f"FREENODES, {plate.name}FACE"
    for plate in test.plates:
        yield f"*SURFACE INTERACTION, NAME={plate.name}CONTACT"
        yield from _behaviour(test, plate, program)


def _behaviour(test: StaticTest, plate: Plate, program: str) -> Iterator[str]:
    """Pressure and friction of one contact."""
    rough = not np.isfinite(plate.friction)
    if program == "abaqus":
        if not test.boundary.release:
            yield "*SURFACE BEHAVIOR, NO SEPARATION"
        if rough:
            yield "*FRICTION, ROUGH"
        elif plate.friction:
            yield "*FRICTION"
            yield f"{plate.friction:.10g}"
        return
    # For a contact element made at first touch CalculiX measures slip from rest. Elements that
    # cover every gap from the start slip freely while open and stick once closed.
    everywhere = 4.0 * test.mesh.highest / test.mesh.edge_length
    yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
    yield f"{test.penalty:.10g}, {TENSION * test.penalty:.10g}, {everywhere:.10g}"
    if plate.friction:
        yield "*FRICTION"
        yield f"{ROUGH if rough else plate.friction:.10g}, {test.penalty:.10g}"


def _turned_body(test: StaticTest, program: str) -> Iterator[str]:
    """In torsion: what is glued is rigid, about a node on the axis at the height of the top."""
    if not test.angle:
        return
    axis = len(test.points) + 1
    names = ["AXIS"] if program == "abaqus" else ["AXIS", "TURN"]
    for number, name in enumerate(names, start=axis):
        yield f"*NODE, NSET={name}"
        yield f"{number}, 0, 0, {test.mesh.highest / MM:.10g}"
    if program == "abaqus":
        yield f"*RIGID BODY, REF NODE={axis}, TIE NSET=BONDED"
    else:
        yield f"*RIGID BODY, NSET=BONDED, REF NODE={axis}, ROT NODE={axis + 1}"


def _motion(test: StaticTest, program: str) -> Iterator[str]:
    """Prescribed displacements, or the angle, at the end of the step."""
    if not test.angle:
        moved = "PLATEN" if test.plates else "BONDED"
        for i, u in enumerate(test.displacement, start=1):
            yield f"{moved}, {i}, {i}, {u:.10g}"
    elif program == "abaqus":
        yield "AXIS, 1, 5"
        yield f"AXIS, 6, 6, {test.angle:.10g}"
    else:
        yield "AXIS, 1, 3"
        yield "TURN, 1, 2"
        yield f"TURN, 3, 3, {test.angle:.10g}"


def _output(test: StaticTest, program: str) -> Iterator[str]:
    """Requests: summed reactions of what moves, fields for the viewers."""
    moved = ["PLATEN" if test.plates else "BONDED"]
    if program == "abaqus":
        yield f"*NODE PRINT, NSET={'AXIS' if test.angle else moved[0]}, TOTALS=YES, SUMMARY=NO"
        yield "RF1, RF2, RF3" + (", RM1, RM2, RM3" if test.angle else "")
        yield "*OUTPUT, FIELD, VARIABLE=PRESELECT"
        return
    for name in ["TURN", "AXIS"] if test.angle else moved:
        yield f"*NODE PRINT, NSET={name}, TOTALS=ONLY"
        yield "RF"
    yield "*NODE FILE"
    yield "U"
    yield "*EL FILE"
    yield "S"


def _nodes(points: Array, first: int) -> Iterator[str]:
    """Lines of points (n, 3) [mm] after `first` nodes."""
    for number, (x, y, z) in enumerate(points, start=first + 1):
        yield f"{number}, {x:.10g}, {y:.10g}, {z:.10g}"


def _elements(hexes: Ids, first: int) -> Iterator[str]:
    """Lines of hexahedra (n, 8) after `first` elements; corners are counted as VTK counts them."""
    for number, corners in enumerate(hexes + 1, start=first + 1):
        yield ", ".join(map(str, (number, *corners)))


def _rows(values: Iterable[float], width: int) -> Iterator[str]:
    """Numbers, at most `width` a line."""
    words = [f"{value:.10g}" for value in values]
    for start in range(0, len(words), width):
        yield ", ".join(words[start : start + width])
