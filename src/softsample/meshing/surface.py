"""A closed surface of triangles as the signed distance grid that the mesher takes."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skimage.measure import marching_cubes

from softsample.arrays import Array, Ids, Mask
from softsample.errors import MeshError
from softsample.meshing.mesh import HexMesh

LONGEST, SMALLEST = 0.1, 3e-3**3
"""Length of a sample [m] at most, volume of the box about it [m3] at least; anything else was
written in another unit."""

UNITS = {"m": 1e3, "cm": 10.0, "inches": 25.4, "µm": 1e-3}
"""Units that a surface may have been written in, and their size in mm."""

FLAT = 1e-2
"""Corners this near to the lowest point, in heights of the surface, lie in the base."""

LEAST_BASE = 0.05
"""Least area of the base, in areas of the box around the surface."""

UNDERSIDE, MOST_OF_UNDERSIDE = 0.1, 0.75
"""What looks down in this part of the height is the underside, of which the base is this part at
least: of a tilted face only a strip is lowest."""


@dataclass(frozen=True, eq=False)
class TriangleSurface:
    """Triangles, outward by the right-hand rule.

    Parameters
    ----------
    points : (n, 3) float64
        Corners [m].
    triangles : (m, 3) int64
        Corners of each triangle.
    source : str
        Where it comes from, for messages.
    """

    points: Array
    triangles: Ids
    source: str = "surface"

    @property
    def area_vectors(self) -> Array:
        """(m, 3) outward normals times area [m2]."""
        a, b, c = self.points[self.triangles].transpose(1, 0, 2)
        return 0.5 * np.cross(b - a, c - a)

    @property
    def volume(self) -> float:
        """Volume inside [m3], negative if the triangles look inward."""
        inner = self.points[self.triangles[:, 0]] - self.points[0]
        return float(np.sum(inner * self.area_vectors) / 3.0)

    @property
    def sides(self) -> Ids:
        """(3 m, 2) sides of the triangles, in their sense; side k starts at corner k."""
        return np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=-1).reshape(
            -1, 2
        )

    @property
    def free_sides(self) -> Mask:
        """(3 m,) sides without a neighbour."""
        _, place, count = np.unique(
            np.sort(self.sides, axis=1), axis=0, return_inverse=True, return_counts=True
        )
        return np.asarray(count[place.ravel()] == 1)

    def moved(self, rigid_mm: Array) -> "TriangleSurface":
        """The surface after a rigid map (4, 4) whose lengths are in mm."""
        points = self.points @ rigid_mm[:3, :3].T + 1e-3 * rigid_mm[:3, 3]
        return TriangleSurface(points, self.triangles, self.source)

    def check_closed(self) -> None:
        """Refuse what is no closed, manifold surface of one sample that looks outward.

        Raises
        ------
        MeshError
            Naming the source, the fault and its cure.
        """
        if len(self.triangles) == 0:
            raise MeshError(f"{self.source}: holds no triangles; export the surface again")
        extent = np.ptp(self.points[self.triangles].reshape(-1, 3), axis=0)
        if not _is_plausible(extent):
            size = " x ".join(f"{1e3 * length:.4g}" for length in extent)
            units = (name for name, factor in UNITS.items() if _is_plausible(factor * extent))
            guess = f" (is it in {unit}?)" if (unit := next(units, "")) else ""
            raise MeshError(
                f"{self.source}: {size} mm large{guess}, expected {1e9 * SMALLEST:g} mm3 at least "
                f"and {1e3 * LONGEST:g} mm at most; export the surface in mm"
            )
        _, count = np.unique(np.sort(self.sides, axis=1), axis=0, return_counts=True)
        if np.any(count != 2):
            raise MeshError(
                f"{self.source}: not a closed surface, {int(np.sum(count == 1))} edges have one "
                f"triangle and {int(np.sum(count > 2))} more than two; close its holes, merge its "
                "points and remove inner walls"
            )
        if len(np.unique(self.sides, axis=0)) != len(self.sides):
            raise MeshError(
                f"{self.source}: neighbouring triangles look to opposite sides; make the normals "
                "consistent, outward"
            )
        if self.volume <= 0.0:
            raise MeshError(f"{self.source}: its normals look inward; flip them")
        parts = self._parts()
        if parts != 1:
            raise MeshError(
                f"{self.source}: consists of {parts} separate surfaces; keep the sample's outer one"
            )

    def _parts(self) -> int:
        """Number of surfaces that do not hang together."""
        used, sides = np.unique(self.sides, return_inverse=True)
        a, b = sides.reshape(-1, 2).T
        links = coo_matrix((np.ones(len(a)), (a, b)), shape=(len(used), len(used)))
        return int(connected_components(links, directed=False)[0])


def _is_plausible(extent: Array) -> bool:
    """Whether a surface of an extent (3,) [m] may be that of a sample; not of NaN."""
    return bool(np.prod(extent) >= SMALLEST and extent.max() <= LONGEST)


def distance_grid(
    surface: TriangleSurface, spacing: float, padding: float = 2.5e-3
) -> tuple[Array, Array, float]:
    """Signed distance to a surface that stands on a flat base, as `mesh_solid` takes it.

    The lowest face, which has to be flat and square to z, is the base: it comes to z = 0 and its
    centroid to the origin. It is no part of the surface, since the walls go on through it with
    their slope.

    Parameters
    ----------
    surface : TriangleSurface
        Closed; the loading axis is +z.
    spacing : float
        Of the grid [m]; the spline through it rounds sharp edges by about a tenth of it.
    padding : float
        Width of the rim of the grid around the surface [m].

    Returns
    -------
    distance : (nx, ny, nz) float64
        Signed distance [m], negative inside.
    origin : (3,) float64
        Position [m] of grid point ``[0, 0, 0]``.
    spacing : float
        As given.

    Raises
    ------
    MeshError
        If `surface` is not closed or has no flat base.

    Notes
    -----
    The sign is that of the angle-weighted normal at the nearest point [1]_. Verified in
    ``tests/unit/test_meshing_surface.py``.

    References
    ----------
    .. [1] J. A. Baerentzen, H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243,
       doi:10.1109/TVCG.2005.49.
    """
    if not (spacing > 0.0 and padding > 0.0):
        raise MeshError(f"spacing {spacing} m and padding {padding} m: give positive lengths")
    surface.check_closed()
    walls = _without_base(surface)
    low = np.floor((walls.points.min(axis=0) - padding) / spacing).astype(np.int64)
    high = np.ceil((walls.points.max(axis=0) + padding) / spacing).astype(np.int64)
    axes = [spacing * np.arange(low[a], high[a] + 1) for a in range(3)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    below = _with_skirt(walls, padding + 3.0 * spacing)
    distance = signed_distances(below, places.reshape(-1, 3))
    return distance.reshape(places.shape[:3]), spacing * low, spacing


def signed_distances(surface: TriangleSurface, points: Array) -> Array:
    """(n,) signed distance [m] of `points` (n, 3) [m] to the triangles, negative inside."""
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(surface.points, surface.triangles)
    found = pyvista.PolyData(points).compute_implicit_distance(mesh)
    return np.array(found["implicit_distance"])


def boundary_surface(mesh: HexMesh) -> TriangleSurface:
    """The boundary of a mesh, each of its quads cut in two triangles."""
    quads = mesh.boundary_quads
    used, places = np.unique(quads[:, [0, 1, 2, 0, 2, 3]], return_inverse=True)
    return TriangleSurface(mesh.points[used], places.reshape(-1, 3), "boundary of the mesh")


def level_surface(distance: Array, origin: Array, spacing: float) -> TriangleSurface:
    """Closed surface of a sample from its signed distance, the reverse of `distance_grid`.

    Parameters
    ----------
    distance : (nx, ny, nz) float64
        Signed distance [m], negative inside; the walls go on below the base plane z = 0.
    origin : (3,) float64
        Position [m] of grid point ``[0, 0, 0]``.
    spacing : float
        Of the grid [m].

    Returns
    -------
    TriangleSurface
        Cut off at z = 0 and closed by a flat base.
    """
    heights = origin[2] + spacing * np.arange(distance.shape[2])
    first = int(np.argmax(heights > 1e-6 * spacing))
    share = heights[first] / spacing
    base = share * distance[..., first - 1] + (1.0 - share) * distance[..., first]
    # outside begins right below the base: the two lowest layers have the same height
    below = np.full_like(base, 1e6 * spacing)
    layers = np.concatenate([below[..., None], base[..., None], distance[..., first:]], axis=2)
    levels = np.concatenate([[0.0, 0.0], heights[first:]])
    corners, triangles, _, _ = marching_cubes(layers, 0.0, gradient_direction="descent")
    points = origin + spacing * corners.astype(np.float64)
    points[:, 2] = np.interp(corners[:, 2], np.arange(len(levels)), levels)
    return TriangleSurface(points, triangles.astype(np.int64), "surface of the sample")


def base_centre(surface: TriangleSurface) -> Array:
    """Centroid of the flat lowest face, (3,) [m].

    Raises
    ------
    MeshError
        If the lowest face is not flat and square to z.
    """
    points = surface.points[surface.triangles]
    low, high = (f(points.reshape(-1, 3), axis=0) for f in (np.min, np.max))
    base = _underside(surface, FLAT)
    area = -surface.area_vectors[base, 2]
    under = -surface.area_vectors[_underside(surface, UNDERSIDE), 2].sum()
    if area.sum() < max(LEAST_BASE * np.prod((high - low)[:2]), MOST_OF_UNDERSIDE * under):
        raise MeshError(
            f"{surface.source}: its lowest face is not flat ({1e6 * area.sum():.3g} mm2 lie at "
            f"z = {1e3 * low[2]:.4g} mm); turn the surface so that the loading axis is +z, and cut "
            "the base flat"
        )
    middle = area @ points[base].mean(axis=1) / area.sum()
    return np.array([middle[0], middle[1], low[2]])


def _underside(surface: TriangleSurface, part: float) -> Mask:
    """(m,) triangles that look down and lie in the lowest part of the height."""
    height = surface.points[surface.triangles, 2]
    flat = height <= height.min() + part * np.ptp(height)
    vectors = surface.area_vectors
    downward = vectors[:, 2] < -0.9 * np.linalg.norm(vectors, axis=1)
    return np.asarray(downward & flat.all(axis=1))


def _without_base(surface: TriangleSurface) -> TriangleSurface:
    """Walls and top in the sample frame: the base, now open, at z = 0 about the origin."""
    centre, base = base_centre(surface), _underside(surface, FLAT)
    points = surface.points - centre
    points[np.unique(surface.triangles[base]), 2] = 0.0
    return TriangleSurface(points, surface.triangles[~base], surface.source)


def _with_skirt(walls: TriangleSurface, depth: float) -> TriangleSurface:
    """Walls carried on below their rim by `depth` [m], each with its own slope.

    A rim node goes down along the line in the planes of the two wall triangles at its sides;
    where these are nearly one plane, straight down it.
    """
    free = walls.free_sides
    a, b = walls.sides[free].T
    normal = np.repeat(walls.area_vectors, 3, axis=0)[free]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)  # slivers have none
    square = np.zeros((len(walls.points), 2, 2))
    right = np.zeros((len(walls.points), 2))
    for ends in (a, b):
        np.add.at(square, ends, normal[:, :2, None] * normal[:, None, :2])
        np.add.at(right, ends, normal[:, :2] * normal[:, 2:])
    rim = np.unique(a)
    slope = np.einsum("nij,nj->ni", np.linalg.pinv(square[rim], rcond=0.1), right[rim])
    slope /= np.maximum(np.linalg.norm(slope, axis=1), 1.0)[:, None]  # at most 45 degrees
    lower = walls.points[rim] + depth * np.column_stack([slope, -np.ones(len(rim))])
    below_a, below_b = (len(walls.points) + np.searchsorted(rim, ends) for ends in (a, b))
    skirt = [np.column_stack([b, a, below_a]), np.column_stack([b, below_a, below_b])]
    return TriangleSurface(
        np.concatenate([walls.points, lower]),
        np.concatenate([walls.triangles, *skirt]),
        walls.source,
    )
