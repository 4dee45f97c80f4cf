"""What the inputs of all programs share: the test in mm, N and MPa, its sets and its platens."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.fem.boundary import Boundary
from softsample.fem.kernels import BASE, PLATEN
from softsample.io import MM
from softsample.meshing.mesh import HexMesh

Array = NDArray[np.float64]

MPA = 1e6
"""One megapascal [Pa]; with mm and N it makes a consistent system of units."""


@dataclass(frozen=True)
class Plate:
    """A rigid platen of contact: a block of one hexahedron, moved as a whole.

    Parameters
    ----------
    name : str
        Name of its sets and its body.
    corners : (8, 3) float64
        Corners [mm] in VTK order.
    moves : bool
        Whether it is the moving platen, which lies above the sample; the base lies below.
    """

    name: str
    corners: Array
    moves: bool

    @property
    def face(self) -> tuple[int, ...]:
        """Corners of the face that the sample meets, normal towards the sample."""
        return (0, 3, 2, 1) if self.moves else (4, 5, 6, 7)


@dataclass(frozen=True)
class StaticTest:
    """One static test as the programs see it; ids count from zero.

    Parameters
    ----------
    mesh : HexMesh
        Reference configuration [m].
    material : Material
        Moduli [Pa].
    boundary : Boundary
        Fixed base; nodes glued to the moving platen, or platens that free nodes can touch.
    travel : float
        Travel of the moving platen [m], > 0.

    Raises
    ------
    InputError
        If the travel is not positive, nothing is there to be moved, or ends slip.
    """

    mesh: HexMesh
    material: Material
    boundary: Boundary
    travel: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.travel) and self.travel > 0.0):
            raise InputError(f"the platen must travel, got {self.travel:g} m; check the record")
        if np.isfinite(self.boundary.friction).any() or self.boundary.confined:
            raise InputError("slip and walls are not exported; export a test of bonded ends")
        if "GLUED" not in self.sets and not any(plate.moves for plate in self.plates):
            raise InputError("no node is bonded and no platen can be touched; check the boundary")

    @property
    def points(self) -> Array:
        """(n_nodes, 3) nodes of the sample [mm]."""
        return self.mesh.points / MM

    @property
    def sets(self) -> dict[str, NDArray[Any]]:
        """Node sets that are not empty: BASE (fixed), GLUED (moved), FREE (may touch)."""
        held = self.boundary.held
        sets: dict[str, NDArray[Any]] = {
            "BASE": np.flatnonzero(held == BASE),
            "GLUED": np.flatnonzero(held == PLATEN),
            "FREE": self.boundary.candidates,
        }
        return {name: ids for name, ids in sets.items() if len(ids)}

    @property
    def displacement(self) -> Array:
        """(3,) final displacement of what moves [mm]."""
        return self.boundary.direction * self.travel / MM

    @cached_property
    def plates(self) -> list[Plate]:
        """Platens that free nodes can touch, as far as the sample is high beyond its sides."""
        found = []
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        reach = high[2] - low[2]
        (x0, y0), (x1, y1) = low[:2] - reach, high[:2] + reach
        ring = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
        for (*_, normal, offset), name in zip(
            self.boundary.planes, ("BASEPLATE", "PLATEN"), strict=True
        ):
            if np.isfinite(offset) and len(self.boundary.candidates):
                height = normal * offset / MM
                levels = sorted((height, height + normal * reach / 4.0))
                corners = np.array([(x, y, z) for z in levels for x, y in ring])
                found.append(Plate(name, corners, moves=normal > 0.0))
        return found

    @property
    def penalty(self) -> float:
        """Contact stiffness [N/mm3], a hundred times that of an element: no gap to be seen."""
        return 100.0 * self.material.bulk_modulus / MPA / (self.mesh.edge_length / MM)

    @property
    def header(self) -> list[str]:
        """Lines for the head of a file."""
        along = ", ".join(f"{u:.6g}" for u in self.displacement)
        return [
            "Test of a soft tissue sample. Consistent units: mm, N, MPa (N/mm2).",
            f"Base plane z = 0, loading axis z; what moves is displaced by ({along}) mm.",
        ]
