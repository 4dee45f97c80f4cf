"""Input of Abaqus and CalculiX for a test, and the forces that CalculiX prints."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.export.model import MPA, Array, StaticTest
from softsample.fem.boundary import Boundary
from softsample.io import PathLike, write_text
from softsample.meshing.mesh import HexMesh

PROGRAMS = ("abaqus", "calculix")

ABSENT = 1e12
"""D_i [1/MPa] of an absent volumetric term; CalculiX would replace zero by a default."""

FRICTION = 100.0
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
    element: str = "C3D8R",
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
        Moduli [Pa]; moduli and exponents pass as they are, ``D_1 = 2/K``.
    boundary : Boundary
        Fixed base; nodes glued to the moving platen, or platens that free nodes can touch.
    travel : float
        Travel of the moving platen [m], > 0, in proportion to the step's time from 0 to 1.
    program : str
        `abaqus` or `calculix`, which differ in contact and in requests of output.
    element : str
        Type of the sample's elements: C3D8R, C3D8, or (Abaqus alone) C3D8RH.
    increments : int
        Smallest number of increments.

    Raises
    ------
    InputError
        On an unknown program, a travel that is not positive, or if nothing moves.

    Notes
    -----
    What moves is the node set GLUED or PLATEN; the sum of its reactions is printed. A platen is
    one element with every node prescribed, which needs no rigid body and is the same in both
    programs. CalculiX can always let go of a platen. What was run: ``docs/export.md``.

    References
    ----------
    Abaqus Analysis User's Guide, *Hyperelastic behavior of rubberlike materials*; G. Dhondt,
    *CalculiX CrunchiX User's Manual*, version 2.20, *Ogden* and *Contact*.
    """
    if program not in PROGRAMS:
        raise InputError(f"no program {program!r}; there are {', '.join(PROGRAMS)}")
    test = StaticTest(mesh, material, boundary, travel)
    moved = "PLATEN" if test.plates else "GLUED"
    lines = [
        *(f"** {line}" for line in test.header),
        f"** Input of {program}; elements {element}.",
        *_sample(test, element),
        *_plates(test),
        *_contact(test, program),
        "*BOUNDARY",
        "BASE, 1, 3",
        *(f"{plate.name}, 1, 3" for plate in test.plates if not plate.moves),
        f"*STEP, NLGEOM=YES, INC={100 * increments}",
        "*STATIC",
        f"{1.0 / increments:.10g}, 1.0, 1e-6, {1.0 / increments:.10g}",
        "*BOUNDARY",
        *(f"{moved}, {i}, {i}, {u:.10g}" for i, u in enumerate(test.displacement, start=1)),
        *_output(moved, program),
        "*END STEP",
    ]
    write_text(path, "\n".join(lines) + "\n")


def read_calculix_forces(path: PathLike) -> tuple[Array, Array]:
    """Forces that a run of CalculiX printed.

    Parameters
    ----------
    path
        The `.dat` file beside the input.

    Returns
    -------
    time : (n,) float64
        Fraction of the travel, from zero (at rest, not in the file) upwards.
    force : (n, 3) float64
        Force of what moves on the sample [N].

    Raises
    ------
    InputError
        If the file holds no forces: the run stopped in its first increment.
    """
    number = r"\s+([-+.\dE]+)"
    text = Path(path).read_text(encoding="utf-8")
    found = re.findall(rf"total force .* time{number}{number}{number}{number}", text)
    if not found:
        raise InputError(f"{path}: holds no forces; look for *ERROR in what CalculiX printed")
    table = np.array([[0.0] * 4, *found], dtype=np.float64)
    return table[:, 0], table[:, 1:]


def _sample(test: StaticTest, element: str) -> Iterator[str]:
    """Nodes, elements, sets and material of the sample."""
    yield "*NODE, NSET=SAMPLE"
    yield from _nodes(test.points, 0)
    yield f"*ELEMENT, TYPE={element}, ELSET=SAMPLE"
    yield from _elements(test.mesh.hexes, 0)
    for name, ids in test.sets.items():
        yield f"*NSET, NSET={name}"
        yield from _rows(ids + 1, 16)
    yield from material_lines(test.material)
    yield "*SOLID SECTION, ELSET=SAMPLE, MATERIAL=TISSUE"


def material_lines(material: Material) -> Iterator[str]:
    """The material TISSUE [MPa], which both programs define alike."""
    terms = np.column_stack([np.array(material.mu) / MPA, material.alpha]).ravel()
    volumetric = [2.0 * MPA / material.bulk_modulus] + [ABSENT] * (len(material.mu) - 1)
    yield "*MATERIAL, NAME=TISSUE"
    yield f"*HYPERELASTIC, OGDEN, N={len(material.mu)}"
    yield from _rows([*terms, *volumetric], 8)


def _plates(test: StaticTest) -> Iterator[str]:
    """Platens after the nodes and elements of the sample; their stiffness does not matter."""
    nodes, elements = len(test.mesh.points), len(test.mesh.hexes)
    for k, plate in enumerate(test.plates):
        first = nodes + 8 * k
        yield f"*NODE, NSET={plate.name}"
        yield from _nodes(plate.corners, first)
        yield f"*ELEMENT, TYPE=C3D8, ELSET={plate.name}"
        yield from _elements(first + np.arange(8)[None], elements + k)
        yield f"*SURFACE, NAME={plate.name}FACE, TYPE=ELEMENT"
        yield f"{elements + k + 1}, {'S1' if plate.moves else 'S2'}"
        yield f"*SOLID SECTION, ELSET={plate.name}, MATERIAL=PLATE"
    if test.plates:
        yield "*MATERIAL, NAME=PLATE"
        yield "*ELASTIC"
        yield "1.0, 0.3"


def _contact(test: StaticTest, program: str) -> Iterator[str]:
    """Rough contact between the free nodes and the platens."""
    if not test.plates:
        return
    yield "*SURFACE, NAME=FREENODES, TYPE=NODE"
    yield "FREE"
    for plate in test.plates:
        yield "*CONTACT PAIR, INTERACTION=ROUGH, TYPE=NODE TO SURFACE"
        yield f"FREENODES, {plate.name}FACE"
    yield "*SURFACE INTERACTION, NAME=ROUGH"
    if program == "abaqus":
        if not test.boundary.release:
            yield "*SURFACE BEHAVIOR, NO SEPARATION"
        yield "*FRICTION, ROUGH"
        return
    # For a contact element made at first touch CalculiX measures slip from rest. Elements that
    # cover every gap from the start slip freely while open and stick once closed.
    everywhere = 4.0 * test.mesh.highest / test.mesh.edge_length
    yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
    yield f"{test.penalty:.10g}, {TENSION * test.penalty:.10g}, {everywhere:.10g}"
    yield "*FRICTION"
    yield f"{FRICTION:.10g}, {test.penalty:.10g}"


def _output(moved: str, program: str) -> Iterator[str]:
    """Requests: summed reactions of what moves, fields for the viewers."""
    if program == "abaqus":
        yield f"*NODE PRINT, NSET={moved}, TOTALS=YES, SUMMARY=NO"
        yield "RF1, RF2, RF3"
        yield "*OUTPUT, FIELD, VARIABLE=PRESELECT"
    else:
        yield f"*NODE PRINT, NSET={moved}, TOTALS=ONLY"
        yield "RF"
        yield "*NODE FILE"
        yield "U"
        yield "*EL FILE"
        yield "S"


def _nodes(points: Array, first: int) -> Iterator[str]:
    """Lines of points (n, 3) [mm] after `first` nodes."""
    for number, (x, y, z) in enumerate(points, start=first + 1):
        yield f"{number}, {x:.10g}, {y:.10g}, {z:.10g}"


def _elements(hexes: NDArray[np.int64], first: int) -> Iterator[str]:
    """Lines of hexahedra (n, 8) after `first` elements; corners are counted as VTK counts them."""
    for number, corners in enumerate(hexes + 1, start=first + 1):
        yield ", ".join(map(str, (number, *corners)))


def _rows(values: Iterable[float], width: int) -> Iterator[str]:
    """Numbers, at most `width` a line."""
    words = [f"{value:.10g}" for value in values]
    for start in range(0, len(words), width):
        yield ", ".join(words[start : start + width])
