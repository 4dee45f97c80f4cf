"""What the inputs of all programs share: the test in mm, N and MPa, its sets and its platens."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array, Ids
from softsample.constitutive.material import Material
from softsample.errors import InputError
from softsample.fem.boundary import Boundary
from softsample.fem.motion import BASE, PLATEN
from softsample.meshing.cylinder import disc_of, extruded
from softsample.meshing.mesh import HexMesh
from softsample.units import MM

MPA = 1e6
"""One megapascal [Pa]; with mm and N it makes a consistent system of units."""

CAP_REACH, CAP_RINGS = 0.9, 48
"""Part of a ball's radius up to which it is meshed, and rings of faces there: the faces lie within
5e-5 of the radius of the ball."""


@dataclass(frozen=True)
class Plate:
    """A rigid body that free nodes can touch: hexahedra that move as a whole.

    Parameters
    ----------
    name : str
        Name of its sets and its body.
    body : HexMesh
        Its shape [mm]; a moving platen meets the sample with the lower faces of its hexahedra,
        the base with the upper one.
    moves : bool
        Whether it is the moving platen or indenter, above the sample; the base lies below.
    friction : float
        Coefficient of Coulomb friction; infinite for no slip.
    """

    name: str
    body: HexMesh
    moves: bool
    friction: float

    @property
    def faces(self) -> Ids:
        """(m, 4) nodes of the faces that the sample meets, normals towards the sample."""
        return self.body.hexes[:, (0, 3, 2, 1) if self.moves else (4, 5, 6, 7)]


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
        Fixed base; nodes glued to the moving platen, which may turn; or a platen or ball that
        free nodes can touch.
    travel : float
        Travel of the moving platen [m], > 0; in torsion that of the rim.

    Raises
    ------
    InputError
        If the travel is not positive, nothing is there to be moved, the base slips or walls
        confine the sample.
    """

    mesh: HexMesh
    material: Material
    boundary: Boundary
    travel: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.travel) and self.travel > 0.0):
            raise InputError(f"the platen must move, got {self.travel:g} m; check the record")
        if np.isfinite(self.boundary.friction[0]) or self.boundary.confined:
            raise InputError(
                "a base that slips and walls are not exported; export a sample that is bonded to "
                "its base and has free sides, and change the ends in the other program"
            )
        if "BONDED" not in self.sets and not any(plate.moves for plate in self.plates):
            raise InputError("no node is bonded and no platen can be touched; check the boundary")

    @property
    def points(self) -> Array:
        """(n_nodes, 3) nodes of the sample [mm]."""
        return self.mesh.points / MM

    @property
    def sets(self) -> dict[str, NDArray[Any]]:
        """Node sets that are not empty: BASE (fixed), BONDED (moved), FREE (may touch)."""
        held = self.boundary.held
        sets: dict[str, NDArray[Any]] = {
            "BASE": np.flatnonzero(held == BASE),
            "BONDED": np.flatnonzero(held == PLATEN),
            "FREE": self.boundary.candidates,
        }
        return {name: ids for name, ids in sets.items() if len(ids)}

    @property
    def angle(self) -> float:
        """Angle by which what is glued turns about the axis (0, 0, z) at last [rad]."""
        return self.boundary.spin * self.travel

    @property
    def displacement(self) -> Array:
        """(3,) final displacement of what moves [mm]; zero of what turns."""
        return self.boundary.direction * (0.0 if self.angle else self.travel / MM)

    @cached_property
    def plates(self) -> list[Plate]:
        """What free nodes can touch: platens, wider than the sample by its height, or a ball."""
        if not len(self.boundary.candidates):
            return []
        base, moving = self.boundary.friction
        if self.boundary.ball[3]:
            return [Plate("PLATEN", _cap(self.boundary.ball), moves=True, friction=moving)]
        rigid = zip(self.boundary.planes, ("BASEPLATE", "PLATEN"), (base, moving), strict=True)
        return [
            Plate(name, self._block(normal * offset / MM, normal), normal > 0.0, friction)
            for (*_, normal, offset), name, friction in rigid
            if np.isfinite(offset)
        ]

    def _block(self, height: float, normal: float) -> HexMesh:
        """One hexahedron [mm] from a height on, away from the sample."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        reach = high[2] - low[2]
        (x0, y0), (x1, y1) = low[:2] - reach, high[:2] + reach
        ring = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
        levels = sorted((height, height + normal * reach / 4.0))
        return HexMesh(np.array([(x, y, z) for z in levels for x, y in ring]), np.arange(8)[None])

    @property
    def penalty(self) -> float:
        """Contact stiffness [N/mm3], a hundred times that of an element: no gap to be seen."""
        return 100.0 * self.material.bulk_modulus / MPA / (self.mesh.edge_length / MM)

    @property
    def header(self) -> list[str]:
        """Lines for the head of a file."""
        along = ", ".join(f"{u:.6g}" for u in self.displacement)
        motion = f"is displaced by ({along}) mm"
        if self.angle:
            motion = f"turns by {self.angle:.6g} rad about the loading axis"
        return [
            "Test of a soft tissue sample. Consistent units: mm, N, MPa (N/mm2).",
            f"Base plane z = 0, loading axis z; what moves {motion}.",
        ]


def _cap(ball: tuple[float, float, float, float]) -> HexMesh:
    """Lower part of a ball [mm] of given centre and radius [m], one layer of hexahedra."""
    x, y, z, radius = np.array(ball) / MM
    rings = np.linspace(0.0, CAP_REACH * radius, CAP_RINGS + 1)
    disc = extruded(*disc_of(rings, rings[-1]), np.array([0.0, 0.25 * radius]))
    down = np.sqrt(radius**2 - (disc.points[:, :2] ** 2).sum(axis=1))
    points = disc.points + np.array([x, y, z])
    points[:, 2] -= down
    return HexMesh(points, disc.hexes)
