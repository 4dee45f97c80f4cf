"""Hexahedral mesh of a solid that is given by a signed distance grid."""

import logging

import numpy as np

from softsample.arrays import Array, Ids, Mask
from softsample.errors import MeshError
from softsample.meshing.castellate import add_buffer, castellated_mesh, core_cells
from softsample.meshing.levelset import LevelSet
from softsample.meshing.mesh import HexMesh
from softsample.meshing.optimise import Problem, Stage, optimise
from softsample.meshing.quality import check_topology, scaled_jacobian

LOGGER = logging.getLogger(__name__)


CORE_DEPTH = 1.0
"""Depth of a cell's centre below the surface [elements] from which on it is core: half an element
and more is left for the buffer layer."""

VOLUME_WEIGHT = 0.5
"""Weight of equal volumes against equal edges and right angles: shape goes before size."""

STAGES = (Stage(5.0, 0.3, 60), Stage(50.0, 1e-3, 60), Stage(200.0, 1e-3, 60))
"""Minimisations: weight of the squared distance to the surface, barrier, L-BFGS steps at most. In
the first the barrier lets folded corners untangle; by the last the nodes lie on the surface."""

LEAST_JACOBIAN = 0.2
"""Scaled Jacobian below which an element is refused; what is left has room to deform."""


def mesh_solid(distance: Array, origin: Array, spacing: float, element_size: float) -> HexMesh:
    """Hexahedra that fill a solid standing on the base plane z = 0.

    A core of grid cells aligned with the sample frame, cleaned until its surface is manifold,
    gets one buffer layer on its sides and top. All nodes then move to the least energy of
    element distortion plus squared distance of the surface nodes to the surface; base nodes keep
    z = 0. At last the surface nodes are put where the faces, which are chords, lie on the surface
    in the mean, so that the mesh has the solid's volume; the highest point becomes a node.

    Parameters
    ----------
    distance : (nx, ny, nz) float
        Signed distance [m], negative inside; the walls go on below the base plane, so that the
        surface crosses z = 0.
    origin : (3,) float
        Position [m] of grid point ``[0, 0, 0]`` in the sample frame.
    spacing : float
        Grid spacing [m].
    element_size : float
        Wanted edge of the elements [m].

    Returns
    -------
    HexMesh
        Points [m] in the sample frame.

    Raises
    ------
    MeshError
        If the grid is not usable, the elements are too coarse for the sample, or an element is
        worse than `LEAST_JACOBIAN`.

    Notes
    -----
    Verified in ``tests/unit/test_meshing_hexahedral.py``.
    """
    if not element_size > 0.0:
        raise MeshError(f"element size is {element_size} m: give a positive length")
    surface = LevelSet(distance, origin, spacing)
    _warn_of_spikes(surface)
    low, high = surface.inside_box
    cells, corner = core_cells(lambda points: -surface(points), low, high, element_size, CORE_DEPTH)
    mesh, inner = add_buffer(castellated_mesh(cells, corner, element_size))
    mesh = _fit(mesh, inner, surface, element_size)
    _refuse_bad(mesh, element_size)
    return mesh


def _warn_of_spikes(surface: LevelSet) -> None:
    """Log a warning where the signed distance changes faster than a distance can."""
    slope, place = surface.steepest
    if slope > 2.0:
        x, y, z = 1e3 * place
        LOGGER.warning(
            "signed distance changes %.1f times as fast as a distance at (%.1f, %.1f, %.1f) mm: "
            "look at the image or surface there",
            slope, x, y, z,
        )  # fmt: skip


def _fit(mesh: HexMesh, inner: Ids, surface: LevelSet, size: float) -> HexMesh:
    """Move the nodes of a buffered core (see `add_buffer`) to the surface and optimise them."""
    outer = np.arange(len(mesh.points) - len(inner), len(mesh.points))
    base = mesh.points[:, 2] == 0.0
    start = mesh.points.copy()
    start[outer] = _spread(mesh, surface.project(start[outer], base[outer]), outer, base, surface)
    pin = outer[[np.argmin(np.sum((start[outer] - surface.highest_point) ** 2, axis=1))]]

    def scaled_distance(points: Array) -> tuple[Array, Array]:
        value, gradient = surface.with_gradient(size * points)
        return value / size, gradient

    problem = Problem(
        hexes=mesh.hexes,
        free=np.column_stack([np.ones((len(start), 2), dtype=bool), ~base]),
        surface=outer,
        faces=mesh.boundary_quads[np.isin(mesh.boundary_quads, outer).all(axis=1)],
        distance=scaled_distance,
        pins=pin,
        targets=surface.highest_point[None] / size,
        volume_weight=VOLUME_WEIGHT,
    )
    points = start / size
    for stage in STAGES:
        points = optimise(problem, points, stage)
    return _snap(HexMesh(size * points, mesh.hexes), outer, base, pin, surface)


def _spread(mesh: HexMesh, points: Array, outer: Ids, base: Mask, surface: LevelSet) -> Array:
    """Even out projected surface nodes: means over neighbours, projected again."""
    quads = mesh.quads_among(outer)
    quads = quads[np.all(quads >= 0, axis=1)]
    ends = np.concatenate([quads, np.roll(quads, -1, axis=1)], axis=1).reshape(-1, 2, 4)
    a, b = ends.transpose(1, 0, 2).reshape(2, -1)
    keep = base[outer][a] <= base[outer][b]  # a rim node follows rim nodes only
    a, b = a[keep], b[keep]
    rim = base[outer]
    for _ in range(5):
        total, count = np.zeros_like(points), np.zeros(len(points))
        for i, j in ((a, b), (b, a)):
            allowed = ~rim[i] | rim[j]
            np.add.at(total, i[allowed], points[j[allowed]])
            np.add.at(count, i[allowed], 1.0)
        points = 0.5 * points + 0.5 * total / count[:, None]
        points[rim, 2] = 0.0
        points = surface.project(points, rim, steps=3)
    return points


def _snap(mesh: HexMesh, outer: Ids, base: Mask, pin: Ids, surface: LevelSet) -> HexMesh:
    """Put the faces on the surface in the mean, as far as no element gets much worse by it."""
    goal = surface.project(mesh.points[outer], base[outer])
    sagitta = _sagitta(mesh, goal, outer, surface)
    goal = surface.project(goal, base[outer], level=sagitta)
    goal[:, 2] = np.minimum(goal[:, 2], surface.highest_point[2])
    goal[np.isin(outer, pin)] = surface.highest_point
    before = scaled_jacobian(mesh)
    part = np.ones(len(outer))
    for _ in range(6):
        points = mesh.points.copy()
        points[outer] += part[:, None] * (goal - points[outer])
        moved = HexMesh(points, mesh.hexes)
        after = scaled_jacobian(moved)
        worse = (after < 0.6) & (after < before - 0.05)
        if not worse.any():
            break
        part[np.isin(outer, mesh.hexes[worse])] *= 0.5
    return moved


def _sagitta(mesh: HexMesh, places: Array, outer: Ids, surface: LevelSet) -> Array:
    """(n,) mean depth [m] of the faces around each surface node, were the nodes at `places`."""
    quads = mesh.quads_among(outer)
    quads = quads[np.all(quads >= 0, axis=1)]
    near, far = 0.5 * (1.0 + np.array([1.0, -1.0]) / np.sqrt(3.0))
    depth = np.zeros(len(quads))
    for turn in range(4):  # the four Gauss points of a face
        weight = np.roll([near * near, near * far, far * far, near * far], turn)
        depth -= 0.25 * surface(np.einsum("c,qci->qi", weight, places[quads]))
    total = np.bincount(quads.ravel(), np.repeat(depth, 4), minlength=len(outer))
    return total / np.bincount(quads.ravel(), minlength=len(outer))


def _refuse_bad(mesh: HexMesh, size: float) -> None:
    """Raise MeshError if the surface is torn or an element is too distorted."""
    check_topology(mesh)
    jacobian = scaled_jacobian(mesh)
    worst = int(np.argmin(jacobian))
    if jacobian[worst] < LEAST_JACOBIAN:
        place = 1e3 * mesh.points[mesh.hexes[worst]].mean(axis=0)
        raise MeshError(
            f"{int(np.sum(jacobian < LEAST_JACOBIAN))} elements of {1e3 * size:.3g} mm have a "
            f"scaled Jacobian below {LEAST_JACOBIAN:g}, the worst {jacobian[worst]:.3f} at "
            f"({place[0]:.1f}, {place[1]:.1f}, {place[2]:.1f}) mm: choose another mesh: "
            "element_size_mm, or smooth the segmentation there"
        )
