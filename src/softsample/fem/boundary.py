"""What holds the sample in a test: its ends and, where there are any, walls."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsample.arrays import Array, Ids
from softsample.errors import InputError
from softsample.fem.motion import BASE, FREE, PLATEN, Platens
from softsample.meshing.bond import bonded_area
from softsample.meshing.mesh import HexMesh, face_vectors
from softsample.protocol import DIRECTIONS
from softsample.shapes import BONDED, SLIDING, Indenter

PlatenEnds = str | float
"""What ends do on platens: BONDED, SLIDING or a coefficient of friction."""

Ends = PlatenEnds | Indenter
"""What holds a sample: platens, or an indenter and a base that it is bonded to."""


@dataclass(frozen=True)
class ContactSettings:
    """Rules of contact with the rigid, rough (no-slip) platens; mirrors config `contact:`.

    Parameters
    ----------
    release : bool
        Whether a node lets go of a platen that would have to pull on it.
    side_walls : bool
        Whether nodes of the side walls can touch the moving platen; if not, only nodes of
        faces that look up (normal z above 0.2) can.
    base_platen : bool
        Whether nodes of the side walls can fold onto the base platen.
    friction : float, optional
        Coefficient of Coulomb friction at the moving platen; none (default) for what the ends
        of the test say, and no slip if they are bonded.
    base_friction : float, optional
        Coefficient at the base, on which the sample then lies; none (default) for what the ends
        say, and a glued base if they are bonded.
    """

    release: bool = True
    side_walls: bool = True
    base_platen: bool = True
    friction: float | None = None
    base_friction: float | None = None


@dataclass(frozen=True)
class Boundary:
    """Boundary conditions of one test.

    Parameters
    ----------
    held : (n_nodes,) int8
        FREE, BASE or PLATEN at the start.
    candidates : (m,) int32
        Free nodes that may touch a platen.
    planes : (2, 4) float64
        Base and moving platen: unit normal from the sample into the platen, offset [m].
    direction : (3,) float64
        Unit vector of the moving platen's travel.
    release : bool
        Whether touching nodes can let go.
    friction : tuple of float
        Coefficients of Coulomb friction in contact with base and moving platen; infinite for
        no slip. Nodes that are held from the start and no candidates do not slip.
    confined : tuple of int
        Axes along which walls without friction keep every node from moving.
    local : bool
        Whether the force of the moving platen stands for that of the test, and not its mean with
        that of the base.
    ball : tuple of float
        Centre at zero travel and radius [m] of a ball that stands for the moving platen; a radius
        of zero stands for the plane.
    spin : float
        Angle by which the moving platen turns about the z axis over its travel [rad/m], that of
        a point on the sample's rim; zero for one that does not turn. Forces along the direction
        are then torques times it, and work on the travel as torques do on the angle.
    """

    held: NDArray[np.int8]
    candidates: NDArray[np.int32]
    planes: Array
    direction: Array
    release: bool = False
    friction: tuple[float, float] = (np.inf, np.inf)
    confined: tuple[int, ...] = ()
    local: bool = False
    ball: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    spin: float = 0.0

    def platens(self) -> Platens:
        """Kernel argument `platens`."""
        return Platens(
            (self._glued(BASE), self._glued(PLATEN)), self.candidates, self.planes,
            np.array(self.ball), np.array(self.friction), self.direction, self.spin, self.release,
            np.where(np.isin(np.arange(3), self.confined), 0.0, 1.0),
        )  # fmt: skip

    def _glued(self, holder: int) -> NDArray[np.int32]:
        """Nodes held for good: those held from the start that their platen cannot let go."""
        return np.setdiff1d(np.flatnonzero(self.held == holder), self.candidates).astype(np.int32)


def _held(mesh: HexMesh, glued: Ids) -> NDArray[np.int8]:
    held = np.full(len(mesh.points), FREE, dtype=np.int8)
    held[glued] = PLATEN
    held[mesh.bottom] = BASE
    return held


def mode_boundary(
    mesh: HexMesh, mode: str, glued: Ids, contact: ContactSettings, ends: Ends = BONDED
) -> Boundary:
    """Boundary conditions of a test mode.

    Parameters
    ----------
    mesh : HexMesh
        The sample on its base.
    mode : str
        `tension`, `compression`, `shear`, `pure_shear` (planar tension: a strip whose width, along
        x, is kept), `confined_compression` (in a chamber of the sample's own section) or
        `indentation`, whose `ends` are an `Indenter`, or `torsion` about the z axis, whose travel
        is that of a point on the rim of a round top of the bonded area.
    glued : (m,) int64
        Top nodes that follow the platen where it does not meet the sample by contact.
    contact : ContactSettings
        Rules of contact in both compressions; its coefficients of friction, where given, are
        used in place of `ends`.
    ends : str or float
        `bonded`: no slip, the base glued; `sliding`: no friction at either end; a number:
        Coulomb's coefficient at both, in compression only. Confined compression has no friction
        whatever the ends are.

    Raises
    ------
    InputError
        If the mode cannot be tested with such ends, or no node is glued.

    Notes
    -----
    Sliding ends bear no lateral force, hence the sample's lateral momentum stays zero: nothing
    holds it sideways, and nothing needs to. ``tests/verification/test_ends.py`` has the closed
    forms of all tests with sliding ends.
    """
    if isinstance(ends, Indenter) != (mode == "indentation"):
        raise InputError(f"ends: {mode} with {ends!r}; an indenter belongs to indentation alone")
    if isinstance(ends, Indenter):
        _check_ends("compression", ends.ends)
        return indenter_boundary(mesh, rubbing(contact, ends.ends), ends.kind, ends.radius)
    _check_ends(mode, ends)
    if mode == "compression":
        return platen_boundary(mesh, rubbing(contact, ends))
    if mode == "confined_compression":
        smooth = replace(contact, friction=0.0, base_friction=0.0)
        return replace(platen_boundary(mesh, smooth), confined=(0, 1))
    if mode == "torsion":
        held = glued_boundary(mesh, mode, glued)
        radius = np.sqrt(bonded_area(mesh, glued).sum() / np.pi)
        return replace(held, spin=float(1.0 / radius))
    if ends == BONDED:
        return glued_boundary(mesh, mode, glued)
    return _sliding_boundary(mesh, mode, glued)


def _check_ends(mode: str, ends: PlatenEnds) -> None:
    """Refuse ends that are none, and those that a mode cannot have."""
    valid = ends in (BONDED, SLIDING) if isinstance(ends, str) else 0.0 <= ends < np.inf
    if not valid:
        raise InputError(
            f"ends: {ends!r} is neither {BONDED}, {SLIDING} nor a coefficient of friction >= 0"
        )
    if mode == "torsion" and ends != BONDED:
        raise InputError(f"ends: {ends} would turn on a sample in torsion; choose {BONDED}")
    if not isinstance(ends, str) and mode in ("tension", "shear", "pure_shear"):
        raise InputError(
            f"ends: friction ({ends:g}) holds no sample in {mode}; choose {BONDED} or {SLIDING}"
        )
    if mode == "shear" and ends == SLIDING:
        raise InputError(
            f"ends: {SLIDING} leaves simple shear homogeneous, which needs no simulation; its "
            f"force is a closed form. Choose {BONDED} for a sheared sample with free sides"
        )


def rubbing(contact: ContactSettings, ends: PlatenEnds) -> ContactSettings:
    """Rules of contact with the friction of the ends, where they give none themselves."""
    if ends == BONDED:
        return contact
    friction = 0.0 if isinstance(ends, str) else float(ends)
    return replace(
        contact,
        friction=friction if contact.friction is None else contact.friction,
        base_friction=friction if contact.base_friction is None else contact.base_friction,
    )


def _sliding_boundary(mesh: HexMesh, mode: str, glued: Ids) -> Boundary:
    """Ends that move with their platens along z alone; planar tension keeps the width, along x."""
    bonded = glued_boundary(mesh, mode, glued)
    return replace(
        bonded,
        candidates=np.flatnonzero(bonded.held != FREE).astype(np.int32),
        friction=(0.0, 0.0),
        confined=(0,) if mode == "pure_shear" else (),
    )


def glued_boundary(mesh: HexMesh, mode: str, glued: Ids) -> Boundary:
    """Base fixed, `glued` nodes moved rigidly: bonded ends in tension, shear and planar tension."""
    if len(glued) == 0:
        raise InputError("no node of the mesh is bonded to the platen; check the bond")
    # ASSUME: the adhesive neither yields nor slips, and the platens are rigid.
    nowhere = np.array([[0.0, 0.0, -1.0, np.inf], [0.0, 0.0, 1.0, np.inf]])
    return Boundary(
        _held(mesh, glued), np.empty(0, dtype=np.int32), nowhere, np.array(DIRECTIONS[mode])
    )


def platen_boundary(
    mesh: HexMesh,
    contact: ContactSettings,
    *,
    tilt_deg: tuple[float, float] = (0.0, 0.0),
    gap: float = 0.0,
) -> Boundary:
    """A rigid flat platen coming down: compression tests.

    Parameters
    ----------
    mesh : HexMesh
        The sample on its base.
    contact : ContactSettings
        Rules of contact.
    tilt_deg : tuple of float
        Rotation of the platen about x and y [degrees], in this order.
    gap : float
        Way of the platen before it gets there [m], not negative.
    """
    if gap < 0.0:
        raise InputError(f"gap: {gap:g} m would put the platen into the sample; 0 is the least")
    base_glued = contact.base_friction is None
    held = _held(mesh, np.empty(0, dtype=np.int64))
    touchable = mesh.boundary if contact.side_walls else _upward_nodes(mesh)
    candidates = touchable[held[touchable] == FREE]
    if not base_glued:
        candidates = np.union1d(candidates, mesh.bottom)
    normal = _tilted(tilt_deg)
    # ASSUME: at zero displacement the platen meets the highest point; the paper fixes no zero.
    top = (mesh.points[candidates] @ normal).max()
    base_offset = 0.0 if contact.base_platen or not base_glued else np.inf
    planes = np.array([[0.0, 0.0, -1.0, base_offset], [*normal, top + gap * normal[2]]])
    down, friction = np.array(DIRECTIONS["compression"]), _coefficients(contact)
    return Boundary(held, candidates.astype(np.int32), planes, down, contact.release, friction)


def indenter_boundary(
    mesh: HexMesh, contact: ContactSettings, kind: str, radius: float
) -> Boundary:
    """A rigid indenter on the z axis that touches the first node: indentation.

    Parameters
    ----------
    mesh : HexMesh
        The sample on its base, which is glued.
    contact : ContactSettings
        Rules of contact; the friction is that of the moving platen.
    kind : {"sphere", "flat"}
        The nodes of the upper side within the radius of a punch meet its flat end; those of all
        of the upper side may meet a ball.
    radius : float
        Of the indenter [m].

    Raises
    ------
    InputError
        If no node of the mesh lies below a punch.
    """
    held = _held(mesh, np.empty(0, dtype=np.int64))
    upper = _upward_nodes(mesh)
    upper = upper[held[upper] == FREE]
    away = np.hypot(*mesh.points[upper, :2].T)
    height = mesh.points[upper, 2]
    planes = np.array([[0.0, 0.0, -1.0, np.inf], [0.0, 0.0, 1.0, np.inf]])
    ball = (0.0, 0.0, 0.0, 0.0)
    if kind == "flat":
        below = away <= radius * (1.0 + 1e-6)
        if not below.any():
            raise InputError(
                f"no node of the mesh lies below a punch of radius {1e3 * radius:g} mm; choose "
                "smaller elements"
            )
        upper = upper[below]
        planes[1, 3] = height[below].max()
    else:
        near = away < radius
        centre = (height[near] + np.sqrt(radius**2 - away[near] ** 2)).max()
        ball = (0.0, 0.0, float(centre), radius)
    down, friction = np.array(DIRECTIONS["indentation"]), (np.inf, _coefficients(contact)[1])
    touching = upper.astype(np.int32), planes, down, contact.release, friction
    return Boundary(held, *touching, local=True, ball=ball)


def _coefficients(contact: ContactSettings) -> tuple[float, float]:
    """Of friction at base and platen, infinite where the sample sticks."""
    base, moving = contact.base_friction, contact.friction
    return np.inf if base is None else base, np.inf if moving is None else moving


def _tilted(angles_deg: tuple[float, float]) -> Array:
    """Unit normal of a plane z = const. after rotations about x and y [degrees]."""
    about_x, about_y = np.deg2rad(angles_deg)
    return np.array(
        [np.sin(about_y) * np.cos(about_x), -np.sin(about_x), np.cos(about_y) * np.cos(about_x)]
    )


def _upward_nodes(mesh: HexMesh) -> Ids:
    """Nodes of boundary faces whose unit normal has a z component above 0.2."""
    normal = face_vectors(mesh.points, mesh.boundary_quads)
    up = normal[:, 2] > 0.2 * np.linalg.norm(normal, axis=1)
    return np.unique(mesh.boundary_quads[up])
